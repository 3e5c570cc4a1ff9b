#!/usr/bin/env python3
"""Bounds of where plans leave their object (`stiction check --tube`), against noisy runs of the same plans in MuJoCo.

    .venv/bin/python bench/tube.py --keep FOLDER [--seeds 3] [--runs 10] [--no-margins] [--factors 1,1] [--linear] TASK … > tube.json

Every plan is made, refined and run open loop in worlds that are drawn from the sets of errors. The factors of the tubes of a task come from the runs of all other
tasks (split conformal prediction, 95 %), so that no task is judged by its own runs. Those of all tasks together are what the library states (kTubeFactors);
--factors judges further tasks with them. Plans and runs are kept in FOLDER, and the same command goes on with them. One JSON object on stdout, a table on stderr.
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
from linear_tube import linear_tube
from runs import exit_with

LEVEL = 0.95
KAPPAS = (None, 1000.0)  # of --linear: derivatives of exact steps, and of smoothed ones
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


def scores(rests, run):
    """By what the radii would have to be larger for a run to stay inside, in position and angle."""
    if len(run["poses"]) < len(rests):
        return math.inf, math.inf
    position = angle = 0.0
    for rest, pose in zip(rests, run["poses"], strict=True):
        position = max(position, float(np.linalg.norm(np.array(pose[:3]) - rest.centre.p)) / rest.position)
        angle = max(angle, rotation_angle(np.array(quaternion(rest.centre.R)), np.array(pose[3:])) / rest.angle)
    return position, angle


def measure_plan(task, seed, arguments):
    plan = make_plan(task, seed, arguments)
    if plan is None:
        return None
    begin = time.process_time()
    tube = st.calc_tube(plan, factors=(1.0, 1.0), scenarios=arguments.scenarios)
    seconds = time.process_time() - begin
    goal, last = plan.task.goal, tube.rests[-1]
    candidate = tube.goal.position <= goal.tol_position and tube.goal.angle <= goal.tol_angle
    runs = get_runs(plan, task, seed, arguments) if candidate or arguments.all_runs else []
    row = {
        "task": task,
        "seed": seed,
        "processor_s": seconds,
        "knots": len(plan.u) - 1,
        "rests": len(tube.rests),
        "lost": tube.lost,
        "tolerance": [goal.tol_position, goal.tol_angle],
        "centre": [math.inf if tube.lost else whole - part for whole, part in ((tube.goal.position, last.position), (tube.goal.angle, last.angle))],
        "radius": [last.position, last.angle],
        "candidate": candidate,
        "scores": [scores(tube.rests, run) for run in runs],
        "reached": sum(run["reached"] for run in runs),
    }
    if arguments.linear:
        tubes = [linear_tube(plan, st.ErrorSets(), kappa) for kappa in KAPPAS]
        row["linear"] = [[rests[-1].position / goal.tol_position, rests[-1].angle / goal.tol_angle] for rests in tubes]
        row["linear_inside"] = [sum(max(scores(rests, run)) <= 1 for run in runs) for rests in tubes]
    print(task, seed, describe(row), file=sys.stderr, flush=True)
    return row


def describe(row):
    part = lambda i: f"{row['centre'][i]:.4f} + {row['radius'][i]:.4f} of {row['tolerance'][i]:.3f}"
    worst = [max((score[i] for score in row["scores"]), default=math.nan) for i in range(2)]
    return f"{part(0)} m, {part(1)} rad, {row['reached']} of {len(row['scores'])} runs reach the goal, worst scores {worst[0]:.2f} {worst[1]:.2f}, {row['processor_s']:.2f} s"


def conformal_quantile(values, level):
    """The smallest value that a further one exceeds with a probability of at most 1 − level, if all are drawn alike."""
    rank = math.ceil((len(values) + 1) * level)
    return sorted(values)[rank - 1] if rank <= len(values) else math.inf


def find_factors(plans):
    """Factors of position and angle within which 95 % of runs stay, both at once: their ratio is that of the 90 % quantiles. No tube is narrower than its
    bundle, and plans that factors of 1 refuse do not count, since larger ones refuse them too."""
    runs = np.array([score for plan in plans if plan["candidate"] for score in plan["scores"]])
    if len(runs) == 0:
        return [math.inf, math.inf], 0
    ratio = np.quantile(runs, 0.9, axis=0, method="inverted_cdf")
    return np.maximum(1.0, conformal_quantile((runs / ratio).max(axis=1).tolist(), LEVEL) * ratio).tolist(), len(runs)


def judge(plan, factors):
    """Verdict and width of a plan with these factors, and how many of its runs stay inside."""
    radius = [factor * r for factor, r in zip(factors, plan["radius"], strict=True)]
    return {
        "accepted": all(c + r <= t for c, r, t in zip(plan["centre"], radius, plan["tolerance"], strict=True)),
        "width": [r / t for r, t in zip(radius, plan["tolerance"], strict=True)],
        "inside": sum(all(s <= factor for s, factor in zip(score, factors, strict=True)) for score in plan["scores"]),
    }


def summarise(task, plans, factors=None):
    """The plans of one task, with factors from all others if none are given."""
    factors, calibrated = (factors, 0) if factors else find_factors([plan for plan in plans if plan["task"] != task])
    own = [(plan, judge(plan, factors)) for plan in plans if plan["task"] == task]
    accepted = [(plan, verdict) for plan, verdict in own if verdict["accepted"]]
    runs = lambda pairs: sum(len(plan["scores"]) for plan, _ in pairs)
    refused = [pair for pair in own if not pair[1]["accepted"]]
    return {
        "task": task,
        "factors": factors,
        "calibrated_on_runs": calibrated,
        "plans": len(own),
        "accepted": len(accepted),
        "accepted_runs": runs(accepted),
        "accepted_inside": sum(verdict["inside"] for _, verdict in accepted),
        "accepted_reached": sum(plan["reached"] for plan, _ in accepted),
        "refused_runs": runs(refused),
        "refused_reached": sum(plan["reached"] for plan, _ in refused),
        "refused_inside": sum(verdict["inside"] for _, verdict in refused),
        "narrow": sum(max(verdict["width"]) <= 1 for _, verdict in own),
        "median_width": [statistics.median(verdict["width"][i] for _, verdict in own) for i in range(2)],
        "processor_s": statistics.median(plan["processor_s"] for plan, _ in own),
        "most_processor_s": max(plan["processor_s"] for plan, _ in own),
    }


def table(results):
    number = lambda value: f"{value:.2f}" if math.isfinite(value) else "∞"
    lines = [
        "| task | factors, of runs of others | within the tolerance | runs inside: of accepted plans, of refused ones | goal reached: accepted, refused | no wider than the tolerance | width / tolerance: position, angle | processor s: median, most |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for r in results:
        lines.append(
            f"| `{r['task']}` | {number(r['factors'][0])}, {number(r['factors'][1])} of {r['calibrated_on_runs']} | {r['accepted']} of {r['plans']} | "
            f"{r['accepted_inside']} of {r['accepted_runs']}, {r['refused_inside']} of {r['refused_runs']} | {r['accepted_reached']} of {r['accepted_runs']}, {r['refused_reached']} of {r['refused_runs']} | "
            f"{r['narrow']} of {r['plans']} | {number(r['median_width'][0])}, {number(r['median_width'][1])} | {r['processor_s']:.2f}, {r['most_processor_s']:.2f} |"
        )
    total = {key: sum(r[key] for r in results) for key in ("accepted", "plans", "accepted_inside", "accepted_runs", "narrow")}
    lines.append(f"accepted {total['accepted']} of {total['plans']} plans; of their {total['accepted_runs']} runs {total['accepted_inside']} stay inside; {total['narrow']} plans no wider than the tolerance")
    return "\n".join(lines)


def main():
    parser = make_parser(__doc__.splitlines()[0])
    parser.set_defaults(seeds=3)
    parser.add_argument("--keep", type=pathlib.Path, required=True)
    parser.add_argument("--runs", type=int, default=10, help="of each plan")
    parser.add_argument("--timeout", type=float, default=60, help="of the planner [s]")
    parser.add_argument("--scenarios", type=int, default=16, help="of a tube")
    parser.add_argument("--all-runs", action="store_true", help="also of plans that are refused with any factor of 1 or more")
    parser.add_argument("--factors", type=lambda text: [float(word) for word in text.split(",")], help="of position and angle, in place of those from the other tasks: POSITION,ANGLE")
    parser.add_argument("--linear", action="store_true", help="also linear propagation of the errors")
    parser.add_argument("--no-margins", action="store_true", help="plans as the options of their tasks have them")
    arguments = parser.parse_args()
    arguments.keep.mkdir(parents=True, exist_ok=True)
    plans = [measure_plan(task, seed, arguments) for task in arguments.tasks for seed in range(arguments.first_seed, arguments.first_seed + arguments.seeds)]
    plans = [plan for plan in plans if plan]
    factors, runs = find_factors(plans)
    print(f"factors of all tasks together: {factors[0]:.3g}, {factors[1]:.3g}, from {runs} runs", file=sys.stderr)
    results = [summarise(task, plans, arguments.factors) for task in arguments.tasks if any(plan["task"] == task for plan in plans)]
    print(table(results), file=sys.stderr)
    for i, kappa in enumerate(KAPPAS if arguments.linear else ()):
        widths = [max(plan["linear"][i]) for plan in plans]
        print(
            f"linear propagation, {'exact steps' if kappa is None else f'smoothed by {kappa:g}/J'}: {sum(w <= 1 for w in widths)} of {len(widths)} plans no wider than the tolerance, "
            f"median {statistics.median(widths):.3g} tolerances; {sum(plan['linear_inside'][i] for plan in plans)} of {sum(len(plan['scores']) for plan in plans)} runs inside",
            file=sys.stderr,
        )
    print(json.dumps({"factors": factors, "calibrated_on_runs": runs, "results": results, "plans": plans}))


if __name__ == "__main__":
    exit_with("tube", main)
