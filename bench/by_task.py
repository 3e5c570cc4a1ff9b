"""What the benchmarks that sweep over tasks share: their command line, and results by task."""

import argparse
import json
import pathlib
import sys
import tempfile

from runs import ROOT

sys.path.insert(0, str(ROOT / "build/release/python"))
import stiction  # noqa: E402


def make_parser(description, tasks=None):
    """Tasks have a default where `tasks` are given."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("tasks", nargs="*" if tasks else "+", default=tasks, metavar="TASK", help="names or files")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--first-seed", type=int, default=0)
    parser.add_argument("--rows", type=pathlib.Path, help="keep a row per run in this table; the same command goes on with it")
    return parser


def measure(arguments, describe, summarise, table, **settings):
    """Results by task of a sweep: one JSON object on stdout; a line for each run and a table on stderr. settings: of stiction.sweep()."""
    with tempfile.TemporaryDirectory() as temporary:
        rows = stiction.sweep(
            arguments.tasks,
            seeds=range(arguments.first_seed, arguments.first_seed + arguments.seeds),
            out=arguments.rows or pathlib.Path(temporary) / "rows.csv",
            on_progress=lambda progress: [print(row["task"], "seed", row["seed"], row.get("message") or describe(row), file=sys.stderr, flush=True) for row in progress.rows],
            **settings,
        )
    if failed := next((row for row in rows if row["status"] in ("Died", "Failed")), None):
        raise RuntimeError(f"{failed['task']} seed {failed['seed']}: {failed['message']}")
    results = [summarise(task, [row for row in rows if row["task"] == task]) for task in arguments.tasks]
    print(table(results), file=sys.stderr)
    print(json.dumps({"seeds": arguments.seeds, "results": results, "rows": rows}))
    return results
