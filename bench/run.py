#!/usr/bin/env python3
"""Runs tasks in closed loop with many seeds: how often the goal is reached, in what time, and why not where it is not.

    bench/run.py [--seeds 10] [--first-seed 0] [--timeout 300] [--program build/release/stiction] [-j 1] TASK … > run.json
                 [-- OPTION …]        the rest is handed to `stiction run`, for example -- --friction 0.7

One JSON object on stdout; a line for each run and a table on stderr. Exit code 2 when the program failed, else 0: this measures, it does not judge.
Simulated time has the hold of the goal in it, and leaves planning out.
"""

import collections
import concurrent.futures
import pathlib
import statistics

from runs import exit_with, make_parser, measure, parse, run

CODES = (0, 3)


def once(program, folder, task, seed, arguments):
    words = [program, "run", task, "--seed", seed, "--timeout", arguments.timeout, "--threads", arguments.threads, "--json", *arguments.rest]
    if arguments.keep:
        words += ["-o", folder / f"{pathlib.Path(task).stem}-{seed}"]
    _, out, _ = run(words, CODES)
    keys = ("status", "message", "reached", "duration_s", "planning_s", "pushes", "regrasps", "replans", "error", "true_error", "dropped", "largest_effort")
    row = {"seed": seed} | {key: out[key] for key in keys}
    row["plans"] = len(out["plans"])
    row["causes"] = [plan["cause"] for plan in out["plans"][1:]]
    row["reasons"] = [plan["reason"] for plan in out["plans"] if plan["reason"]]
    row["again"] = [{"solved": plan["status"] == "Solved", "wall_s": plan["wall_s"]} for plan in out["plans"][1:]]
    row["given_up"] = {kind: sum(p["given_up"] for p in out["pieces"] if p["kind"] == kind) for kind in ("contact", "regrasp")}
    return row


def describe(task, row):
    end = "reached" if row["reached"] else f"{row['status']} ({row['message']})"
    error = f"{1e3 * row['true_error']['position']:.1f} mm {row['true_error']['angle']:.3f} rad"
    return (
        f"{task} seed {row['seed']}: {end}, {row['duration_s']:.1f} s, {row['planning_s']:.1f} s planning, {row['plans']} plans, "
        f"{row['pushes']} pushes, {row['regrasps']} regrasps, {error}"
    )


def kind_of(cause):
    """The cause of a plan without its numbers."""
    return " ".join(word for word in cause.split() if not word[0].isdigit())


def summarise(task, rows):
    reached = [row for row in rows if row["reached"]]
    median = lambda key: statistics.median(row[key] for row in reached) if reached else None
    causes = collections.Counter(kind_of(cause) for row in rows for cause in row["causes"])
    again = [plan for row in rows for plan in row["again"]]
    return {
        "task": task,
        "plans_again": len(again),
        "plans_again_solved": sum(plan["solved"] for plan in again),
        "median_plan_again_s": statistics.median(plan["wall_s"] for plan in again) if again else None,
        "runs": len(rows),
        "reached": len(reached),
        "dropped": sum(row["dropped"] is not None for row in rows),
        "ends": dict(collections.Counter(row["status"] for row in rows)),
        "causes": dict(causes.most_common()),
        "largest_effort": max(row["largest_effort"] for row in rows),
        **{f"median_{key}": median(key) for key in ("duration_s", "planning_s", "pushes", "regrasps", "replans")},
    }


def table(results):
    number = lambda value, digits=0: "–" if value is None else f"{value:.{digits}f}"
    lines = ["| task | reached | dropped | simulated | planning | pushes | regrasps | replans | plans anew: found, median | called for by |", "|---|---|---|---|---|---|---|---|---|---|"]
    for r in results:
        causes = ", ".join(f"{count} × {cause}" for cause, count in list(r["causes"].items())[:3]) or "–"
        lines.append(
            f"| `{r['task']}` | {r['reached']} of {r['runs']} | {r['dropped']} | {number(r['median_duration_s'], 1)} s | {number(r['median_planning_s'], 1)} s | "
            f"{number(r['median_pushes'])} | {number(r['median_regrasps'])} | {number(r['median_replans'])} | {r['plans_again_solved']} of {r['plans_again']}, {number(r['median_plan_again_s'], 2)} s | {causes} |"
        )
    return "\n".join(lines)


def main():
    parser = make_parser(__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--first-seed", type=int, default=0)
    parser.add_argument("--timeout", type=float, default=300, help="of a run [s]")
    parser.add_argument("--threads", type=int, default=1, help="of the planner")
    parser.add_argument("-j", "--jobs", type=int, default=1, help="runs at a time")
    arguments = parse(parser)
    seeds = range(arguments.first_seed, arguments.first_seed + arguments.seeds)
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        rows_of = lambda task, folder: pool.map(lambda seed: once(arguments.program, folder, task, seed, arguments), seeds)
        return measure(arguments, rows_of, describe, summarise, table, seeds=arguments.seeds, options=arguments.rest)


if __name__ == "__main__":
    exit_with("run", main)
