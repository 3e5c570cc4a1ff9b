"""Many runs: tasks × options × seeds × friction, one row of a table for each (docs/sweeps.md)."""

from __future__ import annotations

import dataclasses
import hashlib
import itertools
import json
import math
import os
import resource
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar, Protocol

import numpy as np

from ._causes import find_cause, follow
from ._core import OPEN_LOOP_SPEED, InvalidInput, Plan, PlannerOptions, SegmentKind, SpeedLimits, Status, Task, check_plan, load_task, plan, refine, transfer, version
from ._jobs import Died, Failed, Local, Ray, Stopped, run_all
from ._table import Table, read_rows, to_cell

KEYS = ("task", "options", "seed", "friction")
OUTCOME = ("status", "attempts", "message")


@dataclasses.dataclass(frozen=True)
class Case:
    """What one process works on: a plan, and the simulations of it."""

    task: str
    options: dict[str, Any]  # by name, with dots into maps
    seed: int
    friction: tuple[float | None, ...] = (None,)  # factors of the simulation, one row each; None: not simulated

    def keys(self, friction: float | None) -> dict[str, Any]:
        return {"task": self.task, "options": self.options, "seed": self.seed, "friction": friction}


class Run(Protocol):
    """Base of classes that run a case. A run is a dataclass; its fields distinguish one sweep from another."""

    __dataclass_fields__: ClassVar[dict[str, Any]]
    columns: ClassVar[tuple[str, ...]]

    def __call__(self, case: Case) -> list[dict[str, Any]]:
        """Returns a row with `columns` and `status` for each friction factor of the case."""


@dataclasses.dataclass(frozen=True)
class PlanRun:
    """Run that plans, refines, checks and simulates, on one thread."""

    timeout_s: float = 20.0  # of the planner, and of refinement [s]
    refine: bool = True
    speed: float = OPEN_LOOP_SPEED  # in the simulation, times the full speed that follows from object and motors; above 1 only pushes are faster
    alone: bool = False  # simulate pushes by themselves as well, which tells causes apart
    uniform: bool = False  # speed times SpeedLimits() in place of those

    def __post_init__(self) -> None:
        for name in ("timeout_s", "speed"):
            if not 0 < getattr(self, name) < math.inf:
                raise InvalidInput(f"{name}: got {getattr(self, name)}, expected a number > 0")

    columns: ClassVar[tuple[str, ...]] = (
        "accepted", "refused", "reached", "cause", "piece", "dropped", "error_position", "error_angle", "goal_error_position", "goal_error_angle",
        "normalised_position", "normalised_angle", "regrasp_growth_position", "regrasp_growth_angle", "iterations", "nodes", "knots", "pushes", "regrasps",
        "plan_s", "refine_s", "check_s", "simulate_s", "processor_s", "peak_mb",
    )  # fmt: skip

    def __call__(self, case: Case) -> list[dict[str, Any]]:
        watch = Stopwatch()
        task = load_task(case.task)
        found = plan(task, options=options_of(task, case.options), seed=case.seed, threads=1, timeout_s=self.timeout_s)
        row = {"status": found.status.name, "plan_s": watch.lap(), "iterations": found.iterations, "nodes": found.nodes}
        if found.status != Status.Solved:
            return [row | {"message": found.reason} | watch.spent()] * len(case.friction)
        best = found.plan
        if self.refine:
            best = refine(best, threads=1, timeout_s=self.timeout_s).plan
            row["refine_s"] = watch.lap()
        row |= judge(best) | {"check_s": watch.lap()}
        return [row | self._simulate(best, friction, watch) | watch.spent() for friction in case.friction]

    def _simulate(self, best: Plan, friction: float | None, watch: Stopwatch) -> dict[str, Any]:
        if friction is None:
            return {}
        limits = SpeedLimits(revolute=0.1 * self.speed, prismatic=0.0125 * self.speed) if self.uniform else None
        ran = transfer(best, friction_scale=friction, speed=self.speed, uniform=limits, alone=self.alone, threads=1)
        cause, piece = (None, None) if ran.reached else find_cause(ran, best.task.goal)
        return follow(ran, best.task.goal) | {
            "cause": cause,
            "piece": piece,
            "reached": ran.reached,
            "dropped": None if ran.dropped is None else best.task.model.object_names[ran.dropped],
            "goal_error_position": _finite(ran.error.position),
            "goal_error_angle": _finite(ran.error.angle),
            "simulate_s": watch.lap(),
        }


class Stopwatch:
    """Wall time of laps; processor time and memory of the process so far."""

    def __init__(self) -> None:
        self._last, self._processor = time.monotonic(), time.process_time()

    def lap(self) -> float:
        before, self._last = self._last, time.monotonic()
        return round(self._last - before, 4)

    def spent(self) -> dict[str, float]:
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        return {"processor_s": round(time.process_time() - self._processor, 4), "peak_mb": round(peak, 1)}


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def judge(best: Plan) -> dict[str, Any]:
    """What the checker says of a plan, and how long it is."""
    report = check_plan(best)
    kinds = [segment.kind for segment in best.segments]
    return {
        "accepted": report.pass_,
        "refused": " ".join(item.name for item in report.items if not item.pass_) or None,
        "error_position": best.error.position,
        "error_angle": best.error.angle,
        "knots": len(best.q) - 1,
        "pushes": kinds.count(SegmentKind.Contact),
        "regrasps": kinds.count(SegmentKind.Regrasp),
    }


