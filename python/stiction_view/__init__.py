"""Draws plans of stiction: one self-contained web page, or a live view in the browser."""

from typing import TYPE_CHECKING, Any

from .plan import InvalidPlan, Plan, load_plan

if TYPE_CHECKING:
    from .scene import make_page, serve

__all__ = ["InvalidPlan", "Plan", "load_plan", "make_page", "serve"]


def __getattr__(name: str) -> Any:
    """What draws, on demand: importing viser takes a moment, and a program takes signals before that."""
    if name not in ("make_page", "serve"):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from . import scene

    return getattr(scene, name)
