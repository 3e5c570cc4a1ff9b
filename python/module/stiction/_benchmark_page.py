"""The pages of `stiction benchmark`, in Markdown: what was planned and carried out, and what stopped the rest (_benchmark_failures.py)."""

from __future__ import annotations

import statistics
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ._benchmark_failures import MOST_CAUSES, PICTURES, Row, cause_of, chart, number, table, write_failures
from ._benchmark_failures import PAGE as FAILURES
from ._benchmark_peers import Peers, write_peers, write_rows
from ._benchmark_tasks import ENTRIES, SETS, Entry
from ._files import write_whole

PAGE = "benchmark.md"
PICTURE_WIDTH = 160  # in the tables [px]


def _sentences(text: str) -> str:
    """One for each part between semicolons."""
    first, *rest = text.split("; ")
    return ". ".join([first, *(part[:1].upper() + part[1:] for part in rest)]) + "."


def _share(rows: Iterable[Row], holds: Any) -> str:
    rows = list(rows)
    return f"{sum(bool(holds(row)) for row in rows)} of {len(rows)}" if rows else ""


def _planned(row: Row) -> bool:
    return row["stage"] in ("check", "run") and row["status"] in ("Reached", "NotReached")


def _median(values: Iterable[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return statistics.median(known) if known else None


def summarise(rows: Iterable[Row], entries: Iterable[Entry] = ENTRIES) -> list[dict[str, Any]]:
    """A line for each set that has rows, and one for all."""
    rows, set_of = list(rows), {entry.name: entry.set for entry in entries}
    out = []
    for name in (*SETS, "all"):
        group = [row for row in rows if name in (set_of.get(row["task"]), "all")]
        if group:
            causes = Counter(filter(None, map(cause_of, group)))
            out.append(
                {"set": name, "tasks": len({row["task"] for row in group}), "runs": len(group), "loaded": sum(row["load_s"] is not None for row in group)}
                | {"planned": sum(map(_planned, group)), "accepted": sum(row["accepted"] is True for row in group), "reached": sum(row["reached"] is True for row in group)}
                | {"median_plan_s": _median(row["plan_s"] for row in group if _planned(row)), "median_run_s": _median(row["simulated_s"] for row in group if row["reached"])}
                | {"causes": dict(causes.most_common(MOST_CAUSES))}
            )
    return out


@dataclass(frozen=True)
class Report:
    """All that the pages are made of."""

    rows: Sequence[Row]
    packages: Mapping[str, str]  # and their versions
    settings: Mapping[str, float]  # of BenchmarkRun
    missing: Sequence[Entry] = ()  # whose packages are missing
    pictures: frozenset[str] = frozenset()  # names of tasks that have one
    no_pictures: str = ""  # why there are none
    peers: Peers | None = None
    rows_of_goals: Peers | None = None

    def sorted_rows(self) -> list[Row]:
        """By sets, as the page has them."""
        order = {entry.name: k for k, entry in enumerate(sorted(ENTRIES, key=lambda entry: SETS.index(entry.set)))}
        return sorted(self.rows, key=lambda row: (order.get(row["task"], len(order)), row["seed"]))


def write_pages(report: Report, folder: Path) -> list[Path]:
    """The page, that of failures, and charts of runs. Returns the two pages."""
    entries = {entry.name: entry for entry in ENTRIES}
    rows = report.sorted_rows()
    charts = {f"{row['task']}.{row['seed']}": drawn for row in rows if (drawn := chart(row))}
    for old in (folder / PICTURES).glob("*.svg"):
        if old.stem not in charts:
            old.unlink()
    for name, drawn in charts.items():
        _write(folder / PICTURES / f"{name}.svg", drawn)
    failures = write_failures(rows, report.settings, entries, report.pictures, charts)
    return [_write(folder / PAGE, write_page(report)), _write(folder / FAILURES, failures)]


def _write(file: Path, text: str) -> Path:
    return write_whole(file, lambda to: to.write_text(text, encoding="utf-8"))


def write_page(report: Report) -> str:
    entries = {entry.name: entry for entry in ENTRIES}
    rows, settings = report.sorted_rows(), report.settings
    packages = ", ".join(f"{name} {version}" for name, version in report.packages.items()) or "none"
    lines = [
        "# Benchmark: scenes of others",
        "",
        "`stiction benchmark` plans manipulation tasks on scenes that other projects publish, to the goals of their makers. It checks each plan, and carries it out in MuJoCo while the clock goes on. "
        f"All tasks have the same settings, which are the defaults. A [second page]({FAILURES}) says why tasks failed.",
        "",
        "```sh",
        "stiction benchmark push_t_planar planar_pushing -o out/benchmark",
        "```",
        "",
        "Without names the command runs all tasks. A set is a name as well (`joints`, `push`, `in hand`), and `--list` names the tasks. "
        "`pip install 'stiction[benchmark]'` brings the packages of the scenes; `--scenes FOLDER` finds the packages where wheels are unpacked. "
        "The same command goes on where it was interrupted. It writes task files, `results.csv`, both pages and their pictures.",
        "",
        f"Each search has {settings['plan_budget_s']:g} s of processor time on one thread. Each run may take {settings['duration_s']:g} s of simulated time, and the processor time of its plans counts as simulated time. "
        f"Seeds: {', '.join(map(str, sorted({row['seed'] for row in rows})))}. Packages: {packages}.",
        "",
        *([f"There are no pictures: {report.no_pictures}.", ""] if report.no_pictures else []),
        "## Sets",
        "",
    ]
    head = ["set", "tasks", "runs", "loaded", "planned", "plan accepted", "goal reached", "share of runs", "median plan [s]", "median run [s]"]
    lines += table(head, (_set_line(line) for line in summarise(rows)))
    lines += [f"The [most frequent causes]({FAILURES}#most-frequent-causes) of failures are on the other page.", ""]
    lines += write_peers(report.peers) if report.peers else []
    lines += write_rows(report.rows_of_goals) if report.rows_of_goals else []
    for name in SETS:
        group = [row for row in rows if row["task"] in entries and entries[row["task"]].set == name]
        if group:
            lines += [f"## {name.capitalize()}", "", *_task_table(group, entries, report.pictures), *_differences(group, entries)]
    if left := sorted({entry.name for entry in report.missing}):
        lines += ["## Not run", "", f"Packages are missing for {', '.join(f'`{name}`' for name in left)}.", ""]
    return "\n".join(lines)


def _set_line(line: Mapping[str, Any]) -> list[str]:
    counts = (str(line[name]) for name in ("tasks", "runs", "loaded", "planned", "accepted", "reached"))
    return [line["set"], *counts, f"{100 * line['reached'] / line['runs']:.0f} %", number(line["median_plan_s"], 2), number(line["median_run_s"], 1)]


def _by_task(rows: list[Row]) -> dict[str, list[Row]]:
    out: dict[str, list[Row]] = {}
    for row in rows:
        out.setdefault(row["task"], []).append(row)
    return out


def _task_table(rows: list[Row], entries: Mapping[str, Entry], pictures: frozenset[str]) -> list[str]:
    head = ["task", "success, as its makers test it", "planned", "plan [s]", "pushes", "accepted", "reached", "run [s]", "replans"]
    lines = []
    for name, group in _by_task(rows).items():
        numbers = {column: _median(row[column] for row in group) for column in ("pushes", "replans")}
        picture = f'<img src="{PICTURES}/{name}.webp" width="{PICTURE_WIDTH}" alt="" loading="lazy"><br>' if name in pictures else ""
        planned, reached = _share(group, _planned), _share(filter(_planned, group), lambda row: row["reached"])
        why = f"({FAILURES}#{name})"
        if not all(map(_planned, group)):
            planned = f"[{planned}]{why}"
        if any(_planned(row) and not row["reached"] for row in group):
            reached = f"[{reached}]{why}"
        lines.append(
            [f"{picture}`{name}`", entries[name].test, planned, number(_median(row["plan_s"] for row in group if _planned(row)), 2), number(numbers["pushes"], 0)]
            + [_share(filter(_planned, group), lambda row: row["accepted"]), reached]
            + [number(_median(row["simulated_s"] for row in group if row["reached"]), 1), number(numbers["replans"], 0)]
        )
    return table(head, lines)


def _differences(rows: list[Row], entries: Mapping[str, Entry]) -> list[str]:
    by_difference: dict[str, list[str]] = {}
    for name in _by_task(rows):
        if entries[name].differs:
            by_difference.setdefault(entries[name].differs, []).append(f"`{name}`")
    if not by_difference:
        return []
    return ["What differs from the makers' tasks:", "", *(f"* {', '.join(names)}: {_sentences(words)}" for words, names in by_difference.items()), ""]
