"""What a search and a run leave behind of themselves in a row of `stiction benchmark`, so that a page can say where a task failed."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from ._core import Growth, PlanResult, RunResult, SegmentKind, Task

REFUSALS = ("no_posture", "no_path", "object_moved", "failed_step")  # of moves to new contacts, as PlanResult.regrasps counts them
SAMPLES = 40  # of the distance to the goal over a run
DIGITS = 4  # of numbers for the eye
FREE = 7  # coordinates in q of an object that moves freely


class Nodes:
    """Collects the nodes of all trees of a search; an instance is its on_growth."""

    def __init__(self) -> None:
        self._q: list[np.ndarray] = []

    def __call__(self, growth: Growth) -> None:
        self._q.append(growth.q)

    def q(self, n_q: int) -> np.ndarray:
        """(nodes, n_q)"""
        return np.concatenate(self._q) if self._q else np.empty((0, n_q))


def shares(task: Task, q: np.ndarray) -> np.ndarray:
    """How far configurations (N, n_q) are from the goal, in tolerances (N)."""
    if len(q) == 0:
        return np.empty(0)
    return (task.goal_errors(q) / [task.goal.tol_position, task.goal.tol_angle]).max(axis=1)


def rounded(values: Iterable[float]) -> list[float | None]:
    return [float(f"{value:.{DIGITS}g}") if math.isfinite(value) else None for value in values]


def tell_search(task: Task, found: PlanResult, nodes: np.ndarray) -> dict[str, Any]:
    """How near a search came, and from where its moves to new contacts were refused, by distance from the goal.

    bands: of nodes up to 1, 2, 4 … tolerances from the goal: that number, nodes, moves tried, and refused by each of REFUSALS.
    """
    out: dict[str, Any] = {
        "start": rounded(task.goal_errors(task.q_start[None])[0]),
        "best": rounded([found.plan.error.position, found.plan.error.angle]),
        "tolerance": [task.goal.tol_position, task.goal.tol_angle],
    }
    refused = found.refused
    at = np.array([entry.q for entry in refused]).reshape(len(refused), task.model.n_q)
    node_bands, refused_bands = band_of(shares(task, nodes)), band_of(shares(task, at))
    bands = []
    for band in sorted({*node_bands.tolist(), *refused_bands.tolist()}):
        counts = [refused[i].counts for i in np.flatnonzero(refused_bands == band)]
        bands.append([2**band, int((node_bands == band).sum()), *(sum(entry[name] for entry in counts) for name in ("tried", *REFUSALS))])
    out["bands"] = bands
    if refused:
        most = int(np.argmax([sum(line[3:]) for line in bands]))
        inside = np.flatnonzero(refused_bands == sorted({*node_bands.tolist(), *refused_bands.tolist()})[most])
        out["most"] = {"band": most, "objects": middle_of(task, at[inside])}
    return out


def band_of(distances: np.ndarray) -> np.ndarray:
    """Number of the band of each: 0 up to one tolerance, 1 up to two, 2 up to four …"""
    return np.ceil(np.log2(np.maximum(distances, 1.0)) - 1e-12).astype(int)


def middle_of(task: Task, q: np.ndarray) -> dict[str, list[float | None]]:
    """Median of where the objects of the goal are: the position of what moves freely, coordinates of what hangs on a joint."""
    out = {}
    for number in task.goal_objects:
        name = task.model.object_names[number]
        place = task.model.objects[number]
        free = place.n_q >= FREE
        places = task.model.object_poses(q, name)[:, :3] if free else q[:, place.q_begin : place.q_begin + place.n_q]
        out[name] = rounded(np.median(places, axis=0))
    return out


def tell_run(task: Task, ran: RunResult) -> dict[str, Any]:
    """Plans and what was carried out of them, by time, and the distance from the goal.

    plans: when each was asked for [s], how long the plant waited [s], status, why it was asked for, what the planner said where it found nothing.
    pieces: of each stretch between plans: begin [s], end [s], pushes, changes of contacts, tolerances off its path at the end, whether it was given up.
    distance: [s], [m], [rad] at some moments.
    """
    plans = [[*rounded([plan.time, plan.clock_s]), plan.status.name, plan.cause, plan.reason] for plan in ran.plans]
    q, times = np.asarray(ran.q), np.asarray(ran.times)
    chosen = np.unique(np.linspace(0, len(times) - 1, min(SAMPLES, len(times))).round().astype(int)) if len(times) else np.empty(0, dtype=int)
    errors = task.goal_errors(q[chosen]) if len(chosen) else np.empty((0, 2))
    tolerance = [task.goal.tol_position, task.goal.tol_angle]
    return {"tolerance": tolerance, "plans": plans, "pieces": stretches(ran), "distance": [rounded([times[i], *error]) for i, error in zip(chosen, errors)]}


def stretches(ran: RunResult) -> list[list[Any]]:
    """Pieces of a run, those of one plan together."""
    out: list[list[Any]] = []
    last = None
    for piece in ran.pieces:
        if piece.plan != last:
            out.append([piece.begin_s, piece.end_s, 0, 0, 0.0, False])
            last = piece.plan
        line = out[-1]
        line[1], line[4], line[5] = piece.end_s, piece.off, bool(piece.given_up)
        line[2 if piece.kind == SegmentKind.Contact else 3] += 1
    return [[*rounded(line[:2]), line[2], line[3], *rounded([line[4]]), line[5]] for line in out]
