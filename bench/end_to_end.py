#!/usr/bin/env python3
"""Plans every task with many seeds, refines and checks every plan and says how often, how fast and with how much memory.

    bench/end_to_end.py [--seeds 20] [--first-seed 0] [--timeout 20] [--program build/release/stiction] [--beside OTHER] [TASK …] > end_to_end.json

One JSON object on stdout; a line for each run on stderr. Times are those of `stiction plan` and `stiction refine` together, as the programs
run; a plan is accepted when `stiction check` accepts it as planned and as refined. Exit code 1 when one was not solved or not accepted.
"""

import argparse
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile

from runs import ROOT, exit_with, measure_run

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


def refused(program, plan):
    """Names of what `stiction check` does not accept."""
    done = measure_run([program, "check", plan, "--json"])
    checks = json.loads(done.text).get("checks", []) if done.text else []
    return [item["name"] for item in checks if not item["pass"]] or (["no report"] if done.code else [])


def plan_and_refine(program, task, seed, timeout, out):
    """What one seed comes to, and the names of what is not accepted of it."""
    planned = measure_run([program, "plan", task, "--seed", seed, "--timeout", timeout, "-o", out, "--json"])
    if planned.code not in (0, 3):
        raise RuntimeError(f"{task} seed {seed}: {program} ends with exit code {planned.code}")
    plan = json.loads(planned.text)
    peak, processor, wall = planned.peak_mb, planned.processor_s, planned.wall_s
    failed = [f"plan {name}" for name in refused(program, out)]
    if planned.code == 0:
        refined = measure_run([program, "refine", out, "--json"])
        peak, processor, wall = max(peak, refined.peak_mb), processor + refined.processor_s, wall + refined.wall_s
        failed += [f"refined {name}" for name in refused(program, out / "refined")]
    print(
        f"{task} seed {seed}: {plan['status']} in {plan['wall_s']:.2f} s, refined in {wall:.2f} s ({processor:.2f} s of processors), "
        f"{plan['knots']} knots, {plan['regrasps']['in_plan']} regrasps, {peak:.0f} MB, "
        f"check {'failed: ' + ', '.join(failed) if failed else 'passed'}",
        file=sys.stderr,
    )
    return {"wall": wall, "processor": processor, "peak": peak, "accepted": planned.code == 0 and not failed}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("tasks", nargs="*", metavar="TASK", help="names or files")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--first-seed", type=int, default=0)
    parser.add_argument("--timeout", type=float, default=20)
    parser.add_argument("--program", type=pathlib.Path, default=ROOT / "build/release/stiction")
    parser.add_argument("--beside", type=pathlib.Path, help="another version of the program, run in turn with it: machines are not equally fast for long; its own built-in tasks")
    arguments = parser.parse_args()

    commit = subprocess.run(["git", "-C", ROOT, "rev-parse", "--short=12", "HEAD"], capture_output=True, text=True).stdout.strip() or None
    programs = [arguments.program] + ([arguments.beside] if arguments.beside else [])
    results = []
    with tempfile.TemporaryDirectory() as folder:
        for task in arguments.tasks or TASKS:
            runs = [[] for _ in programs]
            for seed in range(arguments.first_seed, arguments.first_seed + arguments.seeds):
                for i, program in enumerate(programs):
                    out = pathlib.Path(folder) / f"{pathlib.Path(task).stem}-{seed}-{i}"
                    runs[i].append(plan_and_refine(program, task, seed, arguments.timeout, out))
            times = [run["wall"] for run in runs[0]]
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
                beside = [run["wall"] for run in runs[1]]
                row |= {"mean_s": statistics.mean(times), "beside_median_s": statistics.median(beside), "beside_mean_s": statistics.mean(beside)}
            results.append(row)
    print(json.dumps({"seeds": arguments.seeds, "results": results}))
    return 0 if all(row["accepted"] == row["runs"] for row in results) else 1


if __name__ == "__main__":
    exit_with("end_to_end", main)
