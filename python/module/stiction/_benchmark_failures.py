"""Why tasks of `stiction benchmark` failed: causes in plain words, and a page that says of each where it was refused, or how its run went."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from ._benchmark_story import REFUSALS
from ._benchmark_tasks import SETS, Entry

Row = Mapping[str, Any]
MOST_CAUSES = 3
PAGE = "benchmark_failures.md"
PICTURES = "benchmark_pictures"
LEAST = 1e-6  # [m or rad] less than this is no distance
MOST_EVENTS = 24  # of a run that are listed
REFUSED = {"no_posture": "no posture in contact", "no_path": "no path to it", "object_moved": "the object moved", "failed_step": "a step failed"}
BECAUSE = {
    "no_posture": "the robot had no posture in contact",
    "no_path": "no free path led to the new contacts",
    "object_moved": "the object moved while hands let go or took hold",
    "failed_step": "a step of the dynamics was not solved",
}
ENDS = {
    "Dropped": "an object fell during the run",
    "NoPlan": "the run left its plan, and no new plan was found from there",
    "Replans": "the run used up its number of new plans",
    "TimeUp": "the run did not reach the goal in time",
    "Deadline": "the run used up its wall time",
}


def cause_of(row: Row) -> str:
    """Why a task was not reached, in plain words that rows of one cause share; empty: it was."""
    if row["status"] == "Reached":
        return ""
    if row["status"] in ("Died", "Failed", "Stopped"):
        return {"Died": "the process died", "Failed": "the program failed", "Stopped": "the process did not end and was stopped"}[row["status"]]
    if row["stage"] == "load":
        return "the scene could not be loaded"
    if row["stage"] == "plan":
        return _of_search(row)
    return ENDS.get(row["end"], "the run ended")


def _of_search(row: Row) -> str:
    if not row["iterations"]:
        settled = "settled" in (row["message"] or "") or "rest" in (row["message"] or "")
        return "the search did not begin, because the objects do not rest at the start" if settled else "the search did not begin"
    counts = {name: row[name] or 0 for name in REFUSALS}
    worst = max(counts, key=lambda name: counts[name])
    return f"the search ran out of time; most refused contacts: {BECAUSE[worst]}" if counts[worst] else "the search ran out of time"


def causes_by_set(rows: Iterable[Row], set_of: Mapping[str, str]) -> dict[str, list[tuple[str, int]]]:
    """The most frequent causes of each set, and of all."""
    rows = list(rows)
    groups = {name: [row for row in rows if name in (set_of.get(row["task"]), "all")] for name in (*SETS, "all")}
    return {name: Counter(filter(None, map(cause_of, group))).most_common(MOST_CAUSES) for name, group in groups.items() if group}


# ---- words and numbers


def plain(text: str) -> str:
    """In one line, without the folders of this machine."""
    return re.sub(r"(/[\w.+-]+){2,}/", "…/", " ".join(text.split()))


def said(message: str | None) -> str:
    """A message of the program as code."""
    return f"`{plain(message or 'nothing').replace('`', chr(39)).rstrip('.?')}`"


def length(metres: float) -> str:
    return f"{1000 * metres:.3g} mm" if metres < 1 else f"{metres:.3g} m"


def distance(position: float | None, angle: float | None, like: Sequence[float] | None = None) -> str:
    """Of an object from its goal. like: a distance of the same goal, which tells whether position or angle count for it at all."""
    if position is None or angle is None:
        return "unknown"
    counts = [like[0] > LEAST, like[1] > LEAST] if like else [position > LEAST, angle > LEAST]
    if not any(counts):
        counts = [True, False]
    return " and ".join([length(position)] * counts[0] + [f"{angle:.2g} rad"] * counts[1])


def count(number_of: int, one: str, more: str) -> str:
    return f"{number_of} {one if number_of == 1 else more}"


def number(value: float | None, digits: int = 1) -> str:
    return "" if value is None else f"{value:.{digits}f}"


def cells(values: Iterable[str]) -> str:
    return "| " + " | ".join(value.replace("|", "\\|").replace("\n", " ") for value in values) + " |"


def table(head: list[str], lines: Iterable[Iterable[str]]) -> list[str]:
    return [cells(head), cells("---" for _ in head), *map(cells, lines), ""]


# ---- searches


def tell_search(row: Row, settings: Mapping[str, float]) -> list[str]:
    if not row["iterations"]:
        return [f"The planner said {said(row['message'])}.", ""]
    lines = [f"The search used up its {settings['plan_budget_s']:g} s of processor time with {row['nodes']} nodes. It tried {row['tried']} moves to new contacts."]
    if row["message"]:
        lines.append(f"The planner said {said(row['message'])}.")
    story = row.get("search") or {"bands": []}
    if "best" in story:
        position, angle = story["tolerance"]
        lines.append(f"The start is {distance(*story['start'])} from the goal, and the best node came to {distance(*story['best'])}. The tolerance is {distance(position, angle, story['start'])}.")
    if most := story.get("most"):
        lines.append(f"Most refused moves began {_band(story, most['band'])} from the goal. The middle of those places: {_places(most['objects'])}.")
    return [*lines, "", *_bands(row, story)]


def _range(story: Mapping[str, Any], band: int) -> tuple[float, float]:
    high = story["bands"][band][0]
    return (0 if high == 1 else high / 2), high


def _band(story: Mapping[str, Any], band: int) -> str:
    low, high = _range(story, band)
    return f"within {high} tolerances" if low == 0 else f"{low:g} to {high:g} tolerances"


def _bands(row: Row, story: Mapping[str, Any]) -> list[str]:
    """Nodes and refused moves by distance from the goal, in tolerances and in units, and of the whole search."""
    lines = []
    for k, (high, nodes, _, *refused) in enumerate(story["bands"]):
        position, angle = story["tolerance"]
        low, _ = _range(story, k)
        lines.append([f"{low:g} to {high:g}", distance(high * position, high * angle, story["start"]), str(nodes), *map(str, refused)])
    lines.append(["all", "", str(row["nodes"]), *(str(row[name]) for name in REFUSALS)])
    return table(["tolerances from the goal", "that is up to", "nodes", *(f"refused: {REFUSED[name]}" for name in REFUSALS)], lines)


def _places(objects: Mapping[str, list[float]]) -> str:
    return ", ".join(f"`{name}` at {_place(place)}" for name, place in objects.items())


def _place(place: list[float]) -> str:
    return f"{place[0]:.3g}" if len(place) == 1 else f"({', '.join(f'{value:.3g}' for value in place)})"


# ---- runs


def tell_run(row: Row) -> list[str]:
    planned = f"The first plan took {number(row['plan_s'], 2)} s of processor time."
    if row["accepted"] is False:
        planned += f" The check refused it: {said(row['refused'])}."
    at = distance(row["goal_error_position"], row["goal_error_angle"])
    lines = [f"{planned} The run ended after {number(row['simulated_s'])} s by the clock of the plant. The object was then {at} from its goal."]
    if row["message"]:
        lines.append(f"The program said {said(row['message'])}.")
    story = row.get("timeline")
    return [*lines, "", *(_events(story) if story else [])]


def _events(story: Mapping[str, Any]) -> list[str]:
    """Plans and what was carried out of them, in the order of time, with the distance from the goal at the end of each."""
    events = []
    for when, waited, status, cause, reason in story["plans"]:
        found = f"no plan: {plain(reason)}" if reason else "found" if status == "Solved" else "no plan"
        events.append((when, when + (waited or 0), f"plans, since {cause}" if cause != "start" else "plans", found))
    for begin, end, pushes, moves, off, given_up in story["pieces"]:
        how = ("given up" if given_up else "carried out") + ("" if off is None else f", {number(off)} tolerances off its path")
        events.append((begin, end, f"{count(pushes, 'push', 'pushes')}, {count(moves, 'move', 'moves')} to new contacts", how))
    events.sort(key=lambda event: (event[0], event[1]))
    shown = events if len(events) <= MOST_EVENTS else events[: MOST_EVENTS // 2] + events[-MOST_EVENTS // 2 :]
    lines = [[number(begin), number(end), what, how, distance(*_at(story["distance"], end))] for begin, end, what, how in shown]
    left = len(events) - len(shown)
    return [*([f"The table leaves out {left} events in the middle.", ""] if left else []), *table(["from [s]", "to [s]", "what", "how it ended", "then from the goal"], lines)]


def _at(samples: list[list[float]], when: float) -> tuple[float | None, float | None]:
    """The sample that is nearest in time."""
    if not samples:
        return None, None
    _, position, angle = min(samples, key=lambda sample: abs((sample[0] or 0) - when))
    return position, angle


# ---- a chart


WIDTH, HEIGHT, LEFT, BOTTOM = 480, 150, 44, 22  # [px]


def chart(row: Row) -> str | None:
    """The distance from the goal over a run in tolerances, on a logarithmic axis, with lines where plans were asked for; as SVG."""
    story = row.get("timeline")
    if not story:
        return None
    position_is, angle_is = story["tolerance"]
    samples = [(when, max(position / position_is, angle / angle_is)) for when, position, angle in story["distance"] if None not in (when, position, angle)]
    if len(samples) < 2:
        return None
    last = max(samples[-1][0], 1e-9)
    low, high = 0.3, max(10.0, *(value for _, value in samples))

    def x(when: float) -> float:
        return LEFT + (WIDTH - LEFT - 8) * min(when / last, 1)

    def y(value: float) -> float:
        share = math.log(max(value, low) / low) / math.log(high / low)
        return 6 + (HEIGHT - BOTTOM - 6) * (1 - share)

    line = " ".join(f"{x(when):.1f},{y(value):.1f}" for when, value in samples)
    plans = "".join(f'<path d="M{x(when):.1f} 6V{HEIGHT - BOTTOM}" stroke="#4678d6" stroke-opacity=".45"/>' for when, *_ in story["plans"] if when is not None)
    marks = "".join(f'<text x="{LEFT - 4}" y="{y(v) + 3:.1f}" text-anchor="end">{v:g}</text>' for v in (1, 10, 100, 1000) if low <= v <= high)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" font-size="10" fill="#555">'
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#fff"/>{plans}'
        f'<path d="M{LEFT} {y(1):.1f}H{WIDTH - 8}" stroke="#26a05c" stroke-dasharray="4 3"/>'
        f'<polyline points="{line}" fill="none" stroke="#ce184a" stroke-width="1.5"/>{marks}'
        f'<text x="{LEFT}" y="{HEIGHT - 6}">0</text><text x="{WIDTH - 8}" y="{HEIGHT - 6}" text-anchor="end">{last:.0f} s</text>'
        f'<text x="{(WIDTH + LEFT) / 2}" y="{HEIGHT - 6}" text-anchor="middle">tolerances from the goal; blue: plans, green: the goal</text></svg>\n'
    )


# ---- the page


def write_failures(rows: Iterable[Row], settings: Mapping[str, float], entries: Mapping[str, Entry], pictures: Iterable[str] = (), charts: Iterable[str] = ()) -> str:
    """The page, in Markdown. pictures: names of tasks that have one; charts: `TASK.SEED` of those that have one."""
    rows, pictures, charts = list(rows), set(pictures), set(charts)
    lines = [
        "# Benchmark: failures",
        "",
        "This page lists every task of the [benchmark](benchmark.md) that was not planned or not reached. `stiction benchmark` writes it beside the other page.",
        "",
        "## Most frequent causes",
        "",
    ]
    set_of = {name: entry.set for name, entry in entries.items()}
    lines += table(["set", "times", "cause"], ([name, str(count), cause] for name, causes in causes_by_set(rows, set_of).items() for cause, count in causes))
    lines += [
        "A move to new contacts is refused for one of four causes. The robot finds no posture that touches the object, or no free path leads there. "
        "The object moves by more than it may while hands let go or take hold, or the dynamics have no solution. "
        "A node is a state that the search reached. Distances count in tolerances of the goal: the larger of position and angle, each divided by its tolerance.",
        "",
    ]
    failed: dict[str, list[Row]] = {}
    for row in rows:
        if row["status"] != "Reached":
            failed.setdefault(row["task"], []).append(row)
    for name, group in failed.items():
        lines += [f"## {name}", ""]
        if name in pictures:
            lines += [f'<img src="{PICTURES}/{name}.webp" width="240" height="180" alt="start and goal of {name}" loading="lazy">', ""]
        if name in entries:
            lines += [f"Success: {entries[name].test}.", ""]
        for row in group:
            lines += _section(row, settings, f"{name}.{row['seed']}" in charts)
    return "\n".join(lines)


def _section(row: Row, settings: Mapping[str, float], has_chart: bool) -> list[str]:
    lines = [f"Seed {row['seed']}: {cause_of(row)}.", ""]
    if row["status"] in ("Died", "Failed", "Stopped") or row["stage"] == "load":
        return [*lines, f"The program said {said(row['message'])}.", ""]
    if row["stage"] == "plan":
        return [*lines, *tell_search(row, settings)]
    if has_chart:
        lines += [f'<img src="{PICTURES}/{row["task"]}.{row["seed"]}.svg" width="{WIDTH}" height="{HEIGHT}" alt="distance from the goal over time" loading="lazy">', ""]
    return [*lines, *tell_run(row)]
