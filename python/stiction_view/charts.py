"""Charts in the panel of a recorded page: efforts and forces on fragile things over the time of its bar."""

from __future__ import annotations

import html
import json
from importlib.resources import files
from typing import Any

import numpy as np

from .loads import Loads

NAMED = 4  # joints without a limit that are named one by one


def peaks(values: np.ndarray, frames: np.ndarray) -> np.ndarray:
    """(knots, lines) → (frames, lines): the largest since the frame before, so that none is passed over where frames are fewer than knots."""
    return np.maximum.reduceat(values[: frames[-1] + 1], np.append(frames[0], frames[:-1] + 1), axis=0)


def charts(loads: Loads, frames: np.ndarray) -> list[dict[str, Any]]:
    """Title, unit, names and values (lines, frames); the names of `stiction check` and of the studio."""
    limited = loads.limited()
    found = []
    if limited.any():
        names = [name for name, has in zip(loads.joints, limited) if has]
        found.append(("effort used", names, loads.effort_shares()[:, limited]))
    if loads.fragile:
        found.append(("max_force used", loads.fragile, loads.press_shares()))
    return [
        {"title": title, "unit": "%", "names": names, "values": np.round(100 * peaks(shares, frames), 2).T.tolist()} for title, names, shares in found
    ]


def summary(loads: Loads, place: list[str]) -> list[tuple[str, str]]:
    """The largest of each. place: where a knot is, in words."""
    rows = []
    if loads.limited().any():
        knot = int(loads.effort_share().argmax())
        rows.append(("effort used", f"at most {loads.effort_words(knot)}, {place[knot]}"))
        if free := loads.unlimited_joints():
            more = f" and {len(free) - NAMED} more" if len(free) > NAMED else ""
            rows.append(("no effort limit", ", ".join(free[:NAMED]) + more))
    elif loads.joints:
        rows.append(("effort used", loads.effort_words(0)))
    if loads.fragile:
        knot = int(loads.press_share().argmax())
        rows.append(("max_force used", f"at most {loads.press_words(knot)}" + (f", {place[knot]}" if any(loads.presser[knot]) else "")))
    return rows


STYLE = """<style>
#stiction .chart { width: 410px; max-width: 100%; margin-top: 6px; }
#stiction .chart .head { display: flex; justify-content: space-between; gap: 12px; white-space: nowrap; }
#stiction .chart .head span:first-child { color: #767c88; }
#stiction .chart .largest { color: #2a6fd6; overflow: hidden; text-overflow: ellipsis; flex: 1; }
#stiction .chart .head, #stiction .chart .plot { position: relative; margin-right: 42px; }
#stiction .chart .plot span { position: absolute; left: calc(100% + 6px); transform: translateY(-50%); font-size: 11px; white-space: nowrap; }
#stiction .chart svg { display: block; width: 100%; height: 64px; overflow: visible; }
@media (max-height: 700px) { #stiction .chart svg { height: 40px; } }
</style>"""


def as_html(found: list[dict[str, Any]], times: np.ndarray) -> tuple[str, str]:
    """Style and what stands in the panel. times: of the frames, and the end of the show."""
    if not found:
        return "", ""
    data = {"times": np.round(times[:-1], 4).tolist(), "end": round(float(times[-1]), 4), "charts": found}
    text = json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")
    heads = "".join(f'<div class="chart"><div class="head"><span>{html.escape(c["title"])} [{c["unit"]}]</span><span class="largest"></span><span class="now"></span></div><div class="plot"></div></div>' for c in found)
    script = files(__package__).joinpath("charts.js").read_text(encoding="utf-8")
    return STYLE, f'{heads}<script type="application/json" id="loads">{text}</script><script>\n{script}</script>'