def options_of(task: Task, changes: Mapping[str, Any]) -> PlannerOptions:
    """Those of the task with others in their place; a name with dots leads into a map. Raises InvalidInput."""
    out = task.options
    for name, value in changes.items():
        first, *rest = name.split(".")
        if rest:
            whole = json.loads(json.dumps(out.to_dict().get(first)))
            inner = whole
            for key in rest[:-1]:
                inner = inner[key] if isinstance(inner, dict) and key in inner else None
            if not isinstance(inner, dict) or rest[-1] not in inner:
                raise InvalidInput(f"options: got '{name}', expected the name of an option, with dots into maps")
            inner[rest[-1]] = value
            value = whole
        out = out.replace(**{first: value})
    return out


def digest(name: str) -> str:
    """Of all that a task says, so that rows of another one are not taken for its own."""
    task = load_task(name)
    goal = json.loads(task.as_plan().to_text())["goal"]  # as a plan file has it: all objects, bounds of coordinates, bystanders
    said = [task.scene_sha256, task.q_start.tolist(), goal, task.options.to_dict()]
    return hashlib.sha256(json.dumps(said, sort_keys=True, default=str).encode()).hexdigest()[:16]


def combinations(options: Mapping[str, Sequence[Any]]) -> list[dict[str, Any]]:
    """Every choice of one value for each option."""
    if not isinstance(options, Mapping):
        raise InvalidInput(f"options: got {options!r}, expected a dict of lists of values")
    return [dict(zip(options, values)) for values in itertools.product(*(_unique(f"options: {name}", values, "values") for name, values in options.items()))]


def _list_of(field: str, values: Any, what: str) -> list[Any]:
    """Also of an array or a generator; numbers of NumPy become those of Python."""
    if isinstance(values, np.ndarray):
        values = values.tolist()
    if isinstance(values, (str, bytes, Mapping)) or not isinstance(values, Iterable):
        got = repr(values) if isinstance(values, (str, bytes, int, float, Mapping)) else f"a {type(values).__name__}"
        raise InvalidInput(f"{field}: got {got}, expected a list of {what}")
    return [value.item() if isinstance(value, np.generic) else value for value in values]


def _unique(field: str, values: Any, what: str) -> list[Any]:
    out = _list_of(field, values, what)
    if not out or len({to_cell(value) for value in out}) < len(out):
        raise InvalidInput(f"{field}: got {out}, expected at least one, each once")
    return out


def read_seeds(seeds: int | Iterable[int]) -> list[int]:
    """n: 0 to n - 1."""
    if isinstance(seeds, (int, np.integer)) and not isinstance(seeds, bool):
        seeds = range(int(seeds))
    out = _unique("seeds", seeds, "seeds, or the number of seeds")
    if not all(isinstance(seed, int) and not isinstance(seed, bool) and seed >= 0 for seed in out):
        raise InvalidInput(f"seeds: got {out}, expected integers ≥ 0")
    return out


def read_friction(friction: Iterable[float] | None) -> list[float | None]:
    if friction is None:
        return [None]
    given = [float(factor) if isinstance(factor, (int, float)) else factor for factor in _list_of("friction", friction, "factors")]
    if not all(isinstance(factor, float) and 0 <= factor < math.inf for factor in given):
        raise InvalidInput(f"friction: got {given}, expected factors ≥ 0")
    return _unique("friction", given, "factors")


@dataclasses.dataclass(frozen=True)
class Progress:
    """Of a sweep; runs are rows."""

    done: int  # with those that were there
    total: int
    elapsed_s: float
    left_s: float | None  # by the runs so far; None before the first one
    rows: list[dict[str, Any]]  # that came last


