"""Tasks on scenes of others: loaded, planned, checked and carried out with one set of settings (docs/benchmark.md)."""

from __future__ import annotations

import csv
import dataclasses
import hashlib
import math
import time
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, ClassVar

from ._benchmark_story import REFUSALS, Nodes, tell_run, tell_search
from ._benchmark_tasks import WHEELS, Entry, find_packages, select, to_yaml
from ._core import InvalidInput, PlannerOptions, PlanResult, Progress as PlanProgress, RunResult, Status, Task, load_task, plan, run, version
from ._files import require_folder, write_whole
from ._jobs import Local, Ray
from ._table import read_rows, to_cell
from .sweeps import Case, Progress, Stopwatch, judge, run_cases

LOADED_MACHINE = 8  # wall time that a budget of processor time may take, times that budget
START_S = 60.0  # wall time for all that has no budget: loading, meshes, the check


@dataclasses.dataclass(frozen=True)
class BenchmarkRun:
    """Loads a task, plans it, checks the plan and carries it out while the clock goes on, on one thread and with default settings."""

    folder: str  # of task files
    plan_budget_s: float = 15.0  # processor time [s]
    duration_s: float = 60.0  # of a run by the clock of the plant, on which its plans count with their processor time [s]

    def __post_init__(self) -> None:
        for name in ("plan_budget_s", "duration_s"):
            if not 0 < getattr(self, name) < math.inf:
                raise InvalidInput(f"{name}: got {getattr(self, name)}, expected a number > 0")

    columns: ClassVar[tuple[str, ...]] = (
        "task_sha256", "stage", "load_s", "plan_s", "iterations", "nodes", "pushes", "regrasps", "tried", *REFUSALS, "error_position", "error_angle", "knots",
        "accepted", "refused", "reached", "end", "simulated_s", "replans", "goal_error_position", "goal_error_angle", "dropped", "run_s", "search", "timeline", "wall_s", "peak_mb",
    )  # fmt: skip

    @property
    def limit_s(self) -> float:
        """Wall time after which a process is ended."""
        return START_S + LOADED_MACHINE * (self.plan_budget_s + self.duration_s)

    def __call__(self, case: Case) -> list[dict[str, Any]]:
        watch = Stopwatch()
        file = Path(self.folder) / f"{case.task}.yaml"
        row: dict[str, Any] = {"task_sha256": sha_of(file.read_text(encoding="utf-8")), "status": "NotLoaded", "stage": "load"}
        begin = time.monotonic()
        try:
            task = load_task(file)
            row["load_s"] = processor_s()
            self._carry_out(task.with_(options=PlannerOptions(task.model)), case.seed, row)
        except InvalidInput as error:
            row["message"] = str(error).removeprefix(f"{file}:")
        return [row | {"wall_s": round(time.monotonic() - begin, 2), "peak_mb": watch.spent()["peak_mb"]}]

    def _carry_out(self, task: Task, seed: int, row: dict[str, Any]) -> None:
        row |= {"status": "NotPlanned", "stage": "plan"}
        begin, nodes = processor_s(), Nodes()
        found = plan(task, seed=seed, threads=1, timeout_s=LOADED_MACHINE * self.plan_budget_s, on_progress=until(self.plan_budget_s), on_growth=nodes)
        row |= describe_plan(found) | {"plan_s": round(processor_s() - begin, 3)}
        if found.status != Status.Solved:
            row["search"] = tell_search(task, found, nodes.q(task.model.n_q))
            return
        row |= {"status": "NotReached", "stage": "check"}
        row |= judge(found.plan)
        begin = processor_s()
        row["stage"] = "run"
        ran = run(
            found.plan, seed=seed, threads=1, duration=self.duration_s, timeout_s=LOADED_MACHINE * self.duration_s, plan_processor_s=self.plan_budget_s,
            plan_timeout_s=LOADED_MACHINE * self.plan_budget_s,
        )  # fmt: skip
        row |= describe_run(ran, task) | {"run_s": round(processor_s() - begin, 3)}
        row["status"] = "Reached" if ran.reached else "NotReached"
        if not ran.reached:
            row["timeline"] = tell_run(task, ran)


def processor_s() -> float:
    return round(time.process_time(), 3)


