#!/usr/bin/env python3
"""Runs of several programs on tasks of `stiction benchmark`, with the same seeds: how many reach their goal.

    bench/scene_runs.py --scenes FOLDER --seeds 0:3 --program old=OLD/build/release/stiction --program new=build/release/stiction metaworld_pick_place …

FOLDER has the unpacked packages of the scenes, as for `stiction benchmark --scenes`. Every run is `stiction run TASK --seed S --threads 1 --duration 60`. The clock
of the simulation goes on while the planner works, by 0.1 ms for each of its steps, so a run does the same on every machine. A run ends after --seconds in any case,
and then counts as one that did not reach its goal.
"""

import argparse
import collections
import json
import pathlib
import sys
import tempfile

from runs import ROOT, exit_with, measure_run

sys.path.insert(0, str(ROOT / "build/release/python"))
from stiction._benchmark import write_tasks  # noqa: E402
from stiction._benchmark_tasks import ENTRIES, find_packages  # noqa: E402


def run(program: str, task: pathlib.Path, seed: int, seconds: int) -> dict[str, object]:
    with tempfile.TemporaryDirectory() as folder:
        command = [program, "run", task, "--seed", seed, "--threads", 1, "--duration", 60, "--timeout", seconds, "--plan-step-time", 1e-4, "--json", "-o", folder]
        done = measure_run(command, seconds)
    try:
        report = json.loads(done.text)
    except ValueError:
        return {"status": f"exit code {done.code}", "reached": False}
    return {name: report[name] for name in ("status", "reached", "duration_s", "planning_s", "replans", "pushes")}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tasks", nargs="+", metavar="TASK", help="a name that `stiction benchmark --list` shows")
    parser.add_argument("--scenes", type=pathlib.Path, required=True, metavar="FOLDER")
    parser.add_argument("--seeds", default="0:3", help="FIRST:END")
    parser.add_argument("--seconds", type=int, default=250, help="longest processor time of a run")
    parser.add_argument("--program", action="append", default=[], metavar="NAME=PATH", help="default: that of this folder")
    parser.add_argument("--rows", type=pathlib.Path, help="append a JSON object for each run to this file")
    arguments = parser.parse_args()
    first, end = map(int, arguments.seeds.split(":"))
    programs = [entry.split("=", 1) for entry in arguments.program] or [["this", str(ROOT / "build/release/stiction")]]
    if unknown := set(arguments.tasks) - {entry.name for entry in ENTRIES}:
        raise RuntimeError(f"tasks {', '.join(sorted(unknown))} are not in the benchmark; expected names of `stiction benchmark --list`")
    reached: collections.Counter[str] = collections.Counter()
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        _, missing = write_tasks([entry for entry in ENTRIES if entry.name in arguments.tasks], find_packages(arguments.scenes), folder)
        if missing:
            raise RuntimeError(f"the packages of {', '.join(entry.name for entry in missing)} are not in {arguments.scenes}")
        for task in arguments.tasks:
            for seed in range(first, end):
                for name, path in programs:
                    row = run(path, folder / f"{task}.yaml", seed, arguments.seconds)
                    reached[name] += bool(row["reached"])
                    print(task, seed, name, *(f"{key} {value:.3g}" if isinstance(value, float) else f"{key} {value}" for key, value in row.items()), flush=True)
                    if arguments.rows:
                        with arguments.rows.open("a") as out:
                            out.write(json.dumps({"task": task, "seed": seed, "program": name, **row}) + "\n")
    for name, _ in programs:
        print(f"{name}: {reached[name]} of {len(arguments.tasks) * (end - first)} reach their goal")
    return 0


if __name__ == "__main__":
    exit_with("scene_runs", main)
