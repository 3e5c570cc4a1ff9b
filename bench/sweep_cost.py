#!/usr/bin/env python3
"""What a sweep costs beside its runs, and what many cores would make of it.

    .venv/bin/python bench/sweep_cost.py [TASK] [--seeds 40] [--runs 100000] > sweep_cost.json

The same sweep on one and on two processes. Of each: wall time, processor time of the runs, and of the process that hands them out and writes their rows,
which is the serial part: it bounds the rate whatever the number of cores. One JSON object on stdout, a table on stderr.
"""

import argparse
import json
import pathlib
import sys
import tempfile
import time

from by_task import stiction


def measure(task, seeds, processes, folder):
    """Per run: wall, processor time of runs and of the serial part [s]."""
    start, serial = time.monotonic(), time.process_time()
    rows = stiction.sweep(task, seeds=seeds, processes=processes, out=folder / f"{processes}.csv")
    wall, serial = time.monotonic() - start, time.process_time() - serial
    return {"processes": processes, "wall_s": wall / seeds, "run_s": sum(row["processor_s"] for row in rows) / seeds, "serial_s": serial / seeds}


def extrapolate(measured, runs, cores):
    """Wall time on so many cores [s]: a share of the runs on each, and not below the serial part of all of them."""
    return max(-(-runs // cores) * measured["run_s"], runs * measured["serial_s"])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("task", nargs="?", default="planar_pushing")
    parser.add_argument("--seeds", type=int, default=40)
    parser.add_argument("--runs", type=int, default=100_000, help="of the sweep that is extrapolated")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        stiction.sweep(arguments.task, out=pathlib.Path(folder) / "first.csv")  # the process that others are forked from starts
        measured = [measure(arguments.task, arguments.seeds, processes, pathlib.Path(folder)) for processes in (1, 2)]
    for row in measured:
        print("{processes} processes: {wall_s:.3f} s per run, {run_s:.3f} s of processors, {serial_s:.4f} s serial".format(**row), file=sys.stderr)
    cores = {n: extrapolate(measured[-1], arguments.runs, n) for n in (1, 2, 10, 100, 1000)}
    for n, seconds in cores.items():
        print(f"{arguments.runs} runs on {n} cores: {seconds / 60:.1f} min", file=sys.stderr)
    print(json.dumps({"task": arguments.task, "seeds": arguments.seeds, "measured": measured, "runs": arguments.runs, "extrapolated_s": cores}))


if __name__ == "__main__":
    main()
