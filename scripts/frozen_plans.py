#!/usr/bin/env python3
"""Compares the plans of two builds bit by bit: a change that only moves code leaves all of them as they were.

    scripts/frozen_plans.py BEFORE AFTER [--seeds 2] [TASK …]

BEFORE and AFTER are programs `stiction`, best of the preset `frozen`: there the compiler fuses no multiply-adds, so that moved code rounds alike.
Every plan, and what `refine` makes of it, is compared by a hash of its segments and counts, with one thread and with two.
Exit code 1 when one differs.
"""

import argparse
import hashlib
import json
import pathlib
import subprocess
import sys
import tempfile

TASKS = ["planar_pushing", "planar_hand", "planar_hand_fixed_y", "box_grazing", "allegro_cube", "allegro_door", "iiwa_bimanual_planar"]


def hash_of(file):
    """Of what a plan does; its options may be spelled otherwise."""
    plan = json.loads(file.read_text())
    kept = {key: plan[key] for key in ("status", "statistics", "error", "segments")}
    return hashlib.sha256(json.dumps(kept, sort_keys=True).encode()).hexdigest()[:12]


def plans_of(program, task, seed, threads):
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "plan"
        arguments = [program, "plan", task, "--seed", str(seed), "--threads", str(threads), "--timeout", "60", "-o", str(out)]
        subprocess.run(arguments, capture_output=True, check=False)
        subprocess.run([program, "refine", str(out)], capture_output=True, check=False)
        files = [out / "plan.json", out / "refined" / "plan.json"]
        return [hash_of(file) if file.exists() else "nothing" for file in files]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before")
    parser.add_argument("after")
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--threads", type=int, nargs="*", default=[1, 2])
    parser.add_argument("tasks", nargs="*", default=TASKS)
    arguments = parser.parse_args()
    different = 0
    for task in arguments.tasks:
        for seed in range(arguments.seeds):
            hashes = {(program, threads): plans_of(program, task, seed, threads) for program in (arguments.before, arguments.after) for threads in arguments.threads}
            same = len({tuple(value) for value in hashes.values()}) == 1
            different += not same
            print(f"{task} seed {seed}: {'equal ' + ' '.join(next(iter(hashes.values()))) if same else f'different {hashes}'}", flush=True)
    sys.exit(1 if different else 0)


if __name__ == "__main__":
    main()
