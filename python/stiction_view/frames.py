"""Which knots of a plan are shown, and when."""

from __future__ import annotations

import numpy as np

from .plan import Plan

FRAMES_PER_SECOND = 24.0  # one knot per frame: joints move at most 0.03 rad a knot, which is about human speed
MAX_FRAMES = 600
MAX_SECONDS = 50.0
HOLD_START, HOLD_END = 0.8, 1.5  # [s]


def choose_frames(plan: Plan) -> np.ndarray:
    """Knots to show: all of them, or an even choice that keeps the first and the last knot of every segment."""
    knots = len(plan.poses)
    if knots <= MAX_FRAMES:
        return np.arange(knots)
    ends = np.flatnonzero(np.diff(plan.segment)) if len(plan.segment_kinds) > 1 else np.array([], dtype=int)
    must = np.concatenate([[0], ends, ends + 1, [knots - 1]])
    even = np.linspace(0, knots - 1, max(2, MAX_FRAMES - len(must))).round().astype(int)
    return np.unique(np.concatenate([must, even]))


def frame_times(frames: np.ndarray) -> np.ndarray:
    """Seconds at which each frame appears, and the end of the show as one more entry."""
    knots = frames[-1] - frames[0]
    per_knot = min(1.0 / FRAMES_PER_SECOND, MAX_SECONDS / max(1, knots))
    times = HOLD_START + per_knot * (frames - frames[0])
    times[0] = 0.0
    return np.append(times, times[-1] + HOLD_END)
