"""What went wrong where a plan misses its goal in the simulation.

A run that misses is lost in one piece: the one after whose start the object was never again within the tolerances of its goal of where the plan has it. Causes:
    drop       an object fell; the run ends there
    regrasp    the object left while the robot moved to new contacts
    model      the push misses by more than half of the tolerances even when it is started from the planned state at rest
    amplified  the push started alone follows its plan: what earlier pieces left behind grew
    simulation the simulation refused to go on
    push       model or amplified: pushes were not run by themselves
    sum        no piece is the one: the errors of all pieces together
"""

from __future__ import annotations

import math
from typing import Any

from ._core import Goal, PieceError, SegmentKind, TransferResult


def share(error: PieceError | None, moment: str, goal: Goal) -> float:
    """Error at the start or the end of a piece, of the tolerances; of a piece that did not come, infinite."""
    if error is None:
        return math.inf
    return max(getattr(error, f"{moment}_position") / goal.tol_position, getattr(error, f"{moment}_angle") / goal.tol_angle)


def find_cause(ran: TransferResult, goal: Goal) -> tuple[str, int]:
    """Of a run that missed its goal, and the number of the piece."""
    pieces = ran.pieces
    if ran.dropped is not None:
        return "drop", next((i for i, piece in enumerate(pieces) if ran.dropped_s <= piece.end_s), len(pieces) - 1)
    if any(piece.in_plan is None for piece in pieces):
        return "simulation", sum(piece.in_plan is not None for piece in pieces)
    inside = [i for i, piece in enumerate(pieces) if share(piece.in_plan, "start", goal) <= 1]
    if not inside or all(share(piece.in_plan, "end", goal) <= 1 for piece in pieces):
        return "sum", len(pieces) - 1
    number = inside[-1]
    piece = pieces[number]
    if share(piece.in_plan, "end", goal) <= 1:
        return "sum", number  # between two pieces, or after the last one
    if piece.kind == SegmentKind.Regrasp:
        return "regrasp", number
    if piece.alone is None:
        return "push", number
    return ("model" if share(piece.alone, "end", goal) > 0.5 else "amplified"), number


SHORT = 0.25  # of the tolerances: a push that moves the object by less has no share of its length


def follow(ran: TransferResult, goal: Goal) -> dict[str, Any]:
    """By how much the worst regrasp moves the object from where the plan has it, and errors of pushes by themselves as shares of their length."""
    out: dict[str, Any] = {}
    regrasps = [piece.in_plan for piece in ran.pieces if piece.kind == SegmentKind.Regrasp and piece.in_plan]
    for what in ("position", "angle"):
        out[f"regrasp_growth_{what}"] = max((getattr(e, f"end_{what}") - getattr(e, f"start_{what}") for e in regrasps), default=None)
        short = SHORT * getattr(goal, f"tol_{what}")
        alone = [piece.alone for piece in ran.pieces if piece.alone and getattr(piece.alone, f"length_{what}") > short]
        out[f"normalised_{what}"] = [getattr(e, f"normalised_{what}") for e in alone] or None
    return out
