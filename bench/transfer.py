#!/usr/bin/env python3
"""Plans every task with many seeds, refines every plan and runs it open loop in MuJoCo: how often the goal is reached, and what went wrong where it is not.

    .venv/bin/python bench/transfer.py [--seeds 20] [--timeout 20] [--no-refine] [--whole-only] [--speed 1] [--uniform] [-j 1] [--rows FILE] TASK … > transfer.json

One JSON object on stdout; a line for each run and a table on stderr. Exit code 2 when a run failed, else 0: this measures, it does not judge. Causes are
those of python/module/stiction/_causes.py; with --whole-only pushes are not told apart.
"""

import statistics

from by_task import make_parser, measure, stiction
from runs import exit_with


def describe(row):
    if row["reached"] is None:
        return "not planned"
    end = "reached" if row["reached"] else f"{row['cause']} in piece {row['piece']}"
    refused = "" if row["accepted"] else f", refused: {row['refused']}"
    return f"{1e3 * (row['goal_error_position'] or 0):.1f} mm {row['goal_error_angle'] or 0:.3f} rad, {end}{refused}"


def median(values):
    values = [value for value in values if value is not None]
    return statistics.median(values) if values else None


def summarise(task, rows):
    planned = [row for row in rows if row["status"] == "Solved"]
    causes = {}
    for row in planned:
        if not row["reached"]:
            causes[row["cause"]] = causes.get(row["cause"], 0) + 1
    every = lambda key: [value for row in planned for value in row[key] or []]
    known = lambda key: [row[key] for row in planned if row[key] is not None]
    return {
        "task": task,
        "runs": len(rows),
        "planned": len(planned),
        "accepted": sum(row["accepted"] for row in planned),
        "reached": sum(row["reached"] for row in planned),
        "dropped": sum(row["dropped"] is not None for row in planned),
        "causes": dict(sorted(causes.items(), key=lambda item: -item[1])),
        "median_plan_s": median([row["plan_s"] for row in rows]),
        "median_error_position": median(known("goal_error_position")),
        "median_error_angle": median(known("goal_error_angle")),
        "median_normalised_position": median(every("normalised_position")),
        "median_normalised_angle": median(every("normalised_angle")),
        "worst_regrasp_growth_position": max(known("regrasp_growth_position"), default=None),
        "worst_regrasp_growth_angle": max(known("regrasp_growth_angle"), default=None),
    }


def table(results):
    number = lambda value, digits: "–" if value is None else f"{value:.{digits}f}"
    lines = ["| task | planned | accepted | reach the goal | dropped | causes | Δ/L position, orientation | error mm, rad (median) |", "|---|---|---|---|---|---|---|---|"]
    for r in results:
        causes = ", ".join(f"{count} {cause}" for cause, count in r["causes"].items()) or "–"
        position = None if r["median_error_position"] is None else 1e3 * r["median_error_position"]
        lines.append(
            f"| `{r['task']}` | {r['planned']} of {r['runs']} | {r['accepted']} | {r['reached']} | {r['dropped']} | {causes} | "
            f"{number(r['median_normalised_position'], 3)}, {number(r['median_normalised_angle'], 3)} | {number(position, 1)}, {number(r['median_error_angle'], 3)} |"
        )
    return "\n".join(lines)


def main():
    parser = make_parser(__doc__.splitlines()[0])
    parser.add_argument("--timeout", type=float, default=20, help="of the planner [s]")
    parser.add_argument("--no-refine", action="store_true", help="run the plans as the planner made them")
    parser.add_argument("--whole-only", action="store_true", help="only whole plans, not every push by itself")
    parser.add_argument("--speed", type=float, default=1, help="of joints, times those that follow from object and motors, or the uniform ones")
    parser.add_argument("--uniform", action="store_true", help="0.1 rad/s and 0.0125 m/s for any object and robot, with rests of 4 s, times --speed")
    parser.add_argument("-j", "--jobs", type=int, default=1, help="runs at a time")
    arguments = parser.parse_args()
    run = stiction.sweeps.PlanRun(arguments.timeout, not arguments.no_refine, arguments.speed, not arguments.whole_only, arguments.uniform)
    measure(arguments, describe, summarise, table, run=run, friction=[1.0], processes=arguments.jobs)


if __name__ == "__main__":
    exit_with("transfer", main)
