"""The scene of the studio: a task that is posed, or motions side by side."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
import stiction as st
import viser

from .. import links
from ..bodies import GOAL, Color
from ..camera import View, choose_view
from ..drawing import Drawing, find_parts, light
from ..frames import choose_frames
from ..plan import Plan
from .cameras import Cameras
from .faults import Fault
from .picture import Pictures, pose_of, seven
from .problem import Problem

FAULT: Color = (214, 40, 40)
POSE_ROOT, RUN_ROOT, SHOW_ROOTS = "/pose", "/run", ("/first", "/second")
HAND: Color = (150, 60, 200)


@dataclass(frozen=True)
class Grip:
    """What a handle moves: a link of a robot, or an object, at the goal or at the start."""

    index: int = -1  # of the object
    at_goal: bool = False
    link: str = ""
    turns: bool = True  # the link may be turned as well: its arm has joints enough

    def pose(self, problem: Problem) -> st.Pose:
        model = problem.model
        if self.link:
            return model.body_poses(problem.start)[self.link]
        return model.object_pose(problem.goal if self.at_goal else problem.start, model.object_names[self.index])


class Guest(Protocol):
    """What draws itself, with controls of its own, until something else is shown."""

    view: View
    drawing: Drawing

    def tick(self, now: float) -> None: ...
    def remove(self) -> None: ...


Pulled = Callable[[str, np.ndarray, np.ndarray, str], None]  # body, its point and the hand [m], and "start", "update" or "end"
APART = 1.15  # distance of two motions, of what is seen of one


@dataclass(frozen=True)
class Shown:
    """A motion, and what stands above it where there are two."""

    plan: Plan
    pictures: Pictures
    title: str
    with_goal: bool = True


def goal_of(problem: Problem, index: int | None = None) -> st.Pose:
    """Of an object; None: of the one that the goal is named after."""
    return problem.model.object_pose(problem.goal, problem.model.object_names[problem.goal_object if index is None else index])


def plan_of(problem: Problem, pictures: Pictures) -> Plan:
    """The start as a motion of one moment, with the goals."""
    plan = pictures.plan(problem.start, goal_of(problem), problem.goal_object, problem.given.name)
    others = [(body, pose_of(seven([goal_of(problem, index)])[0])) for index, body in bodies_of_goals(problem, pictures).items() if index != problem.goal_object]
    return replace(plan, more_goals=others)


def bodies_of_goals(problem: Problem, pictures: Pictures) -> dict[int, int]:
    """What is drawn of each object that the goal names."""
    found = {index: pictures.body_of(index) for index in problem.goal_objects}
    return {index: body for index, body in found.items() if body is not None}


def best_view(plan: Plan, pictures: Pictures) -> View:
    """As a drawing chooses it."""
    fixed, loose = pictures.rods()
    return choose_view(plan, find_parts(plan, fixed, pictures.looks()), choose_frames(plan), links.ends(loose))


class Stage:
    """Only one thread at a time may call it."""

    def __init__(self, server: viser.ViserServer):
        self.server = server
        self.posed: Drawing | None = None
        self.shown: list[Drawing] = []
        self.running: Drawing | None = None
        self.guest: Guest | None = None
        self._hand: viser.ArrowHandle | None = None  # the force of it
        self._marks: list[viser.SceneNodeHandle] = []
        self._titles: list[viser.SceneNodeHandle] = []
        self._gizmos: dict[Grip, tuple[viser.TransformControlsHandle, st.Pose]] = {}  # with X_BG
        self.cameras = Cameras(server)
        self.beside = -1  # motions side by side when the camera was aimed last; 0: a task that is posed
        self._views: dict[int, View] = {}  # of the scene that is shown: posed, and played
        self._pictures: Pictures | None = None  # of that scene
        self.seen = True  # bodies show as their files have them; else what touches
        light(server.scene, shadows=False)

    # ---- nodes ----

    def drawings(self) -> list[Drawing]:
        return [*([self.posed] if self.posed else []), *([self.running] if self.running else []), *self.shown]

    def show_as(self, seen: bool) -> None:
        """Bodies as their files show them, or as what touches; also those that are drawn later."""
        self.seen = seen
        for drawing in self.drawings():
            drawing.show_as(seen)
        if self.guest is not None:
            self.guest.drawing.show_as(seen)

    def clear(self) -> None:
        guest, self.guest = self.guest, None
        if guest is not None:
            guest.remove()
        for drawing in self.drawings():
            assert drawing.root_node is not None
            drawing.root_node.remove()  # and all below it
        self.posed, self.running, self._hand, self.shown, self._gizmos, self._marks, self._titles = None, None, None, [], {}, [], []

    def _turn_to(self, pictures: Pictures, anew: bool = False) -> None:
        """At another scene the camera is aimed anew."""
        if anew or pictures is not self._pictures:
            self.beside, self._views, self._pictures = -1, {}, pictures

    # ---- a task that is posed ----

    def pose(self, problem: Problem, pictures: Pictures, aim: bool, picked: Callable[[str], None]) -> None:
        """Draws the start and the goal of a task. A link that is clicked is `picked`, by another thread."""
        self.clear()
        plan = plan_of(problem, pictures)
        self._turn_to(pictures, aim)
        self.posed = Drawing(self.server, plan, root=POSE_ROOT, rods=pictures.rods(), with_goal=True, view=self._views.get(0), looks=pictures.looks())
        self.posed.show_as(self.seen)
        self._views[0] = self.posed.view
        self.posed.place(plan.poses[0])
        self.posed.label.visible = False
        for body in (b for b in plan.bodies if b.kind == "robot" and b.moving is not None):
            for mesh, _ in self.posed.painted.get(body.name, []):
                self._let_pick(mesh, body.name, picked)
        if self.beside not in (0, 1):
            self.cameras.aim(self.posed.view)
            self.beside = 0

    @staticmethod
    def _let_pick(mesh: viser.MeshHandle, body: str, picked: Callable[[str], None]) -> None:
        @mesh.on_click
        async def _(_: viser.SceneNodePointerEvent[viser.MeshHandle]) -> None:
            picked(body)

    def move_start(self, problem: Problem, pictures: Pictures) -> None:
        if self.posed is not None:
            self.posed.place(pictures.poses(problem.start)[0])

    def move_goal(self, problem: Problem, pictures: Pictures) -> None:
        if self.posed is None:
            return
        for index, body in bodies_of_goals(problem, pictures).items():
            row = seven([goal_of(problem, index)])[0]
            node = self.posed.goal_nodes[body]
            node.position, node.wxyz = row[:3], row[3:]

    def follow_goal(self, problem: Problem, pictures: Pictures) -> None:
        """Aims anew where the goal has left somebody's picture."""
        lost = self.cameras.lost(goal_of(problem).p)
        if self.posed is not None and lost:
            plan = plan_of(problem, pictures)
            self.cameras.aim(best_view(plan, pictures), lost)

    # ---- the handle that drags ----

    def hold(self, problem: Problem, grips: Sequence[Grip], moved: Callable[[Grip, st.Pose, bool], None]) -> None:
        """A gizmo for each grip. `moved(grip, pose, ended)` comes from another thread."""
        for gizmo, _ in self._gizmos.values():
            gizmo.remove()
        self._gizmos = {}
        if self.posed is None:
            return
        for number, grip in enumerate(grips):
            X_BG = self._gizmo_frame(problem, grip)
            shape = self._gizmo_shape(problem, grip)
            row = seven([grip.pose(problem) @ X_BG])[0]
            gizmo = self.server.scene.add_transform_controls(f"{POSE_ROOT}/handle{number or ''}", line_width=3.0, depth_test=False, opacity=0.85, position=row[:3], wxyz=row[3:], **shape)
            self._gizmos[grip] = (gizmo, X_BG)
            self._let_drag(gizmo, grip, X_BG, moved)

    @staticmethod
    def _let_drag(gizmo: viser.TransformControlsHandle, grip: Grip, X_BG: st.Pose, moved: Callable[[Grip, st.Pose, bool], None]) -> None:
        @gizmo.on_update
        async def _(event: viser.TransformControlsEvent) -> None:
            pose = pose_of(np.concatenate([event.target.position, event.target.wxyz]))
            moved(grip, st.Pose(pose.rotation(), pose.position) @ X_BG.inverse(), event.phase == "end")

    def _gizmo_frame(self, problem: Problem, grip: Grip) -> st.Pose:
        """X_BG of a gizmo whose z is the axis of a hinge or slide, with the middle of its quarter of a ring before the body; else the body's own frame."""
        model = problem.model
        if grip.link or model.objects[grip.index].n_v != 1:
            return st.Pose(np.eye(3), np.zeros(3))
        z, away = self._axis(problem, grip), self._away(problem, grip)
        if np.linalg.norm(away) < 1e-6:
            return st.Pose(links.along(z), np.zeros(3))
        ahead = away / np.linalg.norm(away)
        x = (ahead - np.cross(z, ahead)) / np.sqrt(2)
        return st.Pose(np.column_stack([x, np.cross(z, x), z]), np.zeros(3))

    @staticmethod
    def _axis(problem: Problem, grip: Grip) -> np.ndarray:
        """Of the hinge or slide of an object, in its frame."""
        q = problem.goal if grip.at_goal else problem.start
        return grip.pose(problem).R.T @ problem.model.calc_kinematics(q).axis_W[:, problem.model.objects[grip.index].v_begin]

    def _away(self, problem: Problem, grip: Grip) -> np.ndarray:
        """From the axis to the middle of the object, in its frame [m]."""
        z, middle = self._axis(problem, grip), self._middle_of(problem.model.object_names[grip.index])
        return middle - (middle @ z) * z

    def _middle_of(self, name: str) -> np.ndarray:
        """Of a body that is posed, in its frame [m]."""
        assert self.posed is not None
        for part in self.posed.parts:
            if self.posed.plan.bodies[part.body].name == name:
                return (part.mesh[0].min(axis=0) + part.mesh[0].max(axis=0)) / 2
        return np.zeros(3)

    def _gizmo_shape(self, problem: Problem, grip: Grip) -> dict[str, Any]:
        """Arrows and rings for the ways that the joint leaves."""
        assert self.posed is not None
        if grip.link:
            return {"scale": 0.35 * self.posed.view.radius, "disable_rotations": not grip.turns}
        info, name = problem.model.objects[grip.index], problem.model.object_names[grip.index]
        shape: dict[str, Any] = {"scale": max(2.2 * self.size_of(name), 0.15 * self.posed.view.radius)}
        if info.n_v == 1 and problem.model.dofs[info.v_begin].kind == st.DofKind.Prismatic:
            shape |= {"active_axes": (False, False, True), "disable_rotations": True, "disable_sliders": True}
        elif info.n_v == 1:
            away = float(np.linalg.norm(self._away(problem, grip)))
            if away > 0.2 * self.size_of(name):  # the ring passes the far edge of a door
                shape["scale"] = max(3.0 * away, 0.15 * self.posed.view.radius)
            shape |= {"active_axes": (True, True, False), "disable_axes": True, "disable_sliders": True}
        elif info.n_v == 3:
            plane = self.posed.plan.object_joints[name]
            shape["active_axes"] = {"planar_xy": (True, True, False), "planar_yz": (False, True, True), "planar_xz": (True, False, True)}[plane]
        return shape

    def put_handles(self, problem: Problem, but: Grip | None = None) -> None:
        """Every gizmo where its body is, which may be elsewhere than where it was dragged to; `but` the one that is dragged now."""
        for grip, (gizmo, X_BG) in self._gizmos.items():
            if grip != but:
                row = seven([grip.pose(problem) @ X_BG])[0]
                if np.abs(np.concatenate([gizmo.position - row[:3], gizmo.wxyz - row[3:]])).max() > 1e-9:
                    gizmo.position, gizmo.wxyz = row[:3], row[3:]

    def size_of(self, name: str) -> float:
        """Half the extent of an object of a task that is posed, or runs [m]."""
        drawing = self.posed or self.running
        assert drawing is not None
        for part in drawing.parts:
            if drawing.plan.bodies[part.body].name == name:
                return float(np.abs(part.mesh[0]).max())
        return 0.2 * drawing.view.radius

    # ---- faults ----

    def mark(self, faults: list[Fault]) -> None:
        """Paints what is at fault and says at its place what it is."""
        for handle in self._marks:
            handle.remove()
        self._marks = []
        if self.posed is None:
            return
        fixed = {body.name for body in self.posed.plan.bodies if body.kind == "fixed"}  # a whole kitchen may be one body
        wrong = {name for f in faults if not f.at_goal and f.kind in ("overlap", "stuck", "unsupported") for name in f.bodies}
        self.posed.paint(wrong - fixed or wrong, FAULT)
        wrong_goal = any(f.at_goal and f.kind != "goal" for f in faults)
        for ghost in (ghost for ghosts in self.posed.goal_ghosts.values() for ghost in ghosts):
            ghost.color = FAULT if wrong_goal else GOAL
        size = 0.02 * self.posed.view.radius
        scene = self.server.scene
        for number, fault in enumerate(f for f in faults if f.point is not None):
            assert fault.point is not None
            where = tuple(fault.point)
            self._marks.append(scene.add_icosphere(f"{POSE_ROOT}/fault{number}", radius=size, color=FAULT, position=where, cast_shadow=False))
            text = ("goal, " if fault.at_goal else "") + fault.label
            scene.add_label(f"{POSE_ROOT}/fault{number}/text", text, position=(0.0, 0.0, 2.5 * size), anchor="bottom-center", font_screen_scale=1.1)  # goes with its mark

    # ---- a task that runs ----

    def run(self, plan: Plan, pictures: Pictures, pulled: Pulled) -> None:
        """Draws a plant at its start, with the goal. The mouse pulls at objects: `pulled` is called by another thread."""
        self.clear()
        self._turn_to(pictures)
        self.running = drawing = Drawing(self.server, plan, root=RUN_ROOT, rods=pictures.rods(), with_goal=True, view=self._views.get(0), looks=pictures.looks())
        drawing.show_as(self.seen)
        self._views[0] = drawing.view
        drawing.place(plan.poses[0])
        drawing.label.visible = False
        if self.beside not in (0, 1):
            self.cameras.aim(drawing.view)
            self.beside = 0
        width = 0.04 * drawing.view.radius
        self._hand = self.server.scene.add_arrows(f"{RUN_ROOT}/hand", np.zeros((1, 2, 3)), HAND, shaft_radius=0.4 * width, head_radius=width, head_length=2 * width, visible=False)
        for body in (b for b in plan.bodies if b.kind == "object" and b.moving is not None):
            for mesh, _ in drawing.painted.get(body.name, []):
                self._let_pull(mesh, body.name, pulled)

    @staticmethod
    def _let_pull(mesh: viser.MeshHandle, body: str, pulled: Pulled) -> None:
        @mesh.on_drag("left")
        async def _(event: viser.SceneNodeDragEvent[viser.MeshHandle]) -> None:
            pulled(body, np.array(event.start_position), np.array(event.end_position), event.phase)

    def invite(self, guest: Guest) -> None:
        """In place of what is shown."""
        self.clear()
        self.guest, self.beside = guest, -1
        guest.drawing.show_as(self.seen)
        self.cameras.aim(guest.view)

    def show_run(self, poses: np.ndarray, force: np.ndarray, point: np.ndarray) -> None:
        """A plant as it is now, and the force of the hand at its point as an arrow [m]."""
        if self.running is None or self._hand is None:
            return
        self.running.place(poses)
        if force.any():
            self._hand.points = np.array([[point, point + force]], dtype=np.float32)
        if self._hand.visible != bool(force.any()):
            self._hand.visible = bool(force.any())

    # ---- motions ----

    def show(self, motions: list[Shown]) -> None:
        """Draws one motion, or two side by side. The camera stays where somebody has put it, unless one becomes two."""
        self.clear()
        self._turn_to(motions[0].pictures)
        plan = motions[0].plan
        view = best_view(plan, motions[0].pictures) if len(motions) > 1 else None
        step = np.zeros(3)
        if view is not None:
            away = view.position - view.look_at
            right = np.cross(view.up, away)
            right /= np.linalg.norm(right)
            step = APART * 2 * view.radius * right
        for k, motion in enumerate(motions):
            drawing = Drawing(self.server, motion.plan, root=SHOW_ROOTS[k], origin=k * step, rods=motion.pictures.rods(), with_goal=motion.with_goal, view=self._views.get(1), looks=motion.pictures.looks())
            drawing.show_as(self.seen)
            self._views[1] = drawing.view
            self.shown.append(drawing)
            if len(motions) > 1:
                at = drawing.view.label + 0.12 * drawing.view.radius * np.array(drawing.view.up)
                self._titles.append(self.server.scene.add_label(f"{SHOW_ROOTS[k]}/title", motion.title, position=tuple(at), anchor="bottom-center", font_screen_scale=1.2))
        if view is not None:
            away = view.position - view.look_at
            width = (APART * view.radius / (np.linalg.norm(away) * np.tan(view.fov / 2)) + view.width) / 1.75
            wide = View(view.position + step / 2 + 0.75 * away, view.look_at + step / 2, view.up, view.fov, 2 * view.radius, view.label, float(width))
        else:
            wide = self.shown[0].view
        if self.beside != len(motions):
            self.cameras.aim(wide)
            self.beside = len(motions)

    def show_frame(self, knot: int) -> None:
        """Every motion at a knot; one that is over rests at its end."""
        for drawing in self.shown:
            drawing.show(min(knot, len(drawing.plan.poses) - 1))
