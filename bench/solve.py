#!/usr/bin/env python3
"""How long `stiction solve` takes to a plan that reaches its goal in MuJoCo, and how many seeds it tries.

    bench/solve.py [--runs 20] [--timeout 120] [--program build/release/stiction] TASK … > solve.json       [-- OPTION …] the rest is handed to `stiction solve`

Run i starts with seed 1000 i. One JSON object on stdout; a line for each run and a table on stderr. Exit code 2 when a program failed, else 0: this
measures, it does not judge.
"""

import argparse
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[1]


def solve(arguments, task, run, folder):
    out = folder / f"{pathlib.Path(task).stem}-{run}"
    words = [arguments.program, "solve", task, "--seed", 1000 * run, "--timeout", arguments.timeout, "-o", out, "--json", *arguments.rest]
    done = subprocess.run([str(word) for word in words], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    if done.returncode not in (0, 3):
        raise RuntimeError(f"{' '.join(map(str, words))}: exit code {done.returncode}")
    report = json.loads(done.stdout)
    return {"run": run, "held": done.returncode == 0, "wall_s": report["wall_s"], "seed": report["seed"], "tries": report["tries"]}


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
    words = sys.argv[1:]
    at = words.index("--") if "--" in words else len(words)
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("tasks", nargs="+", metavar="TASK")
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--timeout", type=float, default=120, help="of one run, all its tries [s]")
    parser.add_argument("--keep", type=pathlib.Path, help="keep the plans in this folder")
    parser.add_argument("--program", type=pathlib.Path, default=ROOT / "build/release/stiction")
    arguments = parser.parse_args(words[:at])
    arguments.rest = words[at + 1 :]

    results, runs = [], {}
    with tempfile.TemporaryDirectory() as temporary:
        folder = arguments.keep or pathlib.Path(temporary)
        for task in arguments.tasks:
            rows = []
            for i in range(arguments.runs):
                row = solve(arguments, task, i, folder)
                print(f"{task} run {i}: {'held' if row['held'] else 'not held'} after {len(row['tries'])} tries, {row['wall_s']:.1f} s", file=sys.stderr, flush=True)
                rows.append(row)
            results.append(summarise(task, rows))
            runs[task] = rows
    print(table(results), file=sys.stderr)
    print(json.dumps({"timeout": arguments.timeout, "solve": arguments.rest, "results": results, "runs": runs}))
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except RuntimeError as error:
        print(f"solve: {error}", file=sys.stderr)
        sys.exit(2)
