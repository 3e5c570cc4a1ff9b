"""A simulated run of a plan drawn over the plan: the scene moves as simulated, planned objects are blue ghosts."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import viser

from . import scene
from .bodies import OBJECT, OBJECT_AXES, Color, body_meshes, slug
from .drawing import Drawing, add_ghost
from .frames import HOLD_END, HOLD_START
from .loads import Loads
from .looks import NOTHING, Looks
from .plan import Contact, Plan, load_plan, read_document

FORMAT = "stiction-simulation"
FORMAT_VERSION = 2
PLANNED: Color = (70, 122, 214)
MAX_SECONDS = 45.0  # of the show; longer runs are played faster


@dataclass(frozen=True)
class Simulation:
    """`plan` with the simulated motion in place of the planned one."""

    plan: Plan
    planned: np.ndarray  # (frames, moving bodies, 7)
    times: np.ndarray  # (frames) simulated seconds
    report: dict[str, Any]


def load_simulation(plan_file: Path, file: Path) -> Simulation:
    """Reads what `stiction simulate` wrote beside its plan. Raises InvalidPlan."""
    plan = load_plan(plan_file)
    return read_document(file, FORMAT, FORMAT_VERSION, lambda data: _read(plan, data))


def _read(plan: Plan, data: dict[str, Any]) -> Simulation:
    frames, report = data["frames"], data["report"]
    if not frames:
        raise ValueError("frames: none, nothing to draw")
    moving = plan.poses.shape[1]
    poses = np.array([frame["bodies"] for frame in frames], dtype=float)
    planned = np.array([frame["planned"] for frame in frames], dtype=float)
    for name, array in (("bodies", poses), ("planned", planned)):
        if array.shape != (len(frames), moving, 7) or not np.isfinite(array).all():
            raise ValueError(f"frames: {name} of shape {array.shape}, expected ({len(frames)}, {moving}, 7) finite numbers")
    is_object = [plan.bodies[g.body].kind == "object" for g in plan.geometries]
    contacts = [
        [
            Contact(np.array(f["point"], dtype=float), np.array(f["force"], dtype=float), is_object[f["a"]] or is_object[f["b"]])
            for f in frame["forces"]
        ]
        for frame in frames
    ]
    kinds = [piece["kind"] for piece in report["pieces"]] or ["contact"]
    piece = np.clip([frame["piece"] for frame in frames], 0, len(kinds) - 1)
    simulated = dataclasses.replace(
        plan,
        status=str(report["status"]),
        error_position=float(report["error"]["position"]),
        error_angle=float(report["error"]["angle"]),
        poses=poses,
        contacts=contacts,
        segment=np.asarray(piece),
        segment_kinds=kinds,
        tree_parents=np.empty(0, dtype=int),
        loads=_loads(plan, frames),
    )
    return Simulation(simulated, planned, np.array([frame["t"] for frame in frames], dtype=float), report)


def _loads(plan: Plan, frames: list[dict[str, Any]]) -> Loads | None:
    """What the run asks of motors and of fragile things; limits are those of the plan's scene."""
    if plan.loads is None:
        return None
    torque = np.array([frame["torque"] for frame in frames], dtype=float)
    if torque.shape != (len(frames), len(plan.loads.joints)) or not np.isfinite(torque).all():
        raise ValueError(f"frames: torque of shape {torque.shape}, expected ({len(frames)}, {len(plan.loads.joints)}) finite numbers")
    names = [geometry.name for geometry in plan.geometries]
    return plan.loads.of_run(torque, [[(f["a"], f["b"], float(f["normal"])) for f in frame["forces"]] for frame in frames], names)


class OverlayDrawing(Drawing):
    """The drawing of the simulated motion, and a ghost of every object where the plan has it."""

    def __init__(self, server: viser.ViserServer, simulation: Simulation, looks: Looks = NOTHING):
        self.simulation = simulation
        self.ghosts: list[tuple[int, viser.SceneNodeHandle]] = []
        super().__init__(server, simulation.plan, looks=looks, touches=not looks)
        seconds = simulation.times[self.frames]
        rate = max(1.0, (seconds[-1] - seconds[0]) / MAX_SECONDS)
        self.times = HOLD_START + (seconds - seconds[0]) / rate
        self.times[0] = 0.0
        self.times = np.append(self.times, self.times[-1] + HOLD_END)
        self.rate = rate
        for part in body_meshes(self.plan, {}):
            body = self.plan.bodies[part.body]
            if body.kind != "object" or body.moving is None:
                continue
            row = simulation.planned[0, body.moving]
            node = f"/planned/{slug(body.name)}"
            frame = server.scene.add_frame(node, show_axes=False, wxyz=row[3:], position=row[:3])
            add_ghost(server.scene, f"{node}/shape", part, grown=1.03, color=PLANNED, opacity=0.4)
            extent = float(np.abs(part.mesh[0]).max())
            server.scene.add_frame(f"{node}/axes", axes_length=OBJECT_AXES * extent, axes_radius=0.018 * extent, origin_radius=0.0)
            self.ghosts.append((body.moving, frame))

    def show(self, knot: int) -> None:
        super().show(knot)
        for column, frame in self.ghosts:
            row = self.simulation.planned[knot, column]
            frame.position = row[:3]
            frame.wxyz = row[3:]

    def summary(self) -> list[tuple[str, str]]:
        report = self.simulation.report
        pushes = [p for p in report["pieces"] if p["kind"] == "contact"]
        reached = [p["in_plan"] for p in pushes if p.get("in_plan")]
        rows = [
            (report.get("mode", "open loop"), {"Reached": "goal reached", "Missed": "goal missed"}.get(report["status"], report["status"])),
            ("seed", str(self.plan.seed)),
            ("at the end", f"{1e3 * self.plan.error_position:.1f} mm, {self.plan.error_angle:.3f} rad off"),
            ("pieces", f"{len(report['pieces'])}, of which {len(pushes)} push"),
            self.deviation(report, reached),
            ("penetration", f"{1e3 * report['max_penetration']:.2f} mm"),
            *self.loads_summary(),
        ]
        if report["dropped"]:
            rows.append(("dropped", f"{report['dropped']} after {report['dropped_s']:.1f} s: the run ends there"))
        if self.rate > 1:
            rows.append(("shown", f"{self.rate:.1f} times as fast"))
        return rows

    @staticmethod
    def deviation(report: dict[str, Any], reached: list[dict[str, float]]) -> tuple[str, str]:
        """Of a run in closed loop what it was planned anew for, else the mean error of the pushes."""
        if "replans" in report:
            return "planned anew", f"{report['replans']} times, {sum(p['given_up'] for p in report['pieces'])} pieces given up"
        if not reached:
            return "mean error", "–"
        return "mean error", f"{1e3 * np.mean([e['mean_position'] for e in reached]):.1f} mm, {np.mean([e['mean_angle'] for e in reached]):.3f} rad"

    def keys(self) -> list[tuple[Color, str]]:
        return [(OBJECT[0], "simulated"), (PLANNED, "planned"), *super().keys()[-2:]]


def make_page(simulation: Simulation, looks: Looks = NOTHING) -> str:
    """One self-contained page: the recorded run with a time bar."""
    return scene.record(lambda server, looks: OverlayDrawing(server, simulation, looks), looks)
