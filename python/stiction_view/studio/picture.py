"""Models and what is computed with them as the plans that drawing.py draws."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import stiction as st

from .. import links
from ..drawing import Rods
from ..looks import Looks, read_looks
from ..plan import Body, Contact, Geometry, Plan, Pose, read_plan_object

BONE = 0.012  # thickness of a link that nothing can touch, of the reach of its robot
POSTURES = 40  # random ones, from which rods learn what turns about what
KINDS = {st.BodyKind.Fixed: "fixed", st.BodyKind.Object: "object", st.BodyKind.Robot: "robot"}


def quaternions(R: np.ndarray) -> np.ndarray:
    """Rotations (n, 3, 3) → (n, 4) w, x, y, z, from the column of largest norm of the matrix 4 q qᵀ."""
    t = np.trace(R, axis1=1, axis2=2)
    K = np.empty((len(R), 4, 4))
    K[:, 0, 0] = 1 + t
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        K[:, 1 + i, 1 + i] = 1 - t + 2 * R[:, i, i]
        K[:, 0, 1 + i] = K[:, 1 + i, 0] = R[:, k, j] - R[:, j, k]
        K[:, 1 + i, 1 + j] = K[:, 1 + j, 1 + i] = R[:, i, j] + R[:, j, i]
    best = np.argmax(np.einsum("nii->ni", K), axis=1)
    q = K[np.arange(len(R)), best]
    return q / np.linalg.norm(q, axis=1, keepdims=True)


def seven(X: Sequence[st.Pose]) -> np.ndarray:
    """Poses as rows x, y, z, qw, qx, qy, qz."""
    if not X:
        return np.empty((0, 7))
    return np.column_stack([np.array([x.p for x in X]), quaternions(np.array([x.R for x in X]))])


def pose_of(row: np.ndarray) -> Pose:
    return Pose(row[:3], row[3:])


def bare_links(model: st.Model) -> list[int]:
    """Bodies of robots that nothing can touch."""
    index = {body.name: i for i, body in enumerate(model.bodies)}
    return sorted({index[link.name] for link in model.links} - {g.body for g in model.geometries})


def read_bodies(model: st.Model) -> tuple[list[Body], list[Geometry], list[int]]:
    """Bodies with geometry, then links of robots without, the geometries, and the indices in the model of those that move."""
    geometries = model.geometries
    shown = sorted({g.body for g in geometries}) + bare_links(model)
    rows = seven(model.calc_kinematics(model.neutral()).X_WB)
    bodies: list[Body] = []
    moving: list[int] = []
    for index in shown:
        body = model.bodies[index]
        bodies.append(Body(body.name, KINDS[body.kind], len(moving) if body.dofs else None, None if body.dofs else pose_of(rows[index])))
        if body.dofs:
            moving.append(index)
    place = {index: k for k, index in enumerate(shown)}
    return bodies, [Geometry(g.name, place[g.body], g.shape, pose_of(seven([g.X_BG])[0])) for g in geometries], moving


JOINTS = {7: "free", 1: "hinge"}


def joint_of(model: st.Model, index: int) -> str:
    """How an object moves; of planar ones the plane."""
    info = model.objects[index]
    if info.n_q in JOINTS:
        return JOINTS[info.n_q]
    axis = model.calc_kinematics(model.neutral()).axis_W[:, info.v_begin + 2]
    return ("planar_yz", "planar_xz", "planar_xy")[int(np.argmax(np.abs(axis)))]


class Pictures:
    """What is drawn of one model, computed once."""

    def __init__(self, model: st.Model):
        self.model = model
        self.bodies, self.geometries, self.moving = read_bodies(model)
        self.joints = {name: joint_of(model, i) for i, name in enumerate(model.object_names)}
        self._rods: Rods | None = None
        self._looks: Looks | None = None

    def looks(self) -> Looks:
        """What the files of the robots show."""
        if self._looks is None:
            self._looks = read_looks(self.model)
        return self._looks

    def body_of(self, index: int) -> int | None:
        """The number among `bodies` of an object; None: it has no shape."""
        return next((i for i, body in enumerate(self.bodies) if body.kind == "object" and body.name == self.model.object_names[index]), None)

    def poses(self, q: np.ndarray) -> np.ndarray:
        """Configurations (n, n_q) → (n, moving bodies, 7)."""
        q = np.atleast_2d(q)
        X = [self.model.calc_kinematics(row).X_WB for row in q]
        return seven([x[i] for x in X for i in self.moving]).reshape(len(q), len(self.moving), 7)

    def plan(self, q: np.ndarray, goal: st.Pose, goal_object: int, name: str, contacts: list[list[Contact]] | None = None) -> Plan:
        """A motion (n, n_q) as a plan of one piece; without a search tree."""
        poses = self.poses(q)
        object_name = self.model.object_names[goal_object] if self.model.object_names else None
        goal_body = next((i for i, b in enumerate(self.bodies) if b.kind == "object" and b.name == object_name), None)
        if goal_body is None:  # nothing is to go anywhere: what moves last stands for it
            goal_body = max((i for i, b in enumerate(self.bodies) if b.moving is not None), default=0)
        return Plan(
            task=name,
            status="",
            seed=0,
            error_position=0.0,
            error_angle=0.0,
            bodies=self.bodies,
            geometries=self.geometries,
            object_joints=self.joints,
            goal_body=goal_body,
            goal=pose_of(seven([goal])[0]),
            goal_region=[],
            poses=poses,
            contacts=contacts or [[] for _ in poses],
            segment=np.zeros(len(poses), dtype=int),
            segment_kinds=["contact"],
            tree_parents=np.empty(0, dtype=int),
            tree_poses=np.empty((0, 7)),
        )

    def rods(self) -> Rods:
        """Rods between the spheres of a robot (links.py), from how its joints may move."""
        if self._rods is None:
            model, rng = self.model, np.random.default_rng(0)
            q = np.tile(model.neutral(), (POSTURES, 1))
            if model.n_a:
                low, high = np.maximum(model.lower, -np.pi), np.minimum(model.upper, np.pi)
                q[1:, model.n_qu :] = rng.uniform(low, high, (POSTURES - 1, model.n_a))
            origin = st.Pose(np.eye(3), np.zeros(3))
            fixed, loose = links.find(self.plan(q, origin, 0, ""))
            self._rods = (fixed, loose + self._bones())
        return self._rods

    def _bones(self) -> list[links.LooseRod]:
        """From joint to joint along links that nothing can touch: an arm of which files give pictures alone is seen all the same."""
        model, bare = self.model, {self.model.bodies[i].name for i in bare_links(self.model)}
        index = {body.name: i for i, body in enumerate(self.bodies)}
        X = {body.name: x for body, x in zip(model.bodies, model.calc_kinematics(model.neutral()).X_WB)}
        slides = {body.name for body in model.bodies if body.dofs and model.dofs[body.dofs[-1]].kind == st.DofKind.Prismatic}
        radius = BONE * float(np.max(model.reach, initial=1.0))
        out = []
        for link in model.links:
            if link.parent is None or not {link.name, link.parent} & bare or link.name in slides:
                continue
            length = float(np.linalg.norm(X[link.name].p - X[link.parent].p))
            if length > radius:
                out.append(links.LooseRod(index[link.parent], np.zeros(3), index[link.name], length, radius))
        return out

    def with_bare_links(self, plan: Plan, q: np.ndarray) -> Plan:
        """A plan of a file, whose bodies all have geometry, with the other ones of this model at its knots (n, n_q)."""
        known = len(plan.bodies)
        if known == len(self.bodies):
            return plan
        moving = sum(body.moving is not None for body in plan.bodies)
        return replace(plan, bodies=plan.bodies + self.bodies[known:], poses=np.concatenate([plan.poses, self.poses(q)[:, moving:]], axis=1))


def plan_drawn(plan: st.Plan) -> Plan:
    """What is drawn of a plan: that of its file."""
    return read_plan_object(json.loads(plan.to_text()))
