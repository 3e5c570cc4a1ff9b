#!/usr/bin/env python3
"""First plans of runs carried out once, without a plan anew: how many of their pieces hold, and what the object and the motors did in the push that was given up.

    .venv/bin/python bench/pushes.py [--seeds 8] [--timeout 60] [--speed 0.3] [--friction 0.7] [--plan-friction 0.7] [--processes 1] [--rows FILE] TASK … > pushes.json

One JSON object on stdout; a line for each run and a table on stderr. Exit code 2 when a run failed as a program, else 0: this measures, it does not judge.
"""

import collections
import dataclasses
import statistics
import typing

import numpy as np

from by_task import make_parser, measure
from by_task import stiction as st
from runs import exit_with

STUCK, PAST = 0.5, 1.2  # of the way that was planned for the object until then …
LEAST = 0.3  # … where that is so long [tolerances]
FULL = 0.95  # of its effort: a motor that has no more to give


@dataclasses.dataclass(frozen=True)
class Pushes:
    timeout_s: float
    plan_friction: float
    speed: float
    friction: float

    columns: typing.ClassVar = ("planned", "held", "reached", "dropped", "ended", "planned_share", "off", "load", "planned_load", "push_s")

    def __call__(self, case):
        task, plan, row = plan_for(case, self)
        if plan is None:
            return [row]
        run = st.run(plan, replans=0, threads=1, timeout_s=600, duration=600, finger_gait=False, speed=self.speed, friction_scale=self.friction)
        row |= {"message": "", "planned": count_pieces(plan), "held": sum(not piece.given_up for piece in run.pieces), "reached": run.reached, "dropped": run.dropped is not None}
        if run.pieces and run.pieces[-1].given_up:
            row |= look_at(run, task)
        return [row]


def plan_for(case, measurement):
    """The task of a case, its plan with the options of a run or None, and the row so far."""
    task = st.load_task(case.task)
    found = st.plan(task, seed=case.seed, threads=1, timeout_s=measurement.timeout_s, options={"friction": measurement.plan_friction, "tolerance_fraction": 0.5})
    row = dict.fromkeys(measurement.columns) | {"status": found.status.name, "message": found.reason}
    return task, found.plan if found.status == st.Status.Solved else None, row


def count_pieces(plan):
    """Regrasps, and pushes between them."""
    kinds = [segment.kind for segment in plan if segment.kind != st.SegmentKind.Settle]
    return sum(kind == st.SegmentKind.Regrasp or k == 0 or kinds[k - 1] == st.SegmentKind.Regrasp for k, kind in enumerate(kinds))


def rotation(q):
    x, y, z, w = q
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


def turn_between(q0, q1):
    """Rotation vector; of less than half a turn."""
    R = rotation(q1) @ rotation(q0).T
    sine = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2
    angle = np.arctan2(np.linalg.norm(sine), (np.trace(R) - 1) / 2)
    return sine if angle < 1e-9 else sine * angle / np.linalg.norm(sine)


def motion(task, q0, q1):
    """Of a free object that is first in q, in tolerances."""
    return np.hstack([(q1[:3] - q0[:3]) / task.goal.tol_position, turn_between(q0[3:7], q1[3:7]) / task.goal.tol_angle])


def look_at(run, task):
    """Where the object went in the piece that was given up, by the way that was planned for it until then."""
    last = run.pieces[-1]
    at = [k for k, (time, piece) in enumerate(zip(run.times, run.piece, strict=True)) if piece == len(run.pieces) - 1 and last.begin_s <= time <= last.end_s + 1e-9]
    if len(at) < 2:
        return {"ended": "at once", "off": last.off}
    n_a, per_effort = task.model.n_a, task.model.stiffness / task.model.effort
    planned, went = (motion(task, q[at[0]], q[at[-1]]) for q in (run.q_plan, run.q))
    moves = np.linalg.norm(planned) >= LEAST
    share = float(planned @ went / (planned @ planned)) if moves else None
    load = [float(np.abs((run.u[at] - q[at, -n_a:]) * per_effort).max()) for q in (run.q, run.q_plan)]
    ended = "beside" if share is None else "behind" if share < STUCK else "past" if share > PAST else "beside"
    return {"ended": ended, "planned_share": share, "off": last.off, "load": load[0], "planned_load": load[1], "push_s": last.end_s - last.begin_s}


def describe(row):
    if row["planned"] is None:
        return "not planned"
    end = "reached" if row["reached"] else "dropped" if row["dropped"] else "held" if row["ended"] is None else f"given up {row['ended']} of its path"
    way = "" if row["planned_share"] is None else f" with {row['planned_share']:.2f} of the way"
    went = "" if row["load"] is None else f", {row['off']:.1f} tolerances off{way}, motors at {row['load']:.2f}, planned {row['planned_load']:.2f}"
    return f"{row['held']} of {row['planned']} pieces, {end}{went}"


def summarise(task, rows):
    planned = [row for row in rows if row["planned"] is not None]
    lost = [row for row in planned if row["ended"]]
    return {
        "task": task,
        "plans": len(planned),
        "planned": sum(row["planned"] for row in planned),
        "held": sum(row["held"] for row in planned),
        "reached": sum(row["reached"] for row in planned),
        "dropped": sum(row["dropped"] for row in planned),
        "ended": dict(collections.Counter(row["ended"] for row in lost)),
        "full": sum((row["load"] or 0) >= FULL for row in lost),
        "median_off": statistics.median(row["off"] for row in lost) if lost else None,
    }


def table(results):
    lines = ["| task | plans | pieces that held | reached | dropped | given up | … with a motor at its limit | off (median) |", "|---|---|---|---|---|---|---|---|"]
    for r in results:
        ended = ", ".join(f"{count} {what}" for what, count in r["ended"].items()) or "–"
        off = "–" if r["median_off"] is None else f"{r['median_off']:.1f}"
        lines.append(f"| `{r['task']}` | {r['plans']} | {r['held']} of {r['planned']} | {r['reached']} | {r['dropped']} | {ended} | {r['full']} | {off} |")
    return "\n".join(lines)


def make_push_parser(description):
    """For measurements of pushes: plan and simulation with a friction each."""
    parser = make_parser(description)
    parser.add_argument("--timeout", type=float, default=60, help="of the planner [s]")
    parser.add_argument("--plan-friction", type=float, default=0.7, help="of the plan, times that of the scene, as in runs")
    parser.add_argument("--friction", type=float, default=1, help="of the simulation, times that of the scene")
    parser.add_argument("--processes", type=int, default=1, help="runs at a time")
    return parser


def main():
    parser = make_push_parser(__doc__.splitlines()[0])
    parser.add_argument("--speed", type=float, default=1, help="as of stiction run")
    arguments = parser.parse_args()
    measure(arguments, describe, summarise, table, run=Pushes(arguments.timeout, arguments.plan_friction, arguments.speed, arguments.friction), processes=arguments.processes)


if __name__ == "__main__":
    exit_with("pushes", main)
