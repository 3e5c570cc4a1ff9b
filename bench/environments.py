#!/usr/bin/env python3
"""Steps a second of the episodes of `stiction.gym`, beside those of the library alone, with random actions.

    bench/environments.py [--tasks allegro_ball planar_hand] [--envs 64 1024] [--steps 50] [--grasps 32] [--json]

Episodes start at held grasps. `share` is that of the wall time that the library steps in; the rest are observations, rewards and resets. Gymnasium is not needed,
since its part adds nothing but names. One line for each task and number of episodes.
"""

import argparse
import json
import os
import pathlib
import sys
import time

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "build/release/python"))
import stiction as st  # noqa: E402
from stiction._episodes import Episodes  # noqa: E402


def measure(task, grasps, envs, steps):
    episodes = Episodes(task, envs, starts=grasps, increment=None, max_steps=200, lost=None, threads=0)
    random, every = np.random.default_rng(0), np.ones(envs, dtype=bool)
    episodes.reset(every, random)
    actions = random.uniform(-1, 1, (steps, envs, task.model.n_a))
    ended, done, unsolved = np.zeros(envs, dtype=bool), 0, 0
    begin = time.perf_counter()
    for action in actions:
        if ended.any():
            episodes.reset(ended, random)
        outcome = episodes.step(action, ~ended)
        done += int((~ended).sum())
        unsolved += int(outcome.unsolved.sum())
        ended = outcome.success | outcome.lost | outcome.truncated
        episodes.observe()
    wall = time.perf_counter() - begin
    alone = st.step_batch(task.model, episodes.q, episodes.u, effort_limits=True, friction_law=episodes._law).wall_s
    return {"task": task.name, "envs": envs, "steps_per_s": done / wall, "library_steps_per_s": envs / alone, "share": done / envs * alone / wall, "unsolved": unsolved, "cores": os.cpu_count()}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tasks", nargs="+", default=["planar_hand", "allegro_ball", "allegro_cube"])
    parser.add_argument("--envs", nargs="+", type=int, default=[64, 1024])
    parser.add_argument("--steps", type=int, default=50)
    parser.add_argument("--grasps", type=int, default=32)
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    for name in arguments.tasks:
        task = st.load_task(name)
        begin = time.perf_counter()
        grasps = st.find_grasps(task, count=arguments.grasps)
        found_s = time.perf_counter() - begin
        for envs in arguments.envs:
            row = measure(task, grasps, envs, arguments.steps) | {"grasps": len(grasps), "grasps_s": found_s}
            line = f"{name}, {envs} episodes: {row['steps_per_s']:.0f} steps a second on {row['cores']} cores, {row['share']:.0%} of it in the library; {row['unsolved']} unsolved"
            print(json.dumps(row) if arguments.json else f"{line}; {len(grasps)} grasps in {found_s:.1f} s")


if __name__ == "__main__":
    main()
