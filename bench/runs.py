"""What the benchmarks that run the program task after task share: their command line, a run of the program, rows and tables of tasks."""

import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[1]


def run(words, codes):
    """Exit code, what was printed on stdout (JSON) and processor time [s]. RuntimeError where the exit code is none of `codes`."""
    with tempfile.TemporaryFile("w+") as out:
        process = subprocess.Popen([str(word) for word in words], stdout=out, stderr=subprocess.DEVNULL)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        out.seek(0)
        text = out.read()
    if process.returncode not in codes:
        raise RuntimeError(f"{' '.join(map(str, words))}: exit code {process.returncode}")
    return process.returncode, json.loads(text), usage.ru_utime + usage.ru_stime


def make_parser(description):
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("tasks", nargs="+", metavar="TASK")
    parser.add_argument("--keep", type=pathlib.Path, help="keep plans and simulations in this folder")
    parser.add_argument("--program", type=pathlib.Path, default=ROOT / "build/release/stiction")
    return parser


def parse(parser):
    """What the parser takes, and as `rest` what follows a --."""
    words = sys.argv[1:]
    at = words.index("--") if "--" in words else len(words)
    arguments = parser.parse_args(words[:at])
    arguments.rest = words[at + 1 :]
    return arguments


def measure(arguments, rows_of, describe, summarise, table, **settings):
    """One JSON object on stdout; a line for each row and a table on stderr. rows_of(task, folder) yields the rows of a task in order."""
    results, runs = [], {}
    with tempfile.TemporaryDirectory() as temporary:
        for task in arguments.tasks:
            rows = []
            for row in rows_of(task, arguments.keep or pathlib.Path(temporary)):
                print(describe(task, row), file=sys.stderr, flush=True)
                rows.append(row)
            results.append(summarise(task, rows))
            runs[task] = rows
    print(table(results), file=sys.stderr)
    print(json.dumps(settings | {"results": results, "runs": runs}))
    return 0


def exit_with(name, main):
    """Exit code 2 and the reason where a program failed."""
    try:
        sys.exit(main())
    except RuntimeError as error:
        print(f"{name}: {error}", file=sys.stderr)
        sys.exit(2)
