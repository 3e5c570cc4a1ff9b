"""Draws plans of stiction: one self-contained web page, or a live view in the browser."""

from .plan import InvalidPlan, Plan, load_plan
from .scene import make_page, serve

__all__ = ["InvalidPlan", "Plan", "load_plan", "make_page", "serve"]
