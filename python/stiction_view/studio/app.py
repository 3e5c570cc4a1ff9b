"""The studio: what can be opened, and files that are dropped."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import stiction as st
import viser

from . import catalog, scenario
from .jobs import Job
from .limits import limit_uploads
from .own_scene import SHAPES, ObjectSpec, make_spec
from .panel import NOTHING
from .picture import Pictures
from .problem import Problem
from .showing import Showing
from .uploads import Uploads


class Studio(Showing):
    """`entries` can be picked; `folder` is temporary and holds uploads."""

    handlers = (*Showing.handlers, "pick", "upload", "kind", "make")

    opened = ""

    def __init__(self, server: viser.ViserServer, entries: Sequence[catalog.Entry], first: catalog.Entry | None, folder: Path):
        super().__init__(server, [e.label for e in entries], folder)
        self.entries = list(entries)
        self.uploads = Uploads(folder)
        self.panel.show_sizes(self.panel.kind.value)
        limit_uploads(server, lambda text: self.events.put(lambda: self.panel.say(text, fault=True)))
        if first is not None:
            self.panel.pick.value = first.label
            self.guarded(lambda: self.open(first))

    # ---- opening ----

    def on_pick(self) -> None:
        if self.panel.pick.value != self.opened:
            self.open(next(e for e in self.entries if e.label == self.panel.pick.value))

    def open(self, entry: catalog.Entry) -> None:
        self.opened = entry.label
        self.panel.say("")
        self.drop()
        if entry.kind == catalog.TASK:
            return self.take(Problem.open(entry.source))
        play = scenario.play_sense if entry.kind == catalog.SENSE else scenario.play_control
        self.when_free(lambda: self.start(Job(f"{entry.kind} of {entry.label}", lambda _: play(entry.source), self.played_done)))

    def take(self, problem: Problem) -> None:
        """A task to pose and to plan."""
        self.drop()
        self.problem, self.pictures, self.played = problem, Pictures(problem.model), None
        panel, model = self.panel, problem.model
        panel.about.content = problem.given.description + "".join(f"  \n*{note}*" for note in model.notes)
        panel.seed.value = problem.seed
        self.fill_pose()
        units = ["m" if model.dofs[model.n_vu + j].kind == st.DofKind.Prismatic else "rad" for j in range(model.n_a)]
        ranges = [problem.joint_range(j) for j in range(model.n_a)]
        panel.fill_joints(model.joint_names, ranges, problem.start[model.n_qu :], units)
        self.fill_options()
        panel.set_choices(panel.handle, [NOTHING, *self.handles()], "goal" if "goal" in self.handles() else NOTHING)
        self.list_results()
        self.to_pose(aim=True)

    # ---- own files ----

    def on_upload(self, name: str, content: bytes) -> None:
        self.uploads.add(name, content)
        self.panel.say(f"{name}: taken")
        self.list_uploads(name)

    def list_uploads(self, newest: str) -> None:
        panel, uploads = self.panel, self.uploads
        robots = uploads.robots()
        lines = []
        for name in uploads.contents:
            missing = uploads.missing(name) if name in robots else []
            lines.append(f"- {name}" + (f", waits for {', '.join(missing)}" if missing else ""))
        panel.uploaded.content = "\n".join(lines) or "No files yet."
        panel.set_choices(panel.robot, robots or [NOTHING], newest if newest in robots else panel.robot.value if panel.robot.value in robots else (robots or [NOTHING])[0])
        kinds = [*SHAPES, *uploads.meshes()]
        panel.set_choices(panel.kind, kinds, panel.kind.value if panel.kind.value in kinds else kinds[0])

    def on_kind(self) -> None:
        self.panel.show_sizes(self.panel.kind.value)

    def on_make(self) -> None:
        panel = self.panel
        if panel.robot.value == NOTHING:
            raise ValueError("robot: nothing was dropped; add a URDF or an MJCF first")
        robot = self.uploads.write_robot(panel.robot.value)
        kind = panel.kind.value
        file = None if kind in SHAPES else self.uploads.write_mesh(kind)
        sizes = tuple(float(s.value) for s in panel.sizes)
        thing = ObjectSpec(kind if file is None else "mesh", sizes, file, float(panel.scale.value), float(panel.mass.value), float(panel.friction.value))
        spec = make_spec(robot, thing, floor=bool(panel.floor.value))
        self.take(Problem.of_dict(spec, self.uploads.folder))
        panel.say(f"{robot.name} on a floor: pose it, then plan" if panel.floor.value else f"{robot.name}: pose it, then plan")
