"""`stiction sweep`"""

from __future__ import annotations

import argparse
import contextlib
import json
import math
import statistics
import sys
import tomllib
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from . import _command
from ._core import OPEN_LOOP_SPEED, InvalidInput
from ._jobs import Vanished
from ._table import to_cell
from .sweeps import PlanRun, Progress, sweep

RUN = {"refine": bool, "timeout_s": (int, float), "speed": (int, float), "alone": bool}  # fields of PlanRun
LARGEST_SEED = 2**64 - 1
MOST_SEEDS = 1_000_000
SPEC: dict[str, Any] = {"tasks": list, "seeds": (int, list), "friction": list, "options": dict} | RUN


def read_seeds(text: str) -> int | list[int]:
    """N, A:B without B, or A,B,C"""
    read = _command.integer(0, LARGEST_SEED)
    with contextlib.suppress(argparse.ArgumentTypeError, ValueError):
        if ":" in text:
            first, end = map(read, text.split(":"))
            if first < end <= first + MOST_SEEDS:
                return list(range(first, end))
        elif "," in text:
            return [read(word) for word in text.split(",")]
        elif 0 < read(text) <= MOST_SEEDS:
            return read(text)
    raise InvalidInput(f"--seeds: got {_command.quote(text)}, expected N > 0, A:B with A < B, or A,B,C: integers, at most {MOST_SEEDS} seeds")


def read_friction(text: str) -> list[float]:
    try:
        return [_command.nonnegative(word) for word in text.split(",")]
    except argparse.ArgumentTypeError:
        raise InvalidInput(f"--friction: got {_command.quote(text)}, expected factors ≥ 0, as in 0.8,1") from None


def read_option(text: str) -> tuple[str, list[Any]]:
    """NAME=VALUE,VALUE: JSON, and words where they are none."""
    name, sign, values = text.partition("=")
    if not name or not sign or not values:
        raise InvalidInput(f"--option: got '{text}', expected NAME=VALUE,VALUE")
    try:
        return name, json.loads(f"[{values}]")
    except ValueError:
        return name, [_value(word) for word in values.split(",")]


def _value(word: str) -> Any:
    try:
        return json.loads(word)
    except ValueError:
        return word


def read_spec(file: Path) -> dict[str, Any]:
    """The arguments in a TOML file. Raises InvalidInput naming file and field."""
    try:
        spec = tomllib.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise InvalidInput(f"{file}: cannot be read ({error.strerror})") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InvalidInput(f"{file}: got no TOML ({error})") from None
    for name, value in spec.items():
        if name not in SPEC:
            raise InvalidInput(f"{file}: got the field '{name}', expected some of {', '.join(SPEC)}")
        if not isinstance(value, SPEC[name]) or (isinstance(value, bool) and SPEC[name] is not bool):
            raise InvalidInput(f"{file}: {name}: got {value!r}, expected {_type_name(SPEC[name])}")
    if "tasks" not in spec:
        raise InvalidInput(f"{file}: tasks: got none, expected a list of names or files")
    return spec


def _type_name(types: Any) -> str:
    return " or ".join(t.__name__ for t in (types if isinstance(types, tuple) else (types,)))


class Line:
    """Progress on stderr: one line that is rewritten, or a line per run where it is no terminal."""

    def __init__(self) -> None:
        self._terminal = sys.stderr.isatty()

    def __call__(self, progress: Progress) -> None:
        left = "" if progress.left_s is None else f", {duration(progress.left_s)} left"
        head = f"{progress.done} of {progress.total}{left}"
        last = progress.rows[-1] if progress.rows else None
        text = head if last is None else f"{head}: {last['task']} seed {last['seed']}{_options(last['options'])} {last['status']}"
        _command.write_text(f"\r\x1b[K{text}" if self._terminal else f"{text}\n", sys.stderr)

    def end(self) -> None:
        if self._terminal:
            _command.write_text("\r\x1b[K", sys.stderr)


def duration(seconds: float) -> str:
    if seconds < 100:
        return f"{math.ceil(seconds)} s"
    return f"{seconds / 60:.0f} min" if seconds < 6000 else f"{seconds / 3600:.1f} h"


def _options(options: dict[str, Any]) -> str:
    return "".join(f" {name}={to_cell(value)}" for name, value in options.items())


