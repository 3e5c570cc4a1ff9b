#!/usr/bin/env python3
"""Runs tasks in closed loop with many seeds: how often the goal is reached, in what time, and why not where it is not.

    .venv/bin/python bench/run.py [--seeds 10] [--timeout 300] [--duration 600] [--processor-seconds 40] [--threads 2] [--planning-rate 1] [--active-hold] [--no-join] [--no-finger-gait] [--start-noise 0.003] [--friction 0.7] [--mass 1.3] [--noise 0.002,0.035] [--delay 0.03]
                                  [--rows FILE] TASK … > run.json

One JSON object on stdout; a line for each run and a table on stderr. Exit code 2 when a run failed as a program, else 0: this measures, it does not judge.
Simulated time has the hold of the goal in it, and planning: its processor time by the rate, 0 leaves it out.
"""

import collections
import dataclasses
import math
import statistics
import typing

import numpy as np

from by_task import make_parser, measure
from by_task import stiction as st
from runs import exit_with


SLIP = 0.1  # m/s faster than planned: an object that its robot threw


@dataclasses.dataclass(frozen=True)
class World:
    """In what the simulation differs from what is known of it."""

    friction: float
    mass: float
    noise: tuple[float, float]  # of poses [m], [rad]
    delay: float
    start: float  # standard deviation of where free objects lie at the start, across gravity [m]


@dataclasses.dataclass(frozen=True)
class Run:
    timeout_s: float
    processor_seconds: float | None
    threads: int
    how: dict
    world: World

    taken: typing.ClassVar = ("reached", "duration_s", "planning_s", "pushes", "regrasps", "replans", "dropped", "largest_effort", "largest_press")
    columns: typing.ClassVar = ("end", "why", *taken, "planning_processor_s", "ended_in", "plans", "true_position", "true_angle", "causes", "again", "slips")

    def __call__(self, case):
        world = {"friction_scale": self.world.friction, "mass_scale": self.world.mass, "pose_noise": self.world.noise, "pose_delay": self.world.delay}
        budget = {"plan_timeout_s": self.timeout_s, "plan_processor_s": self.processor_seconds} if self.processor_seconds else {}
        out = st.run(moved(st.load_task(case.task), self.world.start, case.seed), seed=case.seed, threads=self.threads, timeout_s=self.timeout_s, **budget, **self.how, **world)
        row = {key: getattr(out, key) for key in self.taken}
        row |= {"status": out.status.name, "end": out.end.name, "why": out.message, "plans": len(out.plans)}
        row |= {"true_position": out.true_error.position, "true_angle": out.true_error.angle}
        row["causes"] = [plan.cause for plan in out.plans[1:]]
        row["again"] = [{"solved": plan.status == st.Status.Solved, "processor_s": plan.processor_s, "clock_s": plan.clock_s, "joined": plan.joined} for plan in out.plans[1:]]
        row["slips"] = [speed for piece, speed in zip(out.pieces, out.slip_speeds, strict=False) if piece.kind == st.SegmentKind.Contact]
        row["planning_processor_s"] = sum(plan.processor_s for plan in out.plans)
        row["ended_in"] = ended_in(out)
        return [row]


def moved(task, distance, seed):
    """The task with the object of its goal elsewhere at the start, as a draw of the seed has it: across gravity, by a normal distance [m]."""
    if distance == 0:
        return task
    name = task.model.object_names[task.goal.object]
    pose = task.model.object_pose(task.q_start, name)
    gravity = task.model.scene.gravity / np.linalg.norm(task.model.scene.gravity)
    aside = distance * np.random.default_rng(seed).standard_normal(3)
    position = pose.p + aside - gravity * (gravity @ aside)
    x, y, z, w = task.q_start[3:7]
    start = {"objects": {name: {"position": position.tolist(), "quaternion_wxyz": [w, x, y, z]}}, "joints": task.q_start[-task.model.n_a :].tolist()}
    return st.Task({"base": task.file.name, "name": task.name, "start": start}, base=task.file.parent)


def ended_in(run):
    """The kind of the piece in which a run ended, or rest."""
    within = run.pieces and run.pieces[-1].end_s >= run.times[-1]
    return run.pieces[-1].kind.name if within else "rest"


def percentile(values, share):
    """The least value that this share of the values does not exceed; None of none."""
    return sorted(values)[max(0, math.ceil(share * len(values)) - 1)] if values else None


def describe(row):
    end = "reached" if row["reached"] else f"{row['end']} in {row['ended_in']} ({row['why']})"
    return (
        f"{end}, {row['duration_s']:.1f} s, {row['planning_processor_s']:.1f} s of processors for {row['plans']} plans, {row['pushes']} pushes, {row['regrasps']} regrasps, "
        f"{1e3 * row['true_position']:.1f} mm {row['true_angle']:.3f} rad"
    )


def kind_of(cause):
    """The cause of a plan without its numbers."""
    return " ".join(word for word in cause.split() if not word[0].isdigit())


