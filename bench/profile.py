#!/usr/bin/env python3
"""What searches spend processor time on, as shares of each task's sum over the seeds.

    bench/profile.py [TASK …] [--seeds 0:3] [--processor-seconds 40]

A table on stdout: a line for each activity of `stiction plan --profile`, a column for each task. TASK: a name or a file.
"""

import argparse
import collections
import json
import pathlib
import subprocess
import tempfile

from search import ROOT, TASKS


def profile_of(task: str, seed: int, seconds: float) -> dict[str, dict[str, float]]:
    with tempfile.TemporaryDirectory() as folder:
        command = [str(ROOT / "build/release/stiction"), "plan", task, "--seed", str(seed), "--threads", "1", "--timeout", str(seconds), "--json", "-o", folder]
        return json.loads(subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=20 * seconds + 60).stdout)["profile"]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tasks", nargs="*", metavar="TASK", help="default: the 15 tasks that are planned for")
    parser.add_argument("--seeds", default="0:3", help="FIRST:END")
    parser.add_argument("--processor-seconds", type=float, default=40)
    arguments = parser.parse_args()
    first, end = map(int, arguments.seeds.split(":"))
    sums: dict[str, collections.Counter[str]] = {}
    for task in arguments.tasks or TASKS:
        total = sums.setdefault(pathlib.Path(task).stem, collections.Counter())
        for seed in range(first, end):
            total.update({name: entry["processor_s"] for name, entry in profile_of(task, seed, arguments.processor_seconds).items()})
    names = sorted(next(iter(sums.values())), key=lambda name: -sum(total[name] / total.total() for total in sums.values()))
    print("| task | mean | " + " | ".join(f"`{name}`" for name in names) + " |")
    print("|---" * (len(names) + 2) + "|")
    for task, total in sums.items():
        shares = [f"{100 * total[name] / total.total():.0f}" for name in names]
        print(f"| `{task}` | {total.total() / (end - first):.2f} s | " + " | ".join(shares) + " |")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
