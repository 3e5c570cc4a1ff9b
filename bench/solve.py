#!/usr/bin/env python3
"""How long `stiction solve` takes to a plan that reaches its goal in MuJoCo, and how many seeds it tries.

    .venv/bin/python bench/solve.py [--seeds 20] [--timeout 120] [--rows FILE] TASK … > solve.json

Run i starts with seed 1000 i, on all cores. One JSON object on stdout; a line for each run and a table on stderr. Exit code 2 when a program failed, else 0: this
measures, it does not judge.
"""

import dataclasses
import statistics
import typing

from by_task import make_parser, measure
from by_task import stiction as st
from runs import exit_with


@dataclasses.dataclass(frozen=True)
class Solve:
    timeout_s: float

    columns: typing.ClassVar = ("held", "wall_s", "tries")

    def __call__(self, case):
        out = st.solve(st.load_task(case.task), seed=1000 * case.seed, timeout_s=self.timeout_s)
        tries = [{"planned": t.status == st.Status.Solved, "accepted": t.accepted, "error_position": t.runs[0].error.position if t.runs else None} for t in out.tries]
        return [{"status": out.status.name, "held": out.status == st.Status.Solved, "wall_s": out.wall_s, "tries": tries}]


def describe(row):
    return f"{'held' if row['held'] else 'not held'} after {len(row['tries'])} tries, {row['wall_s']:.1f} s"


def summarise(task, rows):
    held = [row for row in rows if row["held"]]
    tries = [t for row in rows for t in row["tries"]]
    return {
        "task": task,
        "runs": len(rows),
        "held": len(held),
        "median_s": statistics.median(row["wall_s"] for row in rows),
        "worst_s": max(row["wall_s"] for row in rows),
        "tries": len(tries),
        "planned": sum(t["planned"] for t in tries),
        "accepted": sum(t["accepted"] for t in tries),
        "median_error_position": statistics.median(row["tries"][-1]["error_position"] for row in held) if held else None,
    }


def table(results):
    lines = ["| task | plans that hold | median, worst [s] | tries | planned | accepted | error at the end (median) |", "|---|---|---|---|---|---|---|"]
    for r in results:
        error = "–" if r["median_error_position"] is None else f"{1e3 * r['median_error_position']:.0f} mm"
        lines.append(
            f"| `{r['task']}` | {r['held']} of {r['runs']} | {r['median_s']:.0f}, {r['worst_s']:.0f} | {r['tries']} | {r['planned']} | {r['accepted']} | {error} |"
        )
    return "\n".join(lines)


def main():
    parser = make_parser(__doc__.splitlines()[0])
    parser.add_argument("--timeout", type=float, default=120, help="of one run, all its tries [s]")
    arguments = parser.parse_args()
    measure(arguments, describe, summarise, table, run=Solve(arguments.timeout), processes=1)


if __name__ == "__main__":
    exit_with("solve", main)