def sweep(
    tasks: str | os.PathLike[str] | Iterable[str | os.PathLike[str]],
    *,
    seeds: int | Iterable[int] = 1,
    friction: Iterable[float] | None = None,
    options: Mapping[str, Sequence[Any]] | None = None,
    out: str | os.PathLike[str] = "sweep.csv",
    run: Run | None = None,
    processes: int | None = None,
    ray: str | None = None,
    on_progress: Callable[[Progress], object] | None = None,
) -> list[dict[str, Any]]:
    """Runs every task with every choice of options and every seed, and writes one row of a table for each run (docs/sweeps.md).

    tasks: names or files of tasks.
    seeds: a number n for the seeds 0 to n - 1, or the seeds themselves.
    friction: factors of every coefficient of friction in the simulation. None: plans are not simulated.
    options: values of planner options by name, with dots for nested options: {"goal_bias": [0.3, 0.5]}.
    out: the table, .csv, or .parquet if pyarrow is installed. A row is appended when its run ends. A call with the same arguments continues
      an interrupted sweep.
    run: what each run does. None: PlanRun(), which plans, refines, checks and simulates.
    processes: number of parallel processes, each with one thread. None: one per core.
    ray: address of a Ray cluster to use instead; `local` starts one on this machine.
    on_progress: function that is called with Progress.

    Returns the rows. If the process of a run dies, the run is tried again, and then recorded with the status Died. Raises InvalidInput;
    MissingExtra: `pip install stiction[ray]`. If `run` is a class of your own script, call sweep() under `if __name__ == "__main__":`, as for
    any other use of processes.

        >>> rows = st.sweep("planar_pushing", seeds=1, out="sweep.csv", processes=1)
        >>> [(row["seed"], row["accepted"]) for row in rows]
        [(0, True)]
    """
    given = _list_of("tasks", [tasks] if isinstance(tasks, (str, os.PathLike)) else tasks, "names or files of tasks")
    for name in given:
        if not isinstance(name, (str, os.PathLike)):  # a Task as well: each process reads the file
            raise InvalidInput(f"tasks: got a {type(name).__name__}, expected names or files of tasks")
    names = _unique("tasks", map(str, given), "names or files of tasks")
    options = {} if options is None else options
    choices = combinations(options)
    options = {name: _list_of(f"options: {name}", values, "values") for name, values in options.items()}
    run = PlanRun() if run is None else run
    frictions, numbers = read_friction(friction), read_seeds(seeds)
    for name, choice in itertools.product(names, choices):
        options_of(load_task(name), choice)  # one clear message before anything is started
    spec = {
        "format": "stiction-sweep",
        "format_version": 1,
        "code_version": version(),
        "tasks": {name: digest(name) for name in names},
        "options": options,
        "seeds": numbers,
        "friction": frictions,
        "run": {"name": type(run).__name__, **{k: v if isinstance(v, (bool, int, float)) else str(v) for k, v in dataclasses.asdict(run).items()}},
    }
    cases = make_cases(names, choices, numbers, frictions)
    return run_cases(Path(out), spec, run, cases, lambda: Ray(ray, processes) if ray is not None else Local(processes), on_progress)


def run_cases(
    out: Path, spec: dict[str, Any], run: Run, cases: list[Case], backend: Callable[[], Any], on_progress: Callable[[Progress], object] | None = None
) -> list[dict[str, Any]]:
    """The rows of cases: those that the table has already, and a row for each of the others, which is appended as it ends."""
    total = sum(len(case.friction) for case in cases)
    table = Table(out, [*KEYS, *OUTCOME, *run.columns], spec)
    try:
        left = without_rows(cases, {key_of(row) for row in table.rows})
        _run(table, backend() if left else None, run, left, total, on_progress)
    finally:
        table.close()
    return table.rows


def read_table(file: str | os.PathLike[str]) -> list[dict[str, Any]]:
    """Reads the rows of a table of sweep(), .csv or .parquet. Values are numbers, strings, lists and dicts."""
    return read_rows(Path(file))


def key_of(row: Mapping[str, Any]) -> tuple[str, ...]:
    friction = row["friction"]  # a spreadsheet writes 1.0 as 1
    return tuple(map(to_cell, (row["task"], row["options"], row["seed"], None if friction is None else float(friction))))


def make_cases(names: list[str], choices: list[dict[str, Any]], seeds: list[int], frictions: list[float | None]) -> list[Case]:
    """Seeds come last, so that a part of a sweep has all its tasks."""
    return [Case(name, choice, seed, tuple(frictions)) for seed, name, choice in itertools.product(seeds, names, choices)]


def without_rows(cases: list[Case], there: set[tuple[str, ...]]) -> list[Case]:
    """What is left to do of them."""
    parts = [dataclasses.replace(case, friction=tuple(f for f in case.friction if key_of(case.keys(f)) not in there)) for case in cases]
    return [case for case in parts if case.friction]


def _run(table: Table, backend: Any, run: Run, cases: list[Case], total: int, on_progress: Callable[[Progress], object] | None) -> None:
    start, cases_done = time.monotonic(), 0
    there = total - sum(len(case.friction) for case in cases)
    tell = on_progress or (lambda progress: None)
    tell(Progress(there, total, 0.0, None if cases else 0.0, []))
    if not cases:
        return
    for case, attempts, result in run_all(backend, run, cases):
        rows = table.add(rows_of(case, attempts, result))
        cases_done += 1
        there += len(rows)
        elapsed = time.monotonic() - start
        tell(Progress(there, total, elapsed, elapsed / cases_done * (len(cases) - cases_done), rows))


def rows_of(case: Case, attempts: int, result: Any) -> list[dict[str, Any]]:
    """Those of a case, with what they are rows of."""
    if isinstance(result, (Died, Failed, Stopped)):
        result = [{"status": type(result).__name__, "message": result.message}] * len(case.friction)
    return [case.keys(friction) | {"attempts": attempts} | row for friction, row in zip(case.friction, result, strict=True)]
