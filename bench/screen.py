#!/usr/bin/env python3
"""Screens options of the planner: which of them change how long a task takes to plan, and which way.

    .venv/bin/python bench/screen.py TASK OPTION=LOW,HIGH … [--runs 200] [--timeout 10] [-j 2] [--first-seed 50000] > screen.json

OPTION is a key of the planner, with dots into maps: goal_bias=0.5,0.8 friction=0.7,1. Every run has a seed of its own and takes each option at
one of its two values, drawn by that seed, so that every run tells something about every option. Planning times of a task are about exponential: the ratios are
those of the mean time at HIGH to that at LOW by maximum likelihood, where a run that came to no plan counts for the time that it took. They are shrunk towards 1 by
a unit normal prior on half their logarithm. One JSON object on stdout, a line for each option on stderr; an option matters where |z| > 2, say.
"""

import argparse
import concurrent.futures
import json
import pathlib
import random
import sys
import tempfile

import numpy as np
from runs import ROOT, exit_with, measure_run


def read_factor(text):
    option, _, values = text.partition("=")
    levels = values.split(",")
    if not option or len(levels) != 2:
        raise argparse.ArgumentTypeError(f"'{text}': OPTION=LOW,HIGH expected")
    return option.split("."), [json.loads(value) for value in levels]


def set_option(planner, path, value):
    for key in path[:-1]:
        planner = planner.setdefault(key, {})
    planner[path[-1]] = value


def draw_levels(seed, n):
    """0 or 1 for each of n options."""
    source = random.Random(seed)
    return [source.randrange(2) for _ in range(n)]


def plan_once(arguments, folder, seed):
    """Levels of the options, whether a plan was found, and the planning time [s]."""
    levels = draw_levels(seed, len(arguments.factors))
    planner = {}
    for (path, values), level in zip(arguments.factors, levels):
        set_option(planner, path, values[level])
    given = pathlib.Path(arguments.task)
    base = given if given.suffix else ROOT / "tasks" / f"{arguments.task}.yaml"
    task = folder / f"{seed}.yaml"
    task.write_text(json.dumps({"base": str(base.resolve()), "name": "screened", "planner": planner}))
    words = [arguments.program, "plan", task, "--seed", seed, "--threads", "1", "--timeout", arguments.timeout, "-o", folder / str(seed), "--json"]
    done = measure_run(words)
    if done.code not in (0, 3):
        raise RuntimeError(f"{' '.join(map(str, words))}: exit code {done.code}")
    plan = json.loads(done.text)
    return levels, plan["status"] == "Solved", plan["wall_s"]


def fit_ratios(levels, solved, times):
    """Mean time, and (ratio, z) of each option: an exponential regression with censored times, by Newton's method from no effects."""
    x = np.column_stack([np.ones(len(times)), 2.0 * np.asarray(levels) - 1])
    times, solved = np.asarray(times, float), np.asarray(solved, float)
    prior = np.diag([0.0] + [1.0] * (x.shape[1] - 1))
    b = np.zeros(x.shape[1])
    b[0] = np.log(times.sum() / max(1.0, solved.sum()))
    for _ in range(50):
        expected = times * np.exp(-x @ b)
        hessian = x.T @ (x * expected[:, None]) + prior
        step = np.linalg.solve(hessian, x.T @ (expected - solved) - prior @ b)
        b += step
        if np.abs(step).max() < 1e-10:
            break
    error = np.sqrt(np.diag(np.linalg.inv(hessian)))
    return float(np.exp(b[0])), [(float(np.exp(2 * e)), float(e / s)) for e, s in zip(b[1:], error[1:])]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("task", metavar="TASK", help="name or file")
    parser.add_argument("factors", nargs="+", type=read_factor, metavar="OPTION=LOW,HIGH")
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--first-seed", type=int, default=50000)
    parser.add_argument("--timeout", type=float, default=10)
    parser.add_argument("-j", "--jobs", type=int, default=2, help="runs at once, of one thread each")
    parser.add_argument("--program", type=pathlib.Path, default=ROOT / "build/release/stiction")
    arguments = parser.parse_args()

    seeds = range(arguments.first_seed, arguments.first_seed + arguments.runs)
    with tempfile.TemporaryDirectory() as name, concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        rows = list(pool.map(lambda seed: plan_once(arguments, pathlib.Path(name), seed), seeds))
    levels, solved, times = zip(*rows)
    mean, ratios = fit_ratios(levels, solved, times)
    options = [
        {"option": ".".join(path), "low": values[0], "high": values[1], "ratio": ratio, "z": z}
        for (path, values), (ratio, z) in zip(arguments.factors, ratios)
    ]
    for row in sorted(options, key=lambda row: row["z"]):
        print(f"{row['option']:40s} {row['low']} → {row['high']}: {row['ratio']:.2f} times as long (z {row['z']:+.1f})", file=sys.stderr)
    print(json.dumps({"task": arguments.task, "runs": len(rows), "solved": sum(solved), "mean_s": mean, "options": options}))
    return 0


if __name__ == "__main__":
    exit_with("screen", main)
