#!/usr/bin/env python3
"""What searches spend processor time on, in percent of each task's sum over the seeds.

    bench/profile.py [TASK …] [--seeds 0:3] [--timeout 40]

A table on stdout: a line for each task, a column for each activity of `stiction plan --profile`. TASK: a name or a file.
"""

import argparse
import collections
import json
import pathlib
import tempfile

from runs import ROOT, measure_run
from search import TASKS


def profile_of(task: str, seed: int, timeout: float) -> dict[str, dict[str, float]]:
    with tempfile.TemporaryDirectory() as folder:
        command = [ROOT / "build/release/stiction", "plan", task, "--seed", seed, "--threads", 1, "--timeout", timeout, "--json", "-o", folder]
        return json.loads(measure_run(command).text)["profile"]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tasks", nargs="*", metavar="TASK", help="default: the 15 tasks that are planned for")
    parser.add_argument("--seeds", default="0:3", help="FIRST:END")
    parser.add_argument("--timeout", type=float, default=40, help="of a search [s]")
    arguments = parser.parse_args()
    first, end = map(int, arguments.seeds.split(":"))
    sums: dict[str, collections.Counter[str]] = {}
    for task in arguments.tasks or TASKS:
        total = sums.setdefault(pathlib.Path(task).stem, collections.Counter())
        for seed in range(first, end):
            total.update({name: entry["processor_s"] for name, entry in profile_of(task, seed, arguments.timeout).items()})
    names = sorted(next(iter(sums.values())), key=lambda name: -sum(total[name] / total.total() for total in sums.values()))
    print("| task | mean | " + " | ".join(f"`{name}`" for name in names) + " |")
    print("|---" * (len(names) + 2) + "|")
    for task, total in sums.items():
        shares = [f"{100 * total[name] / total.total():.0f}" for name in names]
        print(f"| `{task}` | {total.total() / (end - first):.2f} s | " + " | ".join(shares) + " |")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
