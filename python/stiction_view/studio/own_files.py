"""A robot and an object of somebody's own: files are dropped, and become a task."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from stiction.sdf import check_drake

from .own_scene import SHAPES, ObjectSpec, make_spec
from .panel import NOTHING, HeadControls, OwnControls, set_choices
from .problem import Problem, converted
from .texts import plain
from .uploads import Uploads, is_sdf


class OwnFiles:
    """`folder` is temporary and holds them; `take` poses a task."""

    def __init__(self, head: HeadControls, controls: OwnControls, folder: Path, take: Callable[[Problem], None]):
        self._head, self._controls, self._take = head, controls, take
        self._uploads = Uploads(folder)
        self.choose_kind()

    def upload(self, name: str, content: bytes) -> None:
        """Raises Refused; MissingExtra: an SDF, and nothing that reads it."""
        if is_sdf(name):
            check_drake(name)
        self._uploads.add(name, content)
        self._head.say(plain(f"{name}: taken"))
        self._list(name)

    def _list(self, newest: str) -> None:
        controls, uploads = self._controls, self._uploads
        robots = uploads.robots()
        lines = []
        for name in uploads.contents:
            missing = uploads.missing(name) if name in robots else []
            lines.append("- " + plain(name + (f", waits for {', '.join(missing)}" if missing else "")))
        controls.uploaded.content = "\n".join(lines) or "No files yet."
        chosen = newest if newest in robots else controls.robot.value
        set_choices(controls.robot, robots or [NOTHING], chosen if chosen in robots else (robots or [NOTHING])[0])
        kinds = [*SHAPES, *uploads.meshes()]
        set_choices(controls.kind, kinds, controls.kind.value if controls.kind.value in kinds else kinds[0])

    def choose_kind(self) -> None:
        self._controls.show_sizes(self._controls.kind.value)

    def make(self) -> None:
        """Raises ValueError, stiction.InvalidInput."""
        controls = self._controls
        if controls.robot.value == NOTHING:
            raise ValueError("robot: nothing was dropped; add a URDF, an MJCF or an SDF first")
        robot, notes = self._uploads.write_robot(controls.robot.value), list[str]()
        if is_sdf(robot.name):
            robot, notes = converted(robot, self._uploads.folder)
        kind = controls.kind.value
        file = None if kind in SHAPES else self._uploads.write_mesh(kind)
        sizes = tuple(float(s.value) for s in controls.sizes)
        thing = ObjectSpec(kind if file is None else "mesh", sizes, file, float(controls.scale.value), float(controls.mass.value), float(controls.friction.value))
        spec = make_spec(robot, thing, floor=bool(controls.floor.value))
        self._take(Problem.of_dict(spec, self._uploads.folder, notes))
        self._head.say(plain(f"{robot.name} on a floor: pose it, then plan" if controls.floor.value else f"{robot.name}: pose it, then plan"))
