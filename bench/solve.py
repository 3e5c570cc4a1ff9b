#!/usr/bin/env python3
"""How long `stiction solve` takes to a plan that reaches its goal in MuJoCo, and how many seeds it tries.

    bench/solve.py [--runs 20] [--timeout 120] [--program build/release/stiction] TASK … > solve.json       [-- OPTION …] the rest is handed to `stiction solve`

Run i starts with seed 1000 i. One JSON object on stdout; a line for each run and a table on stderr. Exit code 2 when a program failed, else 0: this
measures, it does not judge.
"""

import pathlib
import statistics

from runs import exit_with, make_parser, measure, parse, run


def solve(arguments, task, run_number, folder):
    out = folder / f"{pathlib.Path(task).stem}-{run_number}"
    words = [arguments.program, "solve", task, "--seed", 1000 * run_number, "--timeout", arguments.timeout, "-o", out, "--json", *arguments.rest]
    code, report, _ = run(words, (0, 3))
    return {"run": run_number, "held": code == 0, "wall_s": report["wall_s"], "seed": report["seed"], "tries": report["tries"]}


def describe(task, row):
    return f"{task} run {row['run']}: {'held' if row['held'] else 'not held'} after {len(row['tries'])} tries, {row['wall_s']:.1f} s"


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
        "median_error_position": statistics.median(row["tries"][-1]["runs"][0]["error"]["position"] for row in held) if held else None,
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
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--timeout", type=float, default=120, help="of one run, all its tries [s]")
    arguments = parse(parser)
    rows_of = lambda task, folder: (solve(arguments, task, number, folder) for number in range(arguments.runs))
    return measure(arguments, rows_of, describe, summarise, table, timeout=arguments.timeout, solve=arguments.rest)


if __name__ == "__main__":
    exit_with("solve", main)
