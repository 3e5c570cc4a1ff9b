#!/usr/bin/env python3
"""Plans tasks with many seeds, refines every plan and runs it open loop in MuJoCo: how often the goal is reached, and what went wrong where it is not.

    bench/transfer.py [--seeds 20] [--timeout 20] [--no-refine] [--program build/release/stiction] [-j 1] TASK … > transfer.json
                      [-- OPTION …]        the rest is handed to `stiction simulate`, for example -- --speed 0.5

One JSON object on stdout; a line for each run and a table on stderr. Exit code 2 when a program failed, else 0: this measures, it does not judge.

A run that misses is lost in one piece: the one after whose start the object was never again within 20 mm and 0.2 rad of where the plan has it. Its cause is
    drop       an object fell; the run ends there
    regrasp    the object left while the robot moved to new contacts
    model      the push misses by more than half of the tolerances even when it is started from the planned state at rest
    amplified  the push started alone follows its plan: what earlier pieces left behind grew
    simulation MuJoCo refused to go on
    push       one of these two: not told apart with --whole-only
    sum        no piece is the one: the errors of all pieces together
"""

import concurrent.futures
import pathlib
import statistics

from runs import exit_with, make_parser, measure, parse, run

CODES = (0, 1, 3)
TOLERANCE = {"position": 0.02, "angle": 0.2}


def share(error, moment):
    """Of the tolerances."""
    return max(error[f"{moment}_{kind}"] / tolerance for kind, tolerance in TOLERANCE.items())


def find_cause(report):
    """(cause, number of the piece) of a run that missed its goal."""
    pieces = report["pieces"]
    if report["dropped"] is not None:
        number = next((i for i, piece in enumerate(pieces) if report["dropped_s"] <= piece["end_s"]), len(pieces) - 1)
        return "drop", number
    if any(piece["in_plan"] is None for piece in pieces):
        return "simulation", sum(piece["in_plan"] is not None for piece in pieces)
    inside = [i for i, piece in enumerate(pieces) if share(piece["in_plan"], "start") <= 1]
    if not inside or all(share(piece["in_plan"], "end") <= 1 for piece in pieces):
        return "sum", len(pieces) - 1
    number = inside[-1]
    piece = pieces[number]
    if share(piece["in_plan"], "end") <= 1:
        return "sum", number  # between two pieces, or after the last one
    if piece["kind"] == "regrasp":
        return "regrasp", number
    if piece["alone"] is None:
        return "push", number
    return ("model" if share(piece["alone"], "end") > 0.5 else "amplified"), number


def transfer(program, folder, task, seed, arguments):
    out = folder / f"{pathlib.Path(task).stem}-{seed}"
    code, plan, plan_s = run([program, "plan", task, "--seed", seed, "--timeout", arguments.timeout, "--threads", 1, "-o", out, "--json"], CODES)
    row = {"seed": seed, "planned": code == 0, "plan_processor_s": plan_s, "regrasp_counts": plan["regrasps"]}
    if code != 0:
        return row
    target = out
    if not arguments.no_refine:
        _, refined, refine_s = run([program, "refine", out, "--json"], CODES)
        target = out / "refined"
        row |= {"refine_processor_s": refine_s} | {key: refined[key] for key in ("variant", "rests", "h", "pushes", "regrasps", "least_clearance")}
    check_code, check, _ = run([program, "check", target, "--json"], CODES)
    row |= {"accepted": check_code == 0, "refused": [item["name"] for item in check["checks"] if not item["pass"]]}
    _, report, simulate_s = run([program, "simulate", target, "--threads", 1, "--json", *arguments.rest], CODES)
    keys = ("status", "reached", "error", "dropped", "dropped_s", "duration_s", "max_penetration")
    row |= {"simulate_processor_s": simulate_s} | {key: report[key] for key in keys}
    if not report["reached"]:
        row["cause"], row["piece"] = find_cause(report)
    for kind in ("contact", "regrasp"):
        errors = [piece["in_plan"] for piece in report["pieces"] if piece["kind"] == kind and piece["in_plan"]]
        for what in ("position", "angle"):
            row[f"{kind}_growth_{what}"] = [e[f"end_{what}"] - e[f"start_{what}"] for e in errors]
    for what in ("position", "angle"):
        row[f"normalised_{what}"] = [p["alone"][f"normalised_{what}"] for p in report["pieces"] if p["alone"] and p["alone"][f"length_{what}"] > 5e-3]
    return row


def describe(task, row):
    head = f"{task} seed {row['seed']}: "
    if not row["planned"]:
        return head + "not planned"
    error = f"{1e3 * row['error']['position']:.1f} mm {row['error']['angle']:.3f} rad"
    end = "reached" if row["reached"] else f"{row['cause']} in piece {row['piece']}"
    refined = f"{row['variant']}, {1e3 * row['least_clearance']:.0f} mm, " if "variant" in row else ""
    refused = "" if row["accepted"] else f", refused: {', '.join(row['refused'])}"
    return f"{head}{refined}{row['duration_s']:.0f} s, {error}, {end}{refused}"


def median(values):
    values = [value for value in values if value is not None]
    return statistics.median(values) if values else None


def summarise(task, rows):
    planned = [row for row in rows if row["planned"]]
    causes = {}
    for row in planned:
        if not row["reached"]:
            causes[row["cause"]] = causes.get(row["cause"], 0) + 1
    every = lambda key: [value for row in planned for value in row[key]]
    return {
        "task": task,
        "runs": len(rows),
        "planned": len(planned),
        "accepted": sum(row["accepted"] for row in planned),
        "reached": sum(row["reached"] for row in planned),
        "dropped": sum(row["dropped"] is not None for row in planned),
        "causes": dict(sorted(causes.items(), key=lambda item: -item[1])),
        "median_plan_processor_s": median([row["plan_processor_s"] for row in rows]),
        "median_error_position": median([row["error"]["position"] for row in planned]),
        "median_error_angle": median([row["error"]["angle"] for row in planned]),
        "median_normalised_position": median(every("normalised_position")),
        "median_normalised_angle": median(every("normalised_angle")),
        "worst_regrasp_growth_position": max(every("regrasp_growth_position"), default=None),
        "worst_regrasp_growth_angle": max(every("regrasp_growth_angle"), default=None),
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
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--first-seed", type=int, default=0)
    parser.add_argument("--timeout", type=float, default=20, help="of the planner [s]")
    parser.add_argument("--no-refine", action="store_true", help="run the plans as the planner made them")
    parser.add_argument("-j", "--jobs", type=int, default=1, help="runs at a time")
    arguments = parse(parser)
    seeds = range(arguments.first_seed, arguments.first_seed + arguments.seeds)
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        rows_of = lambda task, folder: pool.map(lambda seed: transfer(arguments.program, folder, task, seed, arguments), seeds)
        return measure(arguments, rows_of, describe, summarise, table, seeds=arguments.seeds, simulate=arguments.rest)


if __name__ == "__main__":
    exit_with("transfer", main)
