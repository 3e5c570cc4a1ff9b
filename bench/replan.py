#!/usr/bin/env python3
"""How often and how fast the planner finds a way from where things are in the middle of motion.

    .venv/bin/python bench/replan.py [--seeds 8] [--states 5] [--threads 2] TASK … > replan.json

Each seed is a run in closed loop. At `states` moments of it, drawn evenly from those at which a piece of a plan was under way, the objects and joints are taken
as they were measured, with the commands in force, and the planner is asked as the run asks it. One JSON object on stdout; a line for each run and a table on
stderr. Exit code 2 when a run failed as a program, else 0: this measures, it does not judge.
"""

import dataclasses
import random
import statistics
import typing

from by_task import make_parser, measure
from by_task import stiction as st
from runs import exit_with

OF_A_RUN = {"friction": 0.7, "tolerance_fraction": 0.5}  # RunOptions::friction and ::plan_fraction


@dataclasses.dataclass(frozen=True)
class Replan:
    states: int
    timeout_s: float
    threads: int

    columns: typing.ClassVar = ("plans", "found", "each")

    def __call__(self, case):
        task = st.load_task(case.task)
        run = st.run(task, seed=case.seed, threads=self.threads, duration=self.timeout_s, timeout_s=5 * self.timeout_s)
        moving = [k for k, piece in enumerate(run.piece) if piece >= 0 and run.pieces[piece].begin_s < run.times[k] < run.pieces[piece].end_s]
        looks = random.Random(case.seed).sample(moving, min(self.states, len(moving)))
        plans = [self.plan(task, run.q[k], run.u[k], seed) for seed, k in enumerate(looks)]
        return [{"status": run.status.name, "plans": len(plans), "found": sum(plan["found"] for plan in plans), "each": plans}]

    def plan(self, task, q, u, seed):
        out = st.plan(task, q_start=q, u_start=u, options=OF_A_RUN, seed=seed, threads=self.threads, timeout_s=self.timeout_s)
        return {"found": out.status == st.Status.Solved, "wall_s": out.wall_s, "reason": out.reason}


def describe(row):
    return f"{row['found']} of {row['plans']} found"


def summarise(task, rows):
    plans = [plan for row in rows for plan in row["each"]]
    return {
        "task": task,
        "states": len(plans),
        "found": sum(plan["found"] for plan in plans),
        "median_s": statistics.median(plan["wall_s"] for plan in plans) if plans else None,
        "refused": sum(bool(plan["reason"]) for plan in plans),
    }


def table(results):
    lines = ["| task | states | found | starts refused | median |", "|---|---|---|---|---|"]
    for r in results:
        median = "–" if r["median_s"] is None else f"{r['median_s']:.2f} s"
        lines.append(f"| `{r['task']}` | {r['states']} | {r['found']} | {r['refused']} | {median} |")
    return "\n".join(lines)


def main():
    parser = make_parser(__doc__.splitlines()[0])
    parser.add_argument("--states", type=int, default=5, help="of each run")
    parser.add_argument("--timeout", type=float, default=20, help="of a plan, and simulated time of a run [s]")
    parser.add_argument("--threads", type=int, default=1, help="of the planner")
    arguments = parser.parse_args()
    measure(arguments, describe, summarise, table, run=Replan(arguments.states, arguments.timeout, arguments.threads), processes=1)


if __name__ == "__main__":
    exit_with("replan", main)
