#!/usr/bin/env python3
"""The pushes of plans, each simulated alone from the state that the plan has at its beginning: how far the object then ends from the plan.

    .venv/bin/python bench/single_pushes.py [--seeds 3] [--timeout 60] [--joint-speed 1] [--friction 0.7] [--plan-friction 0.7] [--processes 1] TASK … > single_pushes.json

A push here is what a plan does between two regrasps. Its commands go at --joint-speed and then rest for 0.3 s. What is left of the distance is what plan and simulation
differ in, without errors of earlier pushes. One JSON object on stdout; a line for each run and a table on stderr. Exit code 2 when a run failed as a program, else 0.
"""

import dataclasses
import statistics
import typing

import numpy as np

from by_task import measure
from by_task import stiction as st
from pushes import make_push_parser, motion, plan_for
from runs import exit_with

REST = 0.3  # [s]


@dataclasses.dataclass(frozen=True)
class SinglePushes:
    timeout_s: float
    plan_friction: float
    friction: float
    joint_speed: float

    columns: typing.ClassVar = ("pushes", "ways", "off")

    def __call__(self, case):
        task, plan, row = plan_for(case, self)
        if plan is None:
            return [row]
        plant = st.Plant(task.model, friction_scale=self.friction, effort_limits=True)
        pushes = list(each_push(plan))
        ways = [tolerances(task, q[0], q[-1]) for _, q in pushes]
        off = [tolerances(task, self.simulate(plant, u, q[0]), q[-1]) for u, q in pushes]
        return [row | {"message": "", "pushes": len(pushes), "ways": listed(ways), "off": listed(off)}]

    def simulate(self, plant, u, q0):
        steps = np.abs(np.diff(u, axis=0)).max(axis=1) / self.joint_speed
        times = np.concatenate([[0], np.cumsum(np.maximum(steps, 1e-3))])
        times = np.append(times, times[-1] + REST)
        return st.simulate(plant, q0, times, np.vstack([u, u[-1:]])).q[-1]


def each_push(plan):
    """Commands and states of the pushes between two regrasps."""
    u, q = [], []
    for segment in plan:
        if segment.kind == st.SegmentKind.Contact:
            u.append(segment.u)
            q.append(segment.q)
        elif u:
            yield np.vstack(u), np.vstack(q)
            u, q = [], []
    if u:
        yield np.vstack(u), np.vstack(q)


def tolerances(task, q0, q1):
    way = motion(task, q0, q1)
    return float(max(np.linalg.norm(way[:3]), np.linalg.norm(way[3:])))


def listed(numbers):
    return " ".join(f"{x:.3f}" for x in numbers)


def numbers(rows, column):
    return [float(x) for row in rows if row[column] for x in row[column].split()]


def describe(row):
    if row["pushes"] is None:
        return "not planned"
    return f"{row['pushes']} pushes, {statistics.median(numbers([row], 'off')):.2f} tolerances off (median)"


def summarise(task, rows):
    off, ways = numbers(rows, "off"), numbers(rows, "ways")
    return {
        "task": task,
        "plans": sum(row["pushes"] is not None for row in rows),
        "pushes": len(off),
        "way": statistics.median(ways) if ways else None,
        "off": statistics.median(off) if off else None,
        "within_half": sum(x < 0.5 for x in off),
        "within_one": sum(x < 1 for x in off),
    }


def table(results):
    lines = ["| task | plans | pushes | way (median) | off (median) | … below 0.5 | … below 1 |", "|---|---|---|---|---|---|---|"]
    for r in results:
        way, off = ("–" if r[what] is None else f"{r[what]:.2f}" for what in ("way", "off"))
        lines.append(f"| `{r['task']}` | {r['plans']} | {r['pushes']} | {way} | {off} | {r['within_half']} | {r['within_one']} |")
    return "\n".join(lines)


def main():
    parser = make_push_parser(__doc__.splitlines()[0])
    parser.add_argument("--joint-speed", type=float, default=1, help="of the joint that moves most [rad/s, m/s]")
    arguments = parser.parse_args()
    run = SinglePushes(arguments.timeout, arguments.plan_friction, arguments.friction, arguments.joint_speed)
    measure(arguments, describe, summarise, table, run=run, processes=arguments.processes)


if __name__ == "__main__":
    exit_with("single_pushes", main)
