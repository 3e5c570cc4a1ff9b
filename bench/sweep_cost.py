#!/usr/bin/env python3
"""What a sweep costs beside its runs, and what many cores would make of it.

    .venv/bin/python bench/sweep_cost.py [TASK] [--seeds 40] [--runs 100000] [--ray] > sweep_cost.json

The same sweep on one and on two processes, with --ray also on a Ray of this machine. Of each: wall time, processor time of the runs, and of the process that hands them out and writes their rows,
which is the serial part: it bounds the rate whatever the number of cores. One JSON object on stdout, a table on stderr.
"""

import argparse
import json
import pathlib
import sys
import tempfile
import time

from by_task import stiction


def measure(task, seeds, folder, processes=None, ray=None):
    """Per run: wall, processor time of runs and of the serial part [s]."""
    start, serial = time.monotonic(), time.process_time()
    folder.mkdir(exist_ok=True)
    rows = stiction.sweep(task, seeds=seeds, processes=processes, ray=ray, out=folder / f"{ray or processes}.csv")
    wall, serial = time.monotonic() - start, time.process_time() - serial
    return {"processes": ray or processes, "wall_s": wall / seeds, "run_s": sum(row["processor_s"] for row in rows) / seeds, "serial_s": serial / seeds}


def measure_ray(task, seeds, folder):
    """What a run costs once Ray has started: the difference of a long and a short sweep, each the least of two, as Ray starts now sooner and now later."""
    few = max(1, seeds // 4)

    def least(n):
        rows = [measure(task, n, folder / f"{n}-{k}", ray="local") for k in range(2)]
        return {key: min(row[key] for row in rows) for key in ("wall_s", "run_s", "serial_s")}

    short, long = least(few), least(seeds)
    return {"processes": "ray"} | {key: (seeds * long[key] - few * short[key]) / (seeds - few) for key in long}


def extrapolate(measured, runs, cores):
    """Wall time on so many cores [s]: a share of the runs on each, and not below the serial part of all of them."""
    return max(-(-runs // cores) * measured["run_s"], runs * measured["serial_s"])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("task", nargs="?", default="planar_pushing")
    parser.add_argument("--seeds", type=int, default=40)
    parser.add_argument("--runs", type=int, default=100_000, help="of the sweep that is extrapolated")
    parser.add_argument("--ray", action="store_true", help="the same on a local Ray, once it has started")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        stiction.sweep(arguments.task, out=pathlib.Path(folder) / "first.csv")  # the process that others are forked from starts
        measured = [measure(arguments.task, arguments.seeds, pathlib.Path(folder), processes) for processes in (1, 2)]
        on_ray = [measure_ray(arguments.task, arguments.seeds, pathlib.Path(folder))] if arguments.ray else []
    for row in measured + on_ray:
        print("{processes} processes: {wall_s:.3f} s per run, {run_s:.3f} s of processors, {serial_s:.4f} s serial".format(**row), file=sys.stderr)
    last = (measured + on_ray)[-1]  # a cluster is reached by Ray
    cores = {n: extrapolate(last, arguments.runs, n) for n in (1, 2, 10, 100, 1000)}
    for n, seconds in cores.items():
        print(f"{arguments.runs} runs on {n} cores: {seconds / 60:.1f} min", file=sys.stderr)
    print(json.dumps({"task": arguments.task, "seeds": arguments.seeds, "measured": measured, "on_ray": on_ray, "runs": arguments.runs, "extrapolated_s": cores}))


if __name__ == "__main__":
    main()
