"""Plans and scenes of files with the looks of their bodies, where the Python module `stiction` is there to read the scene."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from .looks import NOTHING, Looks, read_looks
from .plan import Plan

if TYPE_CHECKING:
    import stiction as st


def of_plan(drawn: Plan, plan: st.Plan) -> tuple[Plan, Looks]:
    """What is drawn of a plan, with links that nothing can touch where files show something, and the looks of all bodies."""
    from .studio.picture import Pictures

    pictures = Pictures(plan.task.model)
    looks = pictures.looks()
    return (pictures.with_bare_links(drawn, plan.q[-len(drawn.poses) :]) if looks else drawn), looks


def of_file(file: Path, drawn: Plan, bare: bool = True) -> tuple[Plan, Looks]:
    """Of a plan that was read from a file. Without the module, or where the scene cannot be read any more, what touches is drawn.
    Without `bare`, links that nothing can touch are left out: their poses are not known."""
    try:
        import stiction as st
    except ImportError:
        return drawn, NOTHING
    try:
        dressed, looks = of_plan(drawn, st.read_plan(file))
    except st.InvalidInput:
        return drawn, NOTHING
    if bare:
        return dressed, looks
    names = {body.name for body in drawn.bodies}
    return drawn, Looks({name: patches for name, patches in looks.patches.items() if name in names}, looks.notes)


def of_scene(file: str | None) -> Looks:
    """Of the bodies of a scene. Without the module or a file, or where the scene cannot be read any more, there are none."""
    if file is None:
        return NOTHING
    try:
        import stiction as st
    except ImportError:
        return NOTHING
    try:
        return read_looks(st.load_model(file))
    except st.InvalidInput:
        return NOTHING
