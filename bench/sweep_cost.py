#!/usr/bin/env python3
"""What a sweep costs beside its runs, and what many cores would make of it.

    .venv/bin/python bench/sweep_cost.py [TASK] [--seeds 40] [--runs 100000] [--workers 1,2,4] > sweep_cost.json

The same sweep on one and on two processes, with --workers also on clusters of Ray with so many machines of one core each, which stand on this one. Of each: wall time, processor time of the runs, and
of the process that hands them out and writes their rows, which is the serial part: it bounds the rate whatever the number of cores. The model of n workers is the larger one of a share of the runs and
of all serial parts; its two numbers are those of the cluster with one worker. One JSON object on stdout, a table on stderr.
"""

import argparse
import contextlib
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

from by_task import stiction
from runs import ROOT


def measure(task, seeds, folder, processes=None, ray=None):
    """Per run: wall, processor time of runs and of the serial part [s]."""
    start, serial = time.monotonic(), time.process_time()
    folder.mkdir(exist_ok=True)
    rows = stiction.sweep(task, seeds=seeds, processes=processes, ray=ray, out=folder / "sweep.csv")
    wall, serial = time.monotonic() - start, time.process_time() - serial
    return {"wall_s": wall / seeds, "run_s": sum(row["processor_s"] for row in rows) / seeds, "serial_s": serial / seeds}


def measure_ray(task, seeds, folder, workers):
    """What a run costs once Ray has started: the difference of a long and a short sweep, each the least of two, as Ray starts now sooner and now later."""
    few = max(1, seeds // 4)
    with cluster_of(workers) as address:

        def least(n):
            rows = [measure(task, n, folder / f"{workers}-{n}-{k}", ray=address) for k in range(2)]
            return {key: min(row[key] for row in rows) for key in rows[0]}

        least(workers)  # workers load the package
        short, long = least(few), least(seeds)
    return {"workers": workers} | {key: (seeds * long[key] - few * short[key]) / (seeds - few) for key in long}


@contextlib.contextmanager
def cluster_of(machines):
    """The address of a cluster with so many machines of one core each."""
    words = [sys.executable, ROOT / "tests/python/ray_cluster.py", str(machines)]
    path = os.pathsep.join([str(ROOT / "build/release/python"), os.environ.get("PYTHONPATH", "")])
    with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env={**os.environ, "PYTHONPATH": path}) as served:
        yield json.loads(served.stdout.readline())["address"]
        served.stdin.close()
        served.wait()


def extrapolate(measured, runs, cores):
    """Wall time on so many cores [s]: a share of the runs on each, and not below the serial part of all of them."""
    return max(-(-runs // cores) * measured["run_s"], runs * measured["serial_s"])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("task", nargs="?", default="planar_pushing")
    parser.add_argument("--seeds", type=int, default=40)
    parser.add_argument("--runs", type=int, default=100_000, help="of the sweep that is extrapolated")
    parser.add_argument("--workers", type=lambda text: [int(word) for word in text.split(",")], default=[], metavar="N,N", help="clusters of Ray with so many workers")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        stiction.sweep(arguments.task, out=folder / "first.csv")  # the process that others are forked from starts
        measured = [{"processes": n} | measure(arguments.task, arguments.seeds, folder / f"local-{n}", n) for n in (1, 2)]
        on_ray = [measure_ray(arguments.task, arguments.seeds, folder, n) for n in arguments.workers]
    base = on_ray[0] if on_ray else measured[0]  # a cluster is reached by Ray
    for row in measured + on_ray:
        workers = row.get("workers")
        row["model_s"] = None if workers is None else extrapolate(base, 1, 1) if workers == 1 else max(base["run_s"] / workers, base["serial_s"])
        name = f"{row['processes']} processes" if workers is None else f"Ray, {workers} workers"
        print(f"{name}: {row['wall_s']:.3f} s per run, {row['run_s']:.3f} s of processors, {row['serial_s']:.4f} s serial; model {row['model_s'] or 0:.3f} s", file=sys.stderr)
    cores = {n: extrapolate(base, arguments.runs, n) for n in (1, 2, 4, 10, 100, 1000)}
    for n, seconds in cores.items():
        print(f"{arguments.runs} runs on {n} cores: {seconds / 60:.1f} min", file=sys.stderr)
    print(json.dumps({"task": arguments.task, "seeds": arguments.seeds, "cores": os.cpu_count(), "measured": measured, "on_ray": on_ray, "runs": arguments.runs, "extrapolated_s": cores}))


if __name__ == "__main__":
    main()
