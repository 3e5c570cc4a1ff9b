"""`stiction benchmark`"""

from __future__ import annotations

import argparse
import contextlib
import dataclasses
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from . import _command
from ._benchmark_failures import PICTURES
from ._benchmark_page import Report, summarise, write_pages
from ._benchmark_peers import ROWS, load_peers
from ._benchmark_tasks import ENTRIES, SETS, Entry, find_packages
from ._jobs import Vanished
from ._pictures import draw_tasks
from ._sweep_command import Line, read_seeds
from ._benchmark import BenchmarkRun, benchmark, versions
from .sweeps import read_seeds as list_seeds

DEFAULT = BenchmarkRun("")


def make_parser() -> argparse.ArgumentParser:
    parser = _command.make_parser(
        "benchmark",
        f"Plans, checks and carries out {len(ENTRIES)} tasks on scenes of other projects, with default settings. The same command continues an interrupted benchmark.",
        f"Sets: {', '.join(SETS)}. Scenes are those of the packages of `pip install 'stiction[benchmark]'`, or of wheels unpacked in one folder.",
    )
    parser.add_argument("words", nargs="*", metavar="SET|TASK", help="sets or names of tasks (default: all)")
    parser.add_argument("--scenes", type=Path, metavar="FOLDER", help="folder that contains the packages of the scenes side by side; they need not be installed")
    parser.add_argument("--seeds", metavar="N|A:B|A,B", default="1", help="seeds 0 to N - 1, A to B - 1, or the given seeds (default: 1)")
    parser.add_argument("--plan-budget", type=_command.positive, metavar="S", default=DEFAULT.plan_budget_s, help="largest processor time of a search [s] (default: %(default)g)")
    parser.add_argument("--duration", type=_command.positive, metavar="S", default=DEFAULT.duration_s, help="length of a run by the clock of the plant, planning included [s] (default: %(default)g)")
    parser.add_argument("-j", "--processes", type=_command.integer(1, 1024), metavar="N", help="number of parallel processes, each with one thread (default: one per core)")
    parser.add_argument("--ray", metavar="ADDRESS", help="run on the Ray cluster at HOST:PORT, auto or local; its machines have the packages and FOLDER at the same paths")
    parser.add_argument("-o", "--out", type=Path, default=Path("benchmark"), metavar="FOLDER", help="folder for the tasks, results.csv, benchmark.md, and other pages and pictures (default: %(default)s)")
    parser.add_argument("--no-pictures", action="store_true", help="do not draw a picture of each task")
    parser.add_argument("--parquet", action="store_true", help="also write results.parquet")
    parser.add_argument("--list", action="store_true", help="print the tasks and exit")
    return parser


def main(words: Sequence[str]) -> int:
    parsed = make_parser().parse_args(words)
    if parsed.list:
        return list_tasks(parsed)
    run = BenchmarkRun(str(parsed.out.resolve() / "tasks"), parsed.plan_budget, parsed.duration)
    table = parsed.out / ("results.parquet" if parsed.parquet else "results.csv")
    line = Line()
    try:
        with contextlib.redirect_stdout(sys.stderr):  # Ray writes its errors to stdout
            rows, missing = benchmark(
                parsed.words, seeds=list_seeds(read_seeds(parsed.seeds)), out=table, scenes=parsed.scenes, run=run, processes=parsed.processes, ray=parsed.ray, on_progress=line
            )
    except KeyboardInterrupt:
        line.end()
        return _command.fail(words, _command.INTERRUPTED, "Cancelled", f"interrupted; the rows so far are in {table}, the same command goes on")
    except Vanished as error:
        line.end()
        return _command.fail(words, _command.INTERNAL_ERROR, "Error", f"{error}; the rows so far are in {table}, the same command goes on")
    line.end()
    report(parsed, rows, missing, run, table)
    return _command.INTERNAL_ERROR if any(row["status"] in ("Died", "Failed") for row in rows) else _command.DONE


def report(parsed: argparse.Namespace, rows: list[dict[str, Any]], missing: list[Entry], run: BenchmarkRun, table: Path) -> None:
    """Draws, writes the pages, and says what came out."""
    pictures = parsed.out / PICTURES
    names = sorted({row["task"] for row in rows if (Path(run.folder) / f"{row['task']}.yaml").exists()})
    no_pictures = "" if parsed.no_pictures else draw_tasks(Path(run.folder), pictures, names, parsed.processes)
    drawn = frozenset(file.stem for file in pictures.glob("*.webp"))
    page, failures = write_pages(
        Report(rows, versions(find_packages(parsed.scenes)), dataclasses.asdict(run), missing, drawn, "" if drawn else no_pictures, load_peers(), load_peers(ROWS)), parsed.out
    )
    sets = summarise(rows)
    said = {
        line["set"]: f"{line['loaded']} of {line['runs']} loaded, {line['planned']} planned, {line['accepted']} accepted, {line['reached']} reached" for line in sets
    }
    if missing:
        said["not run"] = f"{len(missing)} tasks, whose packages are missing"
    if no_pictures:
        said["pictures"] = no_pictures
    files = {"table": str(table), "page": str(page), "failures": str(failures)}
    result = {"status": "Done", "runs": len(rows), "missing": len(missing), **files, "pictures": len(drawn), "no_pictures": no_pictures, "sets": sets}
    _command.report(parsed, f"{len(rows)} runs", said | files, result)


def list_tasks(parsed: argparse.Namespace) -> int:
    packages = find_packages(parsed.scenes)
    lines = {
        entry.name: f"{entry.set}: {entry.test}{'' if entry.wheel is None or entry.wheel in packages else f' (package {entry.wheel} is missing)'}" for entry in ENTRIES
    }
    _command.report(parsed, f"{len(ENTRIES)} tasks", lines, {"status": "Done", "tasks": [{"name": e.name, "set": e.set, "test": e.test, "package": e.wheel, "differs": e.differs} for e in ENTRIES]})
    return _command.DONE
