#!/usr/bin/env python3
"""Plans every task with many seeds, refines and checks every plan and says how often, how fast and with how much memory.

    bench/end_to_end.py [--seeds 20] [--timeout 20] [--program build/release/stiction] [--beside OTHER] [TASK …] > end_to_end.json

One JSON object on stdout; a line for each run on stderr. Times are those of `stiction plan` and `stiction refine` together, as the programs
run; a plan is accepted when `stiction check` accepts it as planned and as refined. Exit code 1 when one was not solved or not accepted.
"""

import argparse
import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[1]
TASKS = [
    "planar_pushing",
    "planar_hand",
    "planar_hand_fixed_y",
    "box_grazing",
    "allegro_ball",
    "allegro_cube",
    "allegro_cube_180",
    "allegro_cube_roll",
    "allegro_pen",
    "allegro_plate",
    "allegro_door",
    "iiwa_bimanual_planar",
    "iiwa_bimanual",
    "iiwa_bimanual_box",
    "ur5_mesh_push",
]


def run(*words):
    """Exit code, JSON output, peak resident memory [MB], processor time [s] and wall time [s] of a program."""
    with tempfile.TemporaryFile("w+") as out:
        start = time.monotonic()
        process = subprocess.Popen([str(word) for word in words], stdout=out, stderr=subprocess.DEVNULL)
        _, status, usage = os.wait4(process.pid, 0)
        wall = time.monotonic() - start
        process.returncode = os.waitstatus_to_exitcode(status)
        out.seek(0)
        text = out.read()
    return process.returncode, json.loads(text) if text else {}, usage.ru_maxrss / 1024, usage.ru_utime + usage.ru_stime, wall


def refused(program, plan):
    """Names of what `stiction check` does not accept."""
    code, check, *_ = run(program, "check", plan, "--json")
    return [item["name"] for item in check.get("checks", []) if not item["pass"]] or (["no report"] if code else [])


def plan_and_refine(program, task, seed, timeout, out):
    """What one seed comes to, and the names of what is not accepted of it."""
    code, plan, peak, processor, wall = run(program, "plan", task, "--seed", seed, "--timeout", timeout, "-o", out, "--json")
    if code not in (0, 3):
        print(f"{task} seed {seed}: {program} ends with exit code {code}", file=sys.stderr)
        sys.exit(2)
    failed = [f"plan {name}" for name in refused(program, out)]
    if code == 0:
        _, _, refine_peak, refine_processor, refine_wall = run(program, "refine", out, "--json")
        peak, processor, wall = max(peak, refine_peak), processor + refine_processor, wall + refine_wall
        failed += [f"refined {name}" for name in refused(program, out / "refined")]
    print(
        f"{task} seed {seed}: {plan['status']} in {plan['wall_s']:.2f} s, refined in {wall:.2f} s ({processor:.2f} s of processors), "
        f"{plan['knots']} knots, {plan['regrasps']['in_plan']} regrasps, {peak:.0f} MB, "
        f"check {'failed: ' + ', '.join(failed) if failed else 'passed'}",
        file=sys.stderr,
    )
    return {"wall": wall, "processor": processor, "peak": peak, "accepted": code == 0 and not failed}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("tasks", nargs="*", metavar="TASK", help="names or files")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--first", type=int, default=0, help="of the seeds")
    parser.add_argument("--timeout", type=float, default=20)
    parser.add_argument("--program", type=pathlib.Path, default=ROOT / "build/release/stiction")
    parser.add_argument("--beside", type=pathlib.Path, help="another version of the program, run in turn with it: machines are not equally fast for long")
    arguments = parser.parse_args()

    commit = subprocess.run(["git", "-C", ROOT, "rev-parse", "--short=12", "HEAD"], capture_output=True, text=True).stdout.strip() or None
    programs = [arguments.program] + ([arguments.beside] if arguments.beside else [])
    results = []
    with tempfile.TemporaryDirectory() as folder:
        for task in arguments.tasks or TASKS:
            runs = [[] for _ in programs]
            for seed in range(arguments.first, arguments.first + arguments.seeds):
                for i, program in enumerate(programs):
                    out = pathlib.Path(folder) / f"{pathlib.Path(task).stem}-{seed}-{i}"
                    runs[i].append(plan_and_refine(program, task, seed, arguments.timeout, out))
            times, beside = ([run["wall"] for run in of_program] for of_program in (runs[0], runs[-1]))
            processor_times = [run["processor"] for run in runs[0]]
            row = {
                "task": task,
                "runs": arguments.seeds,
                "commit": commit,
                "accepted": sum(run["accepted"] for run in runs[0]),
                "median_s": statistics.median(times),
                "worst_s": max(times),
                "median_processor_s": statistics.median(processor_times),
                "worst_processor_s": max(processor_times),
                "peak_mb": max(run["peak"] for run in runs[0]),
            }
            if arguments.beside:
                row |= {"mean_s": statistics.mean(times), "beside_median_s": statistics.median(beside), "beside_mean_s": statistics.mean(beside)}
            results.append(row)
    print(json.dumps({"seeds": arguments.seeds, "results": results}))
    return 0 if all(row["accepted"] == row["runs"] for row in results) else 1


if __name__ == "__main__":
    sys.exit(main())