def summarise(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """A line for each task, choice of options and friction."""
    groups: dict[tuple[str, ...], list[dict[str, Any]]] = {}
    for row in rows:
        groups.setdefault(tuple(to_cell(row[name]) for name in ("task", "options", "friction")), []).append(row)
    out = []
    for group in groups.values():
        first = group[0]
        times = [row["plan_s"] for row in group if row["plan_s"] is not None]
        out.append(
            {name: first[name] for name in ("task", "options", "friction")}
            | {"runs": len(group), "solved": sum(row["status"] == "Solved" for row in group)}
            | {name: _count(row[name] for row in group) for name in ("accepted", "reached")}
            | {"died": sum(row["status"] in ("Died", "Failed") for row in group)}
            | {"median_plan_s": statistics.median(times) if times else None, "worst_plan_s": max(times, default=None)}
        )
    return out


def _count(outcomes: Iterable[bool | None]) -> int | None:
    """How many are True; None if nothing was tried."""
    known = [outcome for outcome in outcomes if outcome is not None]
    return sum(known) if known else None


def describe(line: dict[str, Any]) -> str:
    parts = [f"{line['solved']} of {line['runs']} solved", f"{line['accepted'] or 0} accepted"]
    if line["friction"] is not None:
        parts.append(f"{line['reached'] or 0} reach the goal at friction × {line['friction']:g}")
    if line["died"]:
        parts.append(f"{line['died']} died")
    if line["median_plan_s"] is not None:
        parts.append(f"planned in {line['median_plan_s']:.2f} s (median), {line['worst_plan_s']:.2f} s at most")
    return ", ".join(parts)


def make_parser() -> argparse.ArgumentParser:
    parser = _command.make_parser(
        "sweep",
        "Plans, refines, checks and simulates many times, and writes one row of a table for each run. The same command continues an interrupted sweep.",
        "A file SPEC.toml gives the same options as fields: " + ", ".join(SPEC) + ".",
    )
    parser.add_argument("tasks", nargs="+", metavar="TASK|SPEC.toml", help="names or files of tasks, or one file that describes the sweep")
    parser.add_argument("--seeds", metavar="N|A:B|A,B", help="seeds 0 to N - 1, A to B - 1, or the given seeds (default: 1)")
    parser.add_argument("--friction", metavar="F,F", help="also simulate, with these factors of every coefficient of friction")
    parser.add_argument("--option", action="append", default=[], metavar="NAME=VALUE,VALUE", help="values of a planner option, with dots for nested options; every choice is run")
    parser.add_argument("--no-refine", action="store_true", help="do not refine plans")
    parser.add_argument("--speed", type=_command.positive, metavar="V", help=f"speed of the simulation, a factor on the full speed that follows from the object and the motors (default: {OPEN_LOOP_SPEED})")
    parser.add_argument("--alone", action="store_true", help="also simulate every push by itself, which shows the causes of failures")
    parser.add_argument("--timeout", type=_command.positive, metavar="S", help="largest wall time of planning, and of refinement [s] (default: 20)")
    parser.add_argument("-j", "--processes", type=_command.integer(1, 1024), metavar="N", help="number of parallel processes, each with one thread (default: one per core)")
    parser.add_argument("--ray", metavar="ADDRESS", help="run on the Ray cluster at HOST:PORT, auto or local")
    parser.add_argument("-o", "--out", type=Path, default=Path("sweep.csv"), metavar="FILE", help="table to write, .csv or .parquet (default: %(default)s)")
    return parser


def arguments_of(parsed: argparse.Namespace) -> dict[str, Any]:
    """What sweep() is called with; the command line goes before the file."""
    spec: dict[str, Any] = {"tasks": parsed.tasks}
    if any(name.endswith(".toml") for name in parsed.tasks):
        if len(parsed.tasks) > 1:
            raise InvalidInput(f"tasks: got {', '.join(parsed.tasks)}, expected tasks, or one file .toml")
        spec = read_spec(Path(parsed.tasks[0]))
    if parsed.seeds is not None:
        spec["seeds"] = read_seeds(parsed.seeds)
    if parsed.friction is not None:
        spec["friction"] = read_friction(parsed.friction)
    if parsed.option:
        names = [text.partition("=")[0] for text in parsed.option]
        if twice := [name for name in names if names.count(name) > 1]:
            raise InvalidInput(f"--option: got '{twice[0]}' more than once, expected all of its values with commas between them")
        spec["options"] = spec.get("options", {}) | dict(map(read_option, parsed.option))
    given = {"timeout_s": parsed.timeout, "speed": parsed.speed, "refine": False if parsed.no_refine else None, "alone": parsed.alone or None}
    fields = {name: spec.pop(name) for name in RUN if name in spec} | {name: value for name, value in given.items() if value is not None}
    values: dict[str, Any] = {name: float(value) if name in ("timeout_s", "speed") else value for name, value in fields.items()}
    spec["run"] = PlanRun(**values)
    return spec


def main(words: Sequence[str]) -> int:
    parsed = make_parser().parse_args(words)
    line = Line()
    try:
        with contextlib.redirect_stdout(sys.stderr):  # Ray writes its errors to stdout
            rows = sweep(**arguments_of(parsed), out=parsed.out, processes=parsed.processes, ray=parsed.ray, on_progress=line)
    except KeyboardInterrupt:
        line.end()
        return _command.fail(words, _command.INTERRUPTED, "Cancelled", f"interrupted; the rows so far are in {parsed.out}, the same command goes on")
    except Vanished as error:
        line.end()
        return _command.fail(words, _command.INTERNAL_ERROR, "Error", f"{error}; the rows so far are in {parsed.out}, the same command goes on")
    line.end()
    results = summarise(rows)
    died = sum(result["died"] for result in results)
    table = {f"{result['task']}{_options(result['options'])}": describe(result) for result in results} | {"table": str(parsed.out)}
    result = {"status": "Done" if not died else "Died", "runs": len(rows), "died": died, "table": str(parsed.out), "results": results}
    _command.report(parsed, f"{len(rows)} runs", table, result)
    return _command.INTERNAL_ERROR if died else _command.DONE