def summarise(task, rows):
    reached = [row for row in rows if row["reached"]]
    median = lambda key: statistics.median(row[key] for row in reached) if reached else None
    causes = collections.Counter(kind_of(cause) for row in rows for cause in row["causes"])
    again = [plan for row in rows for plan in row["again"]]
    slips = [speed for row in rows for speed in row["slips"]]
    presses = [row["largest_press"] for row in rows if row["largest_press"] is not None]
    return {
        "task": task,
        "plans_again": len(again),
        "plans_joined": sum(plan["joined"] for plan in again),
        "plans_again_solved": sum(plan["solved"] for plan in again),
        "median_plan_again_s": statistics.median(plan["processor_s"] for plan in again) if again else None,
        "p95_plan_again_s": percentile([plan["processor_s"] for plan in again], 0.95),
        "median_press": statistics.median(presses) if presses else None,
        "pushes_slower_than_0.1": sum(speed <= SLIP for speed in slips) / len(slips) if slips and presses else None,
        "largest_slip_speed": max(slips) if slips and presses else None,
        "runs": len(rows),
        "reached": len(reached),
        "dropped": sum(row["dropped"] is not None for row in rows),
        "ends": dict(collections.Counter(row["end"] for row in rows)),
        "dropped_in": dict(collections.Counter(row["ended_in"] for row in rows if row["dropped"] is not None)),
        "causes": dict(causes.most_common()),
        "largest_effort": max(row["largest_effort"] for row in rows),
        **{f"median_{key}": median(key) for key in ("duration_s", "planning_processor_s", "pushes", "regrasps", "replans")},
    }


def table(results):
    number = lambda value, digits=0: "–" if value is None else f"{value:.{digits}f}"
    lines = [
        "| task | reached | dropped | simulated | planning (processors) | pushes | regrasps | replans | time of a replan: found, median, p95 | largest force / weight | pushes without a throw | called for by |",
        "|---|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for r in results:
        causes = ", ".join(f"{count} × {cause}" for cause, count in list(r["causes"].items())[:3]) or "–"
        gentle = "–" if r["pushes_slower_than_0.1"] is None else f"{1e2 * r['pushes_slower_than_0.1']:.0f} %"
        lines.append(
            f"| `{r['task']}` | {r['reached']} of {r['runs']} | {r['dropped']} | {number(r['median_duration_s'], 1)} s | {number(r['median_planning_processor_s'], 1)} s | "
            f"{number(r['median_pushes'])} | {number(r['median_regrasps'])} | {number(r['median_replans'])} | "
            f"{r['plans_again_solved']} of {r['plans_again']}, {number(r['median_plan_again_s'], 2)} s, {number(r['p95_plan_again_s'], 1)} s | {number(r['median_press'], 1)} | {gentle} | {causes} |"
        )
    return "\n".join(lines)


def main():
    parser = make_parser(__doc__.splitlines()[0])
    parser.add_argument("--timeout", type=float, default=300, help="of a run [s]")
    parser.add_argument("--duration", type=float, default=600, help="of a run, by the clock of the simulation [s]")
    parser.add_argument("--processor-seconds", type=float, help="budget of one plan in place of 20 s: seconds of processors, 40 are 20 s of two cores")
    parser.add_argument("--threads", type=int, default=1, help="of the planner")
    parser.add_argument("--planning-rate", type=float, default=1, help="seconds of one core that the planner works within a simulated second; 0: the clock stands still meanwhile")
    parser.add_argument("--active-hold", action="store_true", help="fingers catch a free object that moves while nothing is carried out")
    parser.add_argument("--no-join", action="store_true", help="every plan is searched, and none gone on with")
    parser.add_argument("--no-finger-gait", action="store_true", help="also what would roll out of an open hand is planned for")
    parser.add_argument("--start-noise", type=float, default=0, help="standard deviation of where the object lies at the start, across gravity, drawn from the seed [m]; of a scene with one free object")
    parser.add_argument("--processes", type=int, default=1, help="runs at a time")
    parser.add_argument("--friction", type=float, default=1, help="of the simulation, times that of the scene")
    parser.add_argument("--mass", type=float, default=1, help="of the objects in the simulation, times that of the scene")
    parser.add_argument("--noise", type=lambda text: tuple(map(float, text.split(","))), default=(0.0, 0.0), help="of poses: M,RAD")
    parser.add_argument("--delay", type=float, default=0, help="of poses [s]")
    arguments = parser.parse_args()
    world = World(arguments.friction, arguments.mass, arguments.noise, arguments.delay, arguments.start_noise)
    measure(arguments, describe, summarise, table, run=Run(arguments.timeout, arguments.processor_seconds, arguments.threads, {"duration": arguments.duration, "planning_rate": arguments.planning_rate, "active_hold": arguments.active_hold, "join": not arguments.no_join, "finger_gait": not arguments.no_finger_gait}, world), processes=arguments.processes)


if __name__ == "__main__":
    exit_with("run", main)