def until(budget_s: float) -> Callable[[PlanProgress], bool]:
    """Goes on while this process has used less processor time than that from now on."""
    end = time.process_time() + budget_s
    return lambda _: time.process_time() < end


def sha_of(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def describe_plan(found: PlanResult) -> dict[str, Any]:
    counts = found.regrasps
    return {
        "iterations": found.iterations,
        "nodes": found.nodes,
        "tried": counts["tried"],
        "message": found.reason or None,
    } | {name: counts[name] for name in REFUSALS}


def describe_run(ran: RunResult, task: Task) -> dict[str, Any]:
    return {
        "reached": ran.reached,
        "end": ran.end.name,
        "message": ran.message or None,
        "simulated_s": round(ran.duration_s, 2),
        "replans": ran.replans,
        "goal_error_position": _finite(ran.true_error.position),
        "goal_error_angle": _finite(ran.true_error.angle),
        "dropped": None if ran.dropped is None else task.model.object_names[ran.dropped],
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def write_tasks(entries: Iterable[Entry], packages: Mapping[str, Path], folder: Path) -> tuple[list[Entry], list[Entry]]:
    """Writes a task file for each whose package is there. Returns those, and the others."""
    written, missing = [], []
    for entry in entries:
        if entry.wheel is not None and entry.wheel not in packages:
            missing.append(entry)
            continue
        text = to_yaml(entry, packages)
        write_whole(folder / f"{entry.name}.yaml", lambda to: to.write_text(text, encoding="utf-8"))
        written.append(entry)
    return written, missing


def forget_rows_of_other_tasks(table: Path, folder: Path) -> None:
    """A row of a task that reads otherwise now is run again."""
    file = table.with_suffix(".csv")
    if not file.exists():
        return
    rows = read_rows(file)
    shas = {path.stem: sha_of(path.read_text(encoding="utf-8")) for path in folder.glob("*.yaml")}
    kept = [row for row in rows if row.get("task_sha256") is None or shas.get(row["task"], row["task_sha256"]) == row["task_sha256"]]
    if len(kept) == len(rows):
        return

    def write(to: Path) -> None:
        with to.open("w", encoding="utf-8", newline="") as out:
            writer = csv.writer(out, lineterminator="\n")
            writer.writerows([list(rows[0]), *([to_cell(value) for value in row.values()] for row in kept)])

    write_whole(file, write)


def versions(packages: Mapping[str, Path]) -> dict[str, str]:
    """Of the packages, by the folder NAME-VERSION.dist-info beside each."""
    out = {}
    for name, folder in packages.items():
        infos = sorted(folder.parent.glob(f"{WHEELS[name].replace('-', '_')}-*.dist-info"))
        out[WHEELS[name]] = infos[-1].name.split("-")[1].removesuffix(".dist") if infos else "of unknown version"
    return out


def benchmark(
    words: Iterable[str], *, seeds: Iterable[int], out: Path, scenes: Path | None, run: BenchmarkRun, processes: int | None = None,
    ray: str | None = None, on_progress: Callable[[Progress], object] | None = None,
) -> tuple[list[dict[str, Any]], list[Entry]]:  # fmt: skip
    """The rows of the table `out`, those that were there included, and the tasks whose package is missing. Raises InvalidInput."""
    entries = select(words)
    packages = find_packages(scenes)
    folder = Path(run.folder)
    require_folder(folder / "x")
    written, missing = write_tasks(entries, packages, folder)
    if not written:
        raise InvalidInput(
            f"SET: got tasks of {', '.join(sorted({WHEELS[entry.wheel] for entry in missing if entry.wheel}))}, which is not installed"
            f"{f' below {scenes}' if scenes else ''}, expected them: `pip install 'stiction[benchmark]'`, or --scenes FOLDER where wheels are unpacked"
        )
    forget_rows_of_other_tasks(out, folder)
    spec = {
        "format": "stiction-benchmark",
        "format_version": 3,
        "code_version": version(),
        "plan_budget_s": run.plan_budget_s,
        "duration_s": run.duration_s,
    }
    cases = [Case(entry.name, {}, seed) for seed in seeds for entry in written]
    return run_cases(out, spec, run, cases, lambda: Local(processes, run.limit_s) if ray is None else Ray(ray, processes, run.limit_s), on_progress), missing
