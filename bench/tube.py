#!/usr/bin/env python3
"""Bounds of where plans leave their object (`stiction check --tube`), against noisy runs of the same plans in MuJoCo.

    .venv/bin/python bench/tube.py --keep FOLDER [--seeds 3] [--runs 10] [--no-margins] [--timeout 60] [--calibrate] TASK … > tube.json

Every plan is made, refined and run open loop in worlds that are drawn from the sets of errors. The factors of the tubes of a task come from the runs of all other
tasks (split conformal prediction, 95 %), so that no task is judged by its own runs; --calibrate prints those of all tasks together, which the library states.
Only plans whose tube with factors of 1 ends within the tolerances count for the factors: others are refused with any factor above 1. Plans and runs are kept in
FOLDER, and the same command goes on with them. One JSON object on stdout, a table on stderr.
"""

import argparse
import json
import math
import pathlib
import statistics
import sys
import time

import numpy as np

from by_task import make_parser
from by_task import stiction as st
from runs import exit_with

LEVEL = 0.95
WORLDS = 1  # seed of the worlds of the runs; those of the tubes have another


def rotation_angle(a, b):
    """Between two quaternions."""
    return 2 * math.atan2(np.linalg.norm(turn(a, b)[:3]), abs(turn(a, b)[3]))


def turn(a, b):
    """Of quaternions x y z w: conj(a) b."""
    return np.append(a[3] * b[:3] - b[3] * a[:3] - np.cross(a[:3], b[:3]), a @ b)


def pose_numbers(model, q, name):
    pose = model.object_pose(q, name)
    return [*pose.p.tolist(), *quaternion(pose.R)]


def quaternion(R):
    """x y z w of a rotation matrix: the eigenvector of its largest eigenvalue is well conditioned everywhere."""
    K = np.array(
        [
            [R[0, 0] - R[1, 1] - R[2, 2], R[0, 1] + R[1, 0], R[0, 2] + R[2, 0], R[2, 1] - R[1, 2]],
            [0, R[1, 1] - R[0, 0] - R[2, 2], R[1, 2] + R[2, 1], R[0, 2] - R[2, 0]],
            [0, 0, R[2, 2] - R[0, 0] - R[1, 1], R[1, 0] - R[0, 1]],
            [0, 0, 0, R[0, 0] + R[1, 1] + R[2, 2]],
        ]
    )
    return np.linalg.eigh(K, "U")[1][:, -1].tolist()


def make_plan(task, seed, arguments):
    """The refined plan, from the folder where it is there; None where none was found."""
    file = arguments.keep / f"{task}_{seed}.json"
    if file.exists():
        text = file.read_text()
        return st.parse_plan(text, arguments.keep) if text else None
    found = st.plan(st.load_task(task), seed=seed, threads=1, timeout_s=arguments.timeout, options={"margins": not arguments.no_margins})
    if found.status != st.Status.Solved:
        file.write_text("")
        return None
    plan = st.refine(found.plan, threads=1, timeout_s=arguments.timeout).plan
    plan.write(file)
    return plan


def run_world(plan, index):
    """Poses of the object at the rests of a run, the last one after the hold; fewer where the run ended before."""
    world = st.draw_world(plan, st.ErrorSets(), seed=WORLDS, index=index)
    run = st.transfer(plan, friction_scale=world.friction, mass_scale=world.mass, start_error=world.start, alone=False, threads=1)
    model = plan.task.model
    name = model.object_names[plan.task.goal.object]
    rests = [int(np.searchsorted(run.times, piece.end_s)) for piece in run.pieces if piece.in_plan is not None]
    if len(rests) == len(run.pieces):
        rests[-1] = len(run.times) - 1
    poses = [pose_numbers(model, run.q[min(k, len(run.times) - 1)], name) for k in rests]
    return {"friction": world.friction, "mass": world.mass, "reached": run.reached, "dropped": run.dropped is not None, "poses": poses}


def get_runs(plan, task, seed, arguments):
    out = []
    for index in range(arguments.runs):
        file = arguments.keep / f"{task}_{seed}_run_{index}.json"
        if not file.exists():
            begin = time.monotonic()
            file.write_text(json.dumps(run_world(plan, index)))
            print(task, seed, "run", index, f"{time.monotonic() - begin:.1f} s", file=sys.stderr, flush=True)
        out.append(json.loads(file.read_text()))
    return out


def scores(tube, run):
    """By what the radii would have to be larger for a run to stay inside, in position and angle."""
    if len(run["poses"]) < len(tube.rests):
        return math.inf, math.inf
    position = angle = 0.0
    for rest, pose in zip(tube.rests, run["poses"], strict=True):
        position = max(position, float(np.linalg.norm(np.array(pose[:3]) - rest.centre.p)) / rest.position)
        angle = max(angle, rotation_angle(np.array(quaternion(rest.centre.R)), np.array(pose[3:])) / rest.angle)
    return position, angle


def measure_plan(task, seed, arguments):
    plan = make_plan(task, seed, arguments)
    if plan is None:
        return None
    runs = get_runs(plan, task, seed, arguments)
    begin = time.process_time()
    tube = st.calc_tube(plan, factors=(1.0, 1.0), scenarios=arguments.scenarios)
    goal, last = plan.task.goal, tube.rests[-1]
    return {
        "task": task,
        "seed": seed,
        "processor_s": time.process_time() - begin,
        "knots": len(plan.u) - 1,
        "rests": len(tube.rests),
        "lost": tube.lost,
        "tolerance": [goal.tol_position, goal.tol_angle],
        "centre": [tube.goal.position - last.position, tube.goal.angle - last.angle],
        "radius": [last.position, last.angle],
        "candidate": tube.inside,
        "scores": [scores(tube, run) for run in runs],
        "reached": sum(run["reached"] for run in runs),
    }


def conformal_quantile(values, level):
    """The smallest value that a further one exceeds with a probability of at most 1 − level, if all are drawn alike."""
    rank = math.ceil((len(values) + 1) * level)
    return sorted(values)[rank - 1] if rank <= len(values) else math.inf


def main():
    parser = make_parser(__doc__.splitlines()[0])
    parser.set_defaults(seeds=3)
    parser.add_argument("--keep", type=pathlib.Path, required=True)
    parser.add_argument("--runs", type=int, default=10, help="of each plan")
    parser.add_argument("--timeout", type=float, default=60, help="of the planner [s]")
    parser.add_argument("--scenarios", type=int, default=16, help="of a tube")
    parser.add_argument("--no-margins", action="store_true", help="plans as the options of their tasks have them")
    arguments = parser.parse_args()
    arguments.keep.mkdir(parents=True, exist_ok=True)
    plans = [measure_plan(task, seed, arguments) for task in arguments.tasks for seed in range(arguments.first_seed, arguments.first_seed + arguments.seeds)]
    plans = [plan for plan in plans if plan]
    print(json.dumps(plans))


if __name__ == "__main__":
    exit_with("tube", main)
