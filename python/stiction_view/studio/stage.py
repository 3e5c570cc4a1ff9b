"""The scene of the studio: a task that is posed, or motions side by side."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import stiction as st
import viser

from ..bodies import GOAL, Color, body_meshes
from ..camera import View, choose_view
from ..drawing import Drawing, light, look
from ..frames import choose_frames
from ..plan import Plan
from .faults import Fault
from .picture import Pictures, pose_of, seven
from .problem import Problem

FAULT: Color = (214, 40, 40)
POSE_ROOT, RUN_ROOT, SHOW_ROOTS = "/pose", "/run", ("/first", "/second")
HAND: Color = (150, 60, 200)


class Guest(Protocol):
    """What draws itself, with controls of its own, until something else is shown."""

    view: View

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


def goal_of(problem: Problem) -> st.Pose:
    return problem.model.object_pose(problem.goal, problem.model.object_names[problem.goal_object])


def plan_of(problem: Problem, pictures: Pictures) -> Plan:
    """The start as a motion of one moment, with the goal."""
    return pictures.plan(problem.start, goal_of(problem), problem.goal_object, problem.given.name)


def is_seen(camera: viser.CameraHandle, point: np.ndarray) -> bool:
    """Whether a place is in the picture of a camera."""
    away, up = np.asarray(camera.look_at) - camera.position, np.asarray(camera.up_direction)
    right = np.cross(away, up)
    R = np.stack([v / np.linalg.norm(v) for v in (right, np.cross(right, away), away)])
    x, y, depth = R @ (point - camera.position)
    height = depth * np.tan(camera.fov / 2)
    return bool(depth > 0 and abs(y) < height and abs(x) < camera.aspect * height)


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
        self._gizmo: viser.TransformControlsHandle | None = None
        self._gizmo_of: int | None = None
        self.view: View | None = None
        self.beside = -1  # motions side by side when the camera was aimed last; 0: a task that is posed
        self._views: dict[int, View] = {}  # of the scene that is shown: posed, and played
        self._pictures: Pictures | None = None  # of that scene
        light(server.scene, shadows=False)

    # ---- nodes ----

    def clear(self) -> None:
        guest, self.guest = self.guest, None
        if guest is not None:
            guest.remove()
        for drawing in [*([self.posed] if self.posed else []), *([self.running] if self.running else []), *self.shown]:
            assert drawing.root_node is not None
            drawing.root_node.remove()  # and all below it
        self.posed, self.running, self._hand, self.shown, self._gizmo, self._marks, self._titles = None, None, None, [], None, [], []

    def _turn_to(self, pictures: Pictures, anew: bool = False) -> None:
        """At another scene the camera is aimed anew."""
        if anew or pictures is not self._pictures:
            self.beside, self._views, self._pictures = -1, {}, pictures

    def aim(self, view: View, clients: Iterable[viser.ClientHandle] | None = None) -> None:
        """Cameras of those who come, and of `clients`; None: of all who are there."""
        self.view = view
        look(self.server.initial_camera, view)
        for client in self.server.get_clients().values() if clients is None else clients:
            look(client.camera, view)

    # ---- a task that is posed ----

    def pose(self, problem: Problem, pictures: Pictures, aim: bool) -> None:
        """Draws the start and the goal of a task."""
        self.clear()
        plan = plan_of(problem, pictures)
        self._turn_to(pictures, aim)
        self.posed = Drawing(self.server, plan, root=POSE_ROOT, rods=pictures.rods(), with_goal=True, view=self._views.get(0))
        self._views[0] = self.posed.view
        self.posed.place(plan.poses[0])
        self.posed.label.visible = False
        if self.beside not in (0, 1):
            self.aim(self.posed.view)
            self.beside = 0

    def move_start(self, problem: Problem, pictures: Pictures) -> None:
        if self.posed is not None:
            self.posed.place(pictures.poses(problem.start)[0])

    def move_goal(self, problem: Problem) -> None:
        if self.posed is None:
            return
        row = seven([goal_of(problem)])[0]
        node = self.posed.goal_node
        node.position, node.wxyz = row[:3], row[3:]

    def follow_goal(self, problem: Problem, pictures: Pictures) -> None:
        """Aims anew where the goal has left somebody's picture."""
        lost = [client for client in self.server.get_clients().values() if not is_seen(client.camera, goal_of(problem).p)]
        if self.posed is not None and lost:
            plan = plan_of(problem, pictures)
            self.aim(choose_view(plan, body_meshes(plan, {}), choose_frames(plan)), lost)

    # ---- the handle that drags ----

    def hold(self, problem: Problem, index: int | None, at_goal: bool, moved: Callable[[st.Pose, bool], None]) -> None:
        """A gizmo on the goal, or on the start of an object; None: no gizmo. `moved(pose, ended)` comes from another thread."""
        if self._gizmo is not None:
            self._gizmo.remove()
            self._gizmo = None
        if index is None or self.posed is None:
            return
        axes = (True, True, True)
        single = problem.model.dofs[problem.model.objects[index].v_begin].kind if problem.model.objects[index].n_v == 1 else None
        slides, turns = single == st.DofKind.Prismatic, single == st.DofKind.Revolute
        if problem.model.objects[index].n_v == 3:
            plane = self.posed.plan.object_joints[problem.model.object_names[index]]
            axes = {"planar_xy": (True, True, False), "planar_yz": (False, True, True), "planar_xz": (True, False, True)}[plane]
        q = problem.goal if at_goal else problem.start
        row = seven([problem.model.object_pose(q, problem.model.object_names[index])])[0]
        size = self.size_of(problem.model.object_names[index])
        gizmo = self.server.scene.add_transform_controls(
            f"{POSE_ROOT}/handle", scale=2.2 * size, line_width=3.0, active_axes=axes, depth_test=False, opacity=0.85, position=row[:3], wxyz=row[3:],
            disable_rotations=slides, disable_axes=turns, disable_sliders=turns or slides,
        )
        self._gizmo, self._gizmo_of = gizmo, index

        @gizmo.on_update
        async def _(event: viser.TransformControlsEvent) -> None:
            pose = pose_of(np.concatenate([event.target.position, event.target.wxyz]))
            moved(st.Pose(pose.rotation(), pose.position), event.phase == "end")

    def put_handle(self, problem: Problem, at_goal: bool) -> None:
        """The gizmo where the object is, which may be less than where it was dragged to."""
        if self._gizmo is None or self._gizmo_of is None:
            return
        q = problem.goal if at_goal else problem.start
        row = seven([problem.model.object_pose(q, problem.model.object_names[self._gizmo_of])])[0]
        self._gizmo.position, self._gizmo.wxyz = row[:3], row[3:]

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
        self.posed.paint({name for f in faults if not f.at_goal and f.kind in ("overlap", "stuck", "unsupported") for name in f.bodies}, FAULT)
        wrong_goal = any(f.at_goal and f.kind != "goal" for f in faults)
        if self.posed.goal_ghost is not None:
            self.posed.goal_ghost.color = FAULT if wrong_goal else GOAL
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
        self.running = drawing = Drawing(self.server, plan, root=RUN_ROOT, rods=pictures.rods(), with_goal=True, view=self._views.get(0))
        self._views[0] = drawing.view
        drawing.place(plan.poses[0])
        drawing.label.visible = False
        if self.beside not in (0, 1):
            self.aim(drawing.view)
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
        self.aim(guest.view)

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
        view = choose_view(plan, body_meshes(plan, {}), choose_frames(plan)) if len(motions) > 1 else None
        step = np.zeros(3)
        if view is not None:
            away = view.position - view.look_at
            right = np.cross(view.up, away)
            right /= np.linalg.norm(right)
            step = APART * 2 * view.radius * right
        for k, motion in enumerate(motions):
            drawing = Drawing(self.server, motion.plan, root=SHOW_ROOTS[k], origin=k * step, rods=motion.pictures.rods(), with_goal=motion.with_goal, view=self._views.get(1))
            self._views[1] = drawing.view
            self.shown.append(drawing)
            if len(motions) > 1:
                at = drawing.view.label + 0.12 * drawing.view.radius * np.array(drawing.view.up)
                self._titles.append(self.server.scene.add_label(f"{SHOW_ROOTS[k]}/title", motion.title, position=tuple(at), anchor="bottom-center", font_screen_scale=1.2))
        if view is not None:
            wide = View(view.position + step / 2 + 0.75 * (view.position - view.look_at), view.look_at + step / 2, view.up, view.fov, 2 * view.radius, view.label)
        else:
            wide = self.shown[0].view
        if self.beside != len(motions):
            self.aim(wide)
            self.beside = len(motions)

    def show_frame(self, knot: int) -> None:
        """Every motion at a knot; one that is over rests at its end."""
        for drawing in self.shown:
            drawing.show(min(knot, len(drawing.plan.poses) - 1))
