"""The page of `stiction benchmark`, in Markdown: what was planned and carried out, and what stopped the rest."""

from __future__ import annotations

import re
import statistics
from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Any

from ._benchmark_tasks import ENTRIES, SETS, Entry

Row = Mapping[str, Any]
REFUSED = {"no_posture": "no posture in contact", "no_path": "no path to it", "object_moved": "the object moved", "failed_step": "a step failed"}
MOST_CAUSES = 3


def cause_of(row: Row) -> str:
    """Why a task was not reached, in a few words that rows of one cause share; empty: it was."""
    if row["status"] == "Reached":
        return ""
    if row["status"] in ("Died", "Failed", "Stopped"):
        return f"{row['status'].lower()}: {_without_numbers(row['message'] or '')}"
    if row["stage"] == "load":
        return f"not loaded: {_without_numbers(row['message'] or '')}"
    if row["stage"] == "plan":
        return _of_search(row)
    return f"run: {_of_run(row)}"


def _of_search(row: Row) -> str:
    if row["iterations"] == 0 or row["iterations"] is None:
        return f"no search: {_without_numbers(row['message'] or 'the budget was used up')}"
    counts = {words: row[name] or 0 for name, words in REFUSED.items()}
    worst = max(counts, key=lambda words: counts[words])
    return f"budget of the search; new contacts are mostly refused since {worst}" if counts[worst] else "budget of the search; new contacts are not refused"


def _of_run(row: Row) -> str:
    ends = {
        "Dropped": "an object fell",
        "NoPlan": "no plan from where it got to",
        "Replans": "replans used up",
        "TimeUp": "not there in time",
        "Deadline": "wall time used up",
        "Cancelled": "processor time used up",
    }
    return ends.get(row["end"], row["end"] or "no end")


def _without_numbers(message: str) -> str:
    """The first part of a message, so that those of one cause are the same."""
    message = _plain(message)
    first = re.split(r"[;] ", message)[0] if len(message) > 80 else message
    return re.sub(r"'[^']*'", "'…'", re.sub(r"-?\d[\d.e+-]*", "N", first)).strip()[:100]


def detail_of(row: Row) -> str:
    """What stopped a row, with its numbers; empty: nothing did."""
    if row["status"] == "Reached":
        return ""
    if row["stage"] == "run":
        return f"{_of_run(row)}; {_cut(row['message'] or 'nothing was said')}."
    if row["stage"] != "plan" or not row["tried"]:
        return f"{cause_of(row).split(': ')[0]}: {_cut(row['message'] or 'nothing was said')}."
    refused = ", ".join(f"{words} {row[name]}" for name, words in REFUSED.items() if row[name])
    said = f" {_cut(row['message'])}" if row["message"] else ""
    return f"{row['nodes']} nodes; of {row['tried']} moves to new contacts: {refused or 'all accepted'}.{said}"


def _plain(text: str) -> str:
    """In one line, without the folders of this machine."""
    return re.sub(r"(/[\w.+-]+){2,}/", "…/", " ".join(text.split()))


def _cut(text: str, most: int = 160) -> str:
    text = _plain(text)
    return text if len(text) <= most else text[: most - 1] + "…"


def _sentences(text: str) -> str:
    """One for each part between semicolons."""
    first, *rest = text.split("; ")
    return ". ".join([first, *(part[:1].upper() + part[1:] for part in rest)]) + "."


def _number(value: float | None, digits: int = 2) -> str:
    return "" if value is None else f"{value:.{digits}f}"


def _share(rows: Iterable[Row], holds: Any) -> str:
    rows = list(rows)
    return f"{sum(bool(holds(row)) for row in rows)} of {len(rows)}" if rows else ""


def _planned(row: Row) -> bool:
    return row["stage"] in ("check", "run") and row["status"] in ("Reached", "NotReached")


