"""What the benchmarks that run the program task after task share: their command line, a run of the program, rows and tables of tasks."""

import argparse
import dataclasses
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[1]


@dataclasses.dataclass
class Run:
    code: int
    text: str  # on stdout
    peak_mb: float  # resident memory
    processor_s: float
    wall_s: float


def measure_run(words):
    """A run of a program, whatever comes of it."""
    with tempfile.TemporaryFile("w+") as out:
        start = time.monotonic()
        process = subprocess.Popen([str(word) for word in words], stdout=out, stderr=subprocess.DEVNULL)
        _, status, usage = os.wait4(process.pid, 0)
        wall = time.monotonic() - start
        process.returncode = os.waitstatus_to_exitcode(status)
        out.seek(0)
        return Run(process.returncode, out.read(), usage.ru_maxrss / 1024, usage.ru_utime + usage.ru_stime, wall)


def run(words, codes):
    """Exit code, what was printed on stdout (JSON) and processor time [s]. RuntimeError where the exit code is none of `codes`."""
    done = measure_run(words)
    if done.code not in codes:
        raise RuntimeError(f"{' '.join(map(str, words))}: exit code {done.code}")
    return done.code, json.loads(done.text), done.processor_s


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
