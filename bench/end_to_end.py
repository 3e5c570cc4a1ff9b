#!/usr/bin/env python3
"""Plans every task with many seeds, checks every plan and says how often, how fast and with how much memory.

    bench/end_to_end.py [--seeds 20] [--timeout 20] [--program build/release/stiction] [TASK …] > end_to_end.json

One JSON object on stdout; a line for each run on stderr. Exit code 1 when a plan was not solved or not accepted.
"""

import argparse
import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile

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
]


def run(words):
    """Exit code, stdout, peak resident memory [MB] and processor time [s] of a program."""
    with tempfile.TemporaryFile("w+") as out:
        process = subprocess.Popen(words, stdout=out, stderr=subprocess.DEVNULL)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        out.seek(0)
        return process.returncode, out.read(), usage.ru_maxrss / 1024, usage.ru_utime + usage.ru_stime


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("tasks", nargs="*", metavar="TASK")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--timeout", type=float, default=20)
    parser.add_argument("--program", type=pathlib.Path, default=ROOT / "build/release/stiction")
    arguments = parser.parse_args()

    results = []
    with tempfile.TemporaryDirectory() as folder:
        for task in arguments.tasks or TASKS:
            times, processor_times, peaks, accepted = [], [], [], 0
            for seed in range(arguments.seeds):
                out = pathlib.Path(folder) / f"{task}-{seed}"
                words = [arguments.program, "plan", task, "--seed", seed, "--timeout", arguments.timeout, "-o", out, "--json"]
                code, text, peak, processor = run([str(word) for word in words])
                if code not in (0, 3):
                    print(f"{task} seed {seed}: exit code {code}", file=sys.stderr)
                    return 2
                plan = json.loads(text)
                check_code, text, *_ = run([str(arguments.program), "check", str(out), "--json"])
                check = json.loads(text)
                failed = [item["name"] for item in check.get("checks", []) if not item["pass"]]
                good = code == 0 and check_code == 0
                accepted += good
                times.append(plan["wall_s"])
                processor_times.append(processor)
                peaks.append(peak)
                print(
                    f"{task} seed {seed}: {plan['status']} in {plan['wall_s']:.2f} s ({processor:.2f} s of processors), {plan['knots']} knots, {plan['regrasps']['in_plan']} regrasps, "
                    f"{peak:.0f} MB, check {'passed' if check_code == 0 else 'failed: ' + ', '.join(failed)}",
                    file=sys.stderr,
                )
            results.append(
                {
                    "task": task,
                    "runs": arguments.seeds,
                    "accepted": accepted,
                    "median_s": statistics.median(times),
                    "worst_s": max(times),
                    "median_processor_s": statistics.median(processor_times),
                    "worst_processor_s": max(processor_times),
                    "peak_mb": max(peaks),
                }
            )
    print(json.dumps({"seeds": arguments.seeds, "results": results}))
    return 0 if all(row["accepted"] == row["runs"] for row in results) else 1


if __name__ == "__main__":
    sys.exit(main())