def _median(values: Iterable[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return statistics.median(known) if known else None


def _cells(values: Iterable[str]) -> str:
    return "| " + " | ".join(value.replace("|", "\\|").replace("\n", " ") for value in values) + " |"


def _table(head: list[str], lines: Iterable[Iterable[str]]) -> list[str]:
    return [_cells(head), _cells("---" for _ in head), *map(_cells, lines), ""]


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
                | {"median_plan_s": _median(row["plan_s"] for row in group if _planned(row)), "causes": dict(causes.most_common(MOST_CAUSES))}
            )
    return out


def write_page(rows: Iterable[Row], packages: Mapping[str, str], settings: Mapping[str, float], missing: Iterable[Entry] = ()) -> str:
    entries = {entry.name: entry for entry in ENTRIES}
    order = {name: k for k, name in enumerate(entries)}
    rows = sorted(rows, key=lambda row: (order.get(row["task"], len(order)), row["seed"]))
    seeds = sorted({row["seed"] for row in rows})
    lines = [
        "# Benchmark: scenes of others",
        "",
        "`stiction benchmark` loads scenes as others publish them, and plans them to the goals of their makers. It checks each plan, and carries it out in MuJoCo while the clock goes on. "
        "Every task has the same settings, which are the defaults.",
        "",
        "```sh",
        "stiction benchmark push_t_planar planar_pushing -o out/benchmark",
        "```",
        "",
        "Without names it runs all tasks, and a set is a name as well (`joints`, `push`, `in hand`). `pip install 'stiction[benchmark]'` brings the packages of the scenes. "
        "`--scenes FOLDER` finds them where wheels are unpacked. The same command goes on where it was interrupted, and `--list` names the tasks. "
        "In the folder are the task files, `results.csv` and this page.",
        "",
        f"Each search has {settings['plan_budget_s']:g} s of processor time on one thread, each run {settings['run_budget_s']:g} s with its plans, and {settings['duration_s']:g} s by the clock of the plant. "
        f"Seeds: {', '.join(map(str, seeds))}. Packages: {', '.join(f'{name} {number}' for name, number in packages.items()) or 'none'}.",
        "",
        "## Sets",
        "",
    ]
    head = ["set", "tasks", "runs", "loaded", "planned", "plan accepted", "goal reached", "median plan [s]", "most frequent causes"]
    lines += _table(head, (_set_line(line) for line in summarise(rows)))
    for name in SETS:
        group = [row for row in rows if row["task"] in entries and entries[row["task"]].set == name]
        if group:
            lines += [f"## {name.capitalize()}", "", *_task_table(group, entries), *_failures(group), *_differences(group, entries)]
    if left := sorted({entry.name for entry in missing}):
        lines += ["## Not run", "", f"Packages are missing for {', '.join(left)}.", ""]
    return "\n".join(lines)


def _set_line(line: Mapping[str, Any]) -> list[str]:
    causes = "; ".join(f"{cause} ({count})" for cause, count in line["causes"].items())
    return [line["set"], *(str(line[name]) for name in ("tasks", "runs", "loaded", "planned", "accepted", "reached")), _number(line["median_plan_s"]), causes]


def _by_task(rows: list[Row]) -> dict[str, list[Row]]:
    out: dict[str, list[Row]] = {}
    for row in rows:
        out.setdefault(row["task"], []).append(row)
    return out


def _task_table(rows: list[Row], entries: Mapping[str, Entry]) -> list[str]:
    head = ["task", "success, as its makers test it", "planned", "plan [s]", "pushes", "accepted", "reached", "run [s]", "replans"]
    lines = []
    for name, group in _by_task(rows).items():
        numbers = {column: _median(row[column] for row in group) for column in ("pushes", "replans")}
        lines.append(
            [f"`{name}`", entries[name].test, _share(group, _planned), _number(_median(row["plan_s"] for row in group if _planned(row))), _number(numbers["pushes"], 0)]
            + [_share(filter(_planned, group), lambda row: row["accepted"]), _share(filter(_planned, group), lambda row: row["reached"])]
            + [_number(_median(row["simulated_s"] for row in group if row["reached"]), 1), _number(numbers["replans"], 0)]
        )
    return _table(head, lines)


def _failures(rows: list[Row]) -> list[str]:
    stopped = [row for row in rows if row["status"] != "Reached"]
    if not stopped:
        return []
    return ["What stopped the others:", "", *(f"* `{row['task']}`, seed {row['seed']}: {detail_of(row)}" for row in stopped), ""]


def _differences(rows: list[Row], entries: Mapping[str, Entry]) -> list[str]:
    by_difference: dict[str, list[str]] = {}
    for name in _by_task(rows):
        if entries[name].differs:
            by_difference.setdefault(entries[name].differs, []).append(f"`{name}`")
    if not by_difference:
        return []
    return ["What differs from the makers' tasks:", "", *(f"* {', '.join(names)}: {_sentences(words)}" for words, names in by_difference.items()), ""]
