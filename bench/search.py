#!/usr/bin/env python3
"""Searches of several programs, or with mechanisms left out, on the same seeds: how many plans are found and accepted, and their processor seconds.

    bench/search.py --seeds 100:140 --program old=OLD/build/release/stiction --program new=build/release/stiction
    bench/search.py --seeds 100:140 --without frontier --without chains --without frontier,chains

Every run is `stiction plan TASK --seed S --threads 1`, ended after --processor-seconds, and `stiction check` of its plan. Runs of one seed follow each other, so
that a slow hour of the machine is one for all. A run without an accepted plan counts with all of its processor seconds.
"""

import argparse
import collections
import json
import pathlib
import subprocess
import sys
import tempfile

from runs import ROOT, measure_run

TASKS = (
    "planar_pushing planar_hand planar_hand_fixed_y allegro_ball allegro_cube allegro_cube_180 allegro_cube_roll allegro_door allegro_pen allegro_plate "
    "iiwa_bimanual iiwa_bimanual_box iiwa_bimanual_planar ur5_mesh_push box_grazing"
).split()


def run(program: str, extra: list[str], task: str, seed: int, most: float) -> dict[str, object]:
    with tempfile.TemporaryDirectory() as folder:
        command = [program, "plan", task, "--seed", str(seed), "--threads", "1", "--timeout", str(20 * most), "-o", folder, *extra]
        done = measure_run(command, int(most) + 1)
        accepted = done.code == 0 and subprocess.run([program, "check", folder], capture_output=True, timeout=600).returncode == 0
    return {"solved": done.code == 0, "accepted": accepted, "cpu_s": done.processor_s}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tasks", nargs="*", metavar="TASK", help="default: the 15 tasks that are planned for")
    parser.add_argument("--seeds", default="100:140", help="FIRST:END")
    parser.add_argument("--processor-seconds", type=float, default=40)
    parser.add_argument("--program", action="append", default=[], metavar="NAME=PATH", help="default: that of this folder")
    parser.add_argument("--without", action="append", default=[], metavar="MECHANISM[,…]", help="one more variant of the last program")
    parser.add_argument("--rows", type=pathlib.Path, help="append a JSON object for each run to this file")
    arguments = parser.parse_args()
    first, end = map(int, arguments.seeds.split(":"))
    programs = [entry.split("=", 1) for entry in arguments.program] or [["all", str(ROOT / "build/release/stiction")]]
    variants = [(name, path, []) for name, path in programs]
    variants += [("without " + names, programs[-1][1], ["--without", names]) for names in arguments.without]
    rows = collections.defaultdict(list)
    for task in arguments.tasks or TASKS:
        for seed in range(first, end):
            for name, path, extra in variants:
                row = run(path, extra, task, seed, arguments.processor_seconds)
                rows[task, name].append(row)
                if arguments.rows:
                    with arguments.rows.open("a") as out:
                        out.write(json.dumps({"task": task, "seed": seed, "variant": name, **row}) + "\n")
        show(task, [(name, rows[task, name]) for name, _, _ in variants])
    show("all", [(name, [row for (_, n), some in rows.items() if n == name for row in some]) for name, _, _ in variants])
    return 0


def show(task: str, variants: list[tuple[str, list[dict[str, object]]]]) -> None:
    base = mean(variants[0][1])
    for name, rows in variants:
        accepted = sum(bool(row["accepted"]) for row in rows)
        print(f"{task:22s} {name:24s} {accepted:4d} of {len(rows):4d}  mean {mean(rows):7.2f} s  ratio {mean(rows) / base:5.2f}", flush=True)


def mean(rows: list[dict[str, object]]) -> float:
    return sum(float(row["cpu_s"]) for row in rows) / max(1, len(rows))  # type: ignore[arg-type]


if __name__ == "__main__":
    sys.exit(main())
