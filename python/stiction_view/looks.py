"""How bodies look in their files: colours and meshes in place of what touches, made few enough for a page."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from . import meshes, surfaces
from .bodies import Color

if TYPE_CHECKING:
    import stiction as st

MOST_TRIANGLES = 60_000  # of a scene: less than 1 MB of a page
FEWEST = 200  # of a mesh, however many there are


@dataclass(frozen=True)
class Patch:
    """A part of a body in one colour, in the frame of the body."""

    vertices: np.ndarray
    triangles: np.ndarray
    color: Color
    opacity: float | None  # None: opaque


@dataclass(frozen=True)
class Looks:
    """Patches by the name of the body; bodies that no file shows are not there."""

    patches: dict[str, list[Patch]] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    def __bool__(self) -> bool:
        return bool(self.patches)

    def rows(self) -> list[tuple[str, str]]:
        """What a page says of meshes that could not be read."""
        return [("not shown", f"{len(self.notes)} meshes: {self.notes[0]}")] if self.notes else []

    def mesh(self, name: str) -> meshes.Mesh:
        """All patches of a body as one mesh, in one colour."""
        parts = self.patches[name]
        return meshes.join([(p.vertices, p.triangles, np.zeros(len(p.triangles), dtype=int)) for p in parts])


NOTHING = Looks()


def _surface_of(visual: st.Visual, welded: list[surfaces.Surface]) -> surfaces.Surface | None:
    if visual.mesh is not None:
        return welded[visual.mesh]
    mesh = meshes.of_shape(visual.shape or {})
    return None if mesh is None else (mesh[0], mesh[1])


def read_looks(model: st.Model) -> Looks:
    """Of all bodies of a model. Surfaces of a scene that has too many triangles are made coarser, the largest first."""
    import stiction as st

    seen = st.read_visuals(model)
    welded = [surfaces.weld(mesh) for mesh in seen.meshes]
    given = [(visual, surface) for visual in seen.visuals if (surface := _surface_of(visual, welded)) is not None and len(surface[1])]
    each = max(FEWEST, surfaces.share_out([len(surface[1]) for _, surface in given], MOST_TRIANGLES))
    ready = {id(surface): surfaces.simplify(surface, each) for _, surface in given}
    smooth = {i: surfaces.split_creases(ready[id(mesh)]) for i, mesh in enumerate(welded) if id(mesh) in ready}

    found: dict[tuple[str, tuple[float, ...]], list[surfaces.Surface]] = {}
    names = [body.name for body in model.bodies]
    for visual, surface in given:
        points, triangles = ready[id(surface)] if visual.mesh is None else smooth[visual.mesh]
        color = tuple(np.round(np.asarray(visual.color), 3))
        found.setdefault((names[visual.body], color), []).append((points @ visual.X_BV.R.T + visual.X_BV.p, triangles))

    patches: dict[str, list[Patch]] = {}
    for (name, color), parts in found.items():
        vertices, triangles, _ = meshes.join([(v, t, np.zeros(len(t), dtype=int)) for v, t in parts])
        r, g, b = (int(round(255 * x)) for x in color[:3])
        patches.setdefault(name, []).append(Patch(vertices.astype(np.float32), triangles.astype(np.uint32), (r, g, b), None if color[3] >= 1 else float(color[3])))
    return Looks(patches, list(seen.notes))
