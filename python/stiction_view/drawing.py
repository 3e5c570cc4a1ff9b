"""The bodies, goal, search tree and forces of a plan as nodes of a viser scene."""

from __future__ import annotations

import numpy as np
import viser

from . import charts, links, meshes
from .bodies import FIXED, FORCE, GOAL, GOAL_AXES, KIND_COLOR, KIND_TEXT, OBJECT, OBJECT_AXES, ROBOT, ROBOT_BASE, ROBOT_OPACITY, ROBOT_REGRASP, TREE, BodyMesh, Color, body_meshes, in_world, pose_at, pose_in, slug
from .camera import View, choose_view, is_on_one_joint
from .frames import choose_frames, frame_times
from .looks import NOTHING, Looks
from .plan import Body, Plan, Pose, rotation_matrices


def _wxyz(rotation: np.ndarray) -> np.ndarray:
    return viser.transforms.SO3.from_matrix(rotation).wxyz


Rods = tuple[dict[int, list[meshes.Mesh]], list[links.LooseRod]]


def light(scene: viser.SceneApi, *, shadows: bool = True) -> None:
    """Soft light from everywhere, and the lamp of the page. Its shadows take two seconds more until the first picture where no graphics card draws."""
    scene.set_up_direction("+z")
    scene.world_axes.visible = False
    scene.configure_environment_map(None)  # its reflections take ten seconds where no graphics card draws
    scene.add_light_ambient("/light", color=(240, 244, 255), intensity=2.4)
    scene.configure_default_lights(True, cast_shadow=shadows)


def far_end(view: View) -> float:
    """Behind which nothing is drawn [m]."""
    return float(300 * view.radius)


def look(camera: viser.InitialCameraConfig | viser.CameraHandle, view: View, far: float | None = None) -> None:
    """Puts a camera where the view is: that of everybody who comes, or of one who is there. None: to the far end of the view."""
    if isinstance(camera, viser.CameraHandle):
        camera.up_direction = tuple(view.up)
    else:
        camera.up = tuple(view.up)
    camera.fov = view.fov
    camera.near = float(0.01 * view.radius)
    camera.position = tuple(view.position)  # takes along what is looked at
    camera.look_at = tuple(view.look_at)
    camera.far = far_end(view) if far is None else far  # last: a page that tells it has the rest


def add_ghost(scene: viser.SceneApi, name: str, part: BodyMesh, *, grown: float, color: Color, opacity: float) -> viser.MeshHandle:
    """The far side of a slightly larger copy: it neither tints nor hides what is in front of it, and where both coincide it is a rim around the body."""
    middle = part.mesh[0].mean(axis=0)
    larger = middle + grown * (part.mesh[0] - middle)
    return scene.add_mesh_simple(name, larger, part.mesh[1], color=color, opacity=opacity, side="back", cast_shadow=False, receive_shadow=False)


def bare_bodies(plan: Plan, rods: dict[int, list[meshes.Mesh]], looks: Looks) -> list[int]:
    """That are seen, and nothing of them touches."""
    shaped = {g.body for g in plan.geometries if g.shape["type"] != "half_space"} | set(rods)
    return [i for i, body in enumerate(plan.bodies) if body.name in looks.patches and i not in shaped]


def find_parts(plan: Plan, rods: dict[int, list[meshes.Mesh]], looks: Looks) -> list[BodyMesh]:
    """What touches of every body, or what is seen of it where nothing touches."""
    return body_meshes(plan, rods) + [BodyMesh(i, looks.mesh(plan.bodies[i].name)) for i in bare_bodies(plan, rods, looks)]


class Drawing:
    """A plan under the node `root` of a scene, `origin` away from where it is; show(knot) moves it. Without `view` one is chosen.

    Bodies that have looks are drawn twice, as they are seen and as what touches; show_as() says which of both shows. A recorded page has one of
    both alone: without `touches` the other is not drawn.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        plan: Plan,
        *,
        root: str = "",
        origin: np.ndarray | None = None,
        rods: Rods | None = None,
        with_goal: bool = True,
        view: View | None = None,
        looks: Looks = NOTHING,
        touches: bool = True,
    ):
        self.plan = plan
        self.looks = looks
        self.root = root
        self.frames = choose_frames(plan)
        self.times = frame_times(self.frames)
        fixed_rods, self.loose_rods = links.find(plan) if rods is None else rods
        self.parts = parts = find_parts(plan, fixed_rods, looks)
        self.bare = set(bare_bodies(plan, fixed_rods, looks))
        self.view = view or choose_view(plan, parts, self.frames, links.ends(self.loose_rods))
        self.segment_shown = -1
        self.has_tree = False
        self.poses_shown: dict[int, np.ndarray] = {}
        self.moving_nodes: list[tuple[int, viser.SceneNodeHandle]] = []
        self.robot_meshes: list[viser.MeshHandle] = []  # of what touches
        self.painted: dict[str, list[tuple[viser.MeshHandle, Color]]] = {}  # meshes of a body with their own colours
        self.touched: list[viser.SceneNodeHandle] = []  # hidden where bodies show as they are seen
        self.seen: list[viser.SceneNodeHandle] = []
        self.goal_nodes: dict[int, viser.SceneNodeHandle] = {}  # by body
        self.goal_ghosts: dict[int, list[viser.MeshHandle]] = {}
        scene, view = server.scene, self.view
        self.root_node = scene.add_frame(root, show_axes=False, position=np.zeros(3) if origin is None else origin) if root else None

        self._add_bodies(scene, touches)
        self._add_loose_rods(scene, touches)
        self._add_planes(scene)
        if with_goal:
            self._add_goals(scene, touches)
        self._add_tree(scene, parts)

        self.force_scale, self.force_longest = self._force_scale(parts)
        self.arrows = scene.add_arrows(
            f"{root}/forces",
            np.zeros((1, 2, 3)),
            FORCE,
            shaft_radius=0.045 * self.force_longest,
            head_radius=0.11 * self.force_longest,
            head_length=0.25 * self.force_longest,
            visible=False,
        )
        self.label = scene.add_label(
            f"{root}/segment",
            " ",
            position=tuple(view.label),
            anchor="bottom-center",
            font_screen_scale=1.4,
        )
        self.show_as(seen=True)

    def _add_bodies(self, scene: viser.SceneApi, touches: bool) -> None:
        for part in self.parts:
            body = self.plan.bodies[part.body]
            node = f"{self.root}/{body.kind}/{slug(body.name)}"
            pose = pose_at(self.plan, part.body, int(self.frames[0]))
            frame = scene.add_frame(node, show_axes=False, wxyz=pose.wxyz, position=pose.position)
            self.painted[body.name] = painted = []
            if body.name in self.looks.patches:
                painted += self._dress(scene, node, body.name)
            if part.body not in self.bare and (touches or body.name not in self.looks.patches):
                shapes = self._add_shapes(scene, node, body, part.mesh)
                painted += shapes
                if body.name in self.looks.patches:
                    self.touched += [mesh for mesh, _ in shapes]
            if body.moving is not None:
                self.moving_nodes.append((part.body, frame))

    def show_as(self, seen: bool) -> None:
        """Bodies as their files show them, or as what touches."""
        for nodes, visible in ((self.seen, seen), (self.touched, not seen)):
            for node in nodes:
                if node.visible != visible:
                    node.visible = visible

    def _dress(self, scene: viser.SceneApi, node: str, name: str) -> list[tuple[viser.MeshHandle, Color]]:
        """A body as it is seen."""
        out = []
        for number, patch in enumerate(self.looks.patches[name]):
            mesh = scene.add_mesh_simple(f"{node}/seen{number}", patch.vertices, patch.triangles, color=patch.color, opacity=patch.opacity, side="double")
            out.append((mesh, patch.color))
        self.seen += [mesh for mesh, _ in out]
        return out

    def _add_shapes(self, scene: viser.SceneApi, node: str, body: Body, mesh: meshes.Mesh) -> list[tuple[viser.MeshHandle, Color]]:
        """What touches of a body."""
        if body.kind == "object":
            return self._paint(scene, node, mesh)
        color = FIXED if body.kind == "fixed" else ROBOT if body.moving is not None else ROBOT_BASE
        # Fingers are a little transparent: what they touch and the arrow heads inside them can be seen.
        opacity = ROBOT_OPACITY if body.kind == "robot" and body.moving is not None else None
        handle = scene.add_mesh_simple(f"{node}/shape", *mesh[:2], color=color, opacity=opacity)
        if body.kind == "robot" and body.moving is not None:
            self.robot_meshes.append(handle)
        return [(handle, color)]

    def _add_loose_rods(self, scene: viser.SceneApi, touches: bool) -> None:
        """Rods between links; those of a robot of which a file shows something go with what touches."""
        names = [body.name for body in self.plan.bodies]
        dressed = {name.split("/")[0] for name in self.looks.patches}
        if not touches:
            self.loose_rods = [rod for rod in self.loose_rods if names[rod.parent].split("/")[0] not in dressed]
        self.loose_nodes = []
        for number, rod in enumerate(self.loose_rods):
            vertices, triangles, _ = meshes.capsule(rod.radius, rod.length / 2)
            handle = scene.add_mesh_simple(f"{self.root}/robot/rod{number}", vertices, triangles, color=ROBOT, opacity=ROBOT_OPACITY)
            self.loose_nodes.append(handle)
            self.robot_meshes.append(handle)
            if names[rod.parent].split("/")[0] in dressed:
                self.touched.append(handle)

    def _paint(self, scene: viser.SceneApi, node: str, mesh: meshes.Mesh) -> list[tuple[viser.MeshHandle, Color]]:
        out = []
        for patch, color in enumerate(OBJECT):
            vertices, triangles = meshes.compact(mesh, mesh[2] == patch)
            if len(triangles) > 0:
                out.append((scene.add_mesh_simple(f"{node}/patch{patch}", vertices, triangles, color=color), color))
        return out

    def paint(self, names: set[str], color: Color) -> None:
        """Bodies of these names in one colour, all others in their own."""
        for name, painted in self.painted.items():
            for mesh, own in painted:
                wanted = color if name in names else own
                if tuple(mesh.color) != wanted:
                    mesh.color = wanted

    def _add_planes(self, scene: viser.SceneApi) -> None:
        """Half-spaces have no bounds: a grid under what matters."""
        view = self.view
        for number, geometry in enumerate(self.plan.geometries):
            if geometry.shape["type"] != "half_space":
                continue
            body = pose_at(self.plan, geometry.body, 0)
            rotation = body.rotation() @ geometry.X_BG.rotation()
            origin = in_world(geometry.X_BG.position[None], body)[0]
            normal = rotation[:, 2]
            cell = 10.0 ** np.floor(np.log10(view.radius / 2))
            scene.add_grid(
                f"{self.root}/fixed/plane{number}",
                width=float(6 * view.radius),
                height=float(6 * view.radius),
                plane="xy",
                cell_size=float(cell),
                cell_color=(222, 225, 230),
                section_size=float(5 * cell),
                section_color=(198, 203, 211),
                plane_color=(244, 245, 247),
                plane_opacity=1.0,
                fade_distance=float(14 * view.radius),
                wxyz=_wxyz(rotation),
                position=tuple(view.look_at - normal * (normal @ (view.look_at - origin))),
            )

    def _add_goals(self, scene: viser.SceneApi, touches: bool) -> None:
        for number, (body, goal) in enumerate([(self.plan.goal_body, self.plan.goal), *self.plan.more_goals]):
            self._add_goal(scene, f"{self.root}/goal{number or ''}", body, goal, touches)

    def _add_goal(self, scene: viser.SceneApi, node: str, body: int, goal: Pose, touches: bool) -> None:
        """An object at its goal as a green ghost, and two frames that must meet: thin at the goal, thick on the object. On a hinge or slide the ghost says all."""
        part = next((p for p in self.parts if p.body == body), None)
        extent = np.abs(part.mesh[0]).max() if part is not None else 0.3 * self.view.radius
        name = self.plan.bodies[body].name
        framed = not is_on_one_joint(self.plan, body)
        self.goal_nodes[body] = scene.add_frame(
            node,
            show_axes=framed,
            wxyz=goal.wxyz,
            position=goal.position,
            axes_length=float(GOAL_AXES * extent),
            axes_radius=float(0.016 * extent),
            origin_radius=0.0,
        )
        ghosts = self.goal_ghosts.setdefault(body, [])
        if name in self.looks.patches:
            ghosts.append(add_ghost(scene, f"{node}/seen", BodyMesh(body, self.looks.mesh(name)), grown=1.05, color=GOAL, opacity=0.42))
            self.seen.append(ghosts[-1])
        if part is not None and body not in self.bare and (touches or not ghosts):
            ghosts.append(add_ghost(scene, f"{node}/ghost", part, grown=1.05, color=GOAL, opacity=0.42))
            if len(ghosts) > 1:
                self.touched.append(ghosts[-1])
        scene.add_frame(
            f"{self.root}/object/{slug(name)}/axes",
            show_axes=framed,
            axes_length=float(OBJECT_AXES * extent),
            axes_radius=float(0.035 * extent),
            origin_radius=0.0,
        )

    def _add_tree(self, scene: viser.SceneApi, parts: list[BodyMesh]) -> None:
        """Where the search took the object: edges between the ends of that axis of the object whose end moves most, and the plan's own way."""
        plan = self.plan
        if len(plan.tree_parents) < 2:
            return
        part = next((p for p in parts if p.body == plan.goal_body), None)
        length = OBJECT_AXES * (np.abs(part.mesh[0]).max() if part is not None else 0.3 * self.view.radius)

        def ends(poses: np.ndarray) -> np.ndarray:  # (n, axis, 3)
            return poses[:, None, :3] + length * np.swapaxes(rotation_matrices(poses[:, 3:]), 1, 2)

        tree, way = ends(plan.tree_poses), ends(plan.poses[:, plan.bodies[plan.goal_body].moving])
        children = np.flatnonzero(plan.tree_parents >= 0)
        edges = np.stack([tree[plan.tree_parents[children]], tree[children]], axis=1)  # (n, 2, axis, 3)
        steps = np.linalg.norm(edges[:, 1] - edges[:, 0], axis=-1)  # (n, axis)
        axis = int(np.argmax(steps.sum(axis=0)))
        moved = steps[:, axis] > 1e-3 * length
        for name, points, color, width in (
            ("/tree", edges[moved, :, axis], TREE, 1.0),
            ("/way", np.stack([way[:-1, axis], way[1:, axis]], axis=1), OBJECT[0], 3.0),
        ):
            if len(points) > 0:
                scene.add_line_segments(self.root + name, points.astype(np.float32), color, thickness=width, thickness_units="screen")
        self.has_tree = True

    def _force_scale(self, parts: list[BodyMesh]) -> tuple[float, float]:
        """Metres per newton, and the length of the longest arrow [m]. The largest tenth of the forces is cut to that length."""
        part = next((p for p in parts if p.body == self.plan.goal_body), None)
        size = np.linalg.norm(part.mesh[0], axis=1).max() if part is not None else 0.3 * self.view.radius
        longest = float(np.clip(1.3 * size, 0.15 * self.view.radius, 0.6 * self.view.radius))
        newtons = [np.linalg.norm(c.force) for contacts in self.plan.contacts for c in contacts]
        newtons = [n for n in newtons if n > 1e-6]
        largest = float(np.quantile(newtons, 0.9)) if newtons else 1.0
        return longest / largest, longest

    def place(self, poses: np.ndarray) -> None:
        """Moves the bodies to (moving bodies, 7); sends only what changed."""
        bodies = self.plan.bodies
        for body, node in self.moving_nodes:
            row = poses[bodies[body].moving]
            before = self.poses_shown.get(body)
            if before is None or np.abs(row - before).max() > 2e-5:
                node.position = row[:3]
                node.wxyz = row[3:]
                self.poses_shown[body] = row

        for rod, node in zip(self.loose_rods, self.loose_nodes):
            end = pose_in(bodies[rod.child], poses).position
            start = in_world(rod.p_P[None], pose_in(bodies[rod.parent], poses))[0]
            node.position = (start + end) / 2
            node.wxyz = _wxyz(links.along(end - start))

    def show(self, knot: int) -> None:
        """Moves everything to a knot."""
        plan = self.plan
        self.place(plan.poses[knot])
        tails, heads = [], []
        for contact in plan.contacts[knot]:
            force = float(np.linalg.norm(contact.force))
            length = min(force * self.force_scale, self.force_longest)
            if length > 0.02 * self.force_longest:
                # The arrow ends where the force acts and comes from the side that pushes.
                heads.append(contact.point)
                tails.append(contact.point - contact.force / force * max(length, 0.3 * self.force_longest))
        if heads:
            self.arrows.points = np.stack([tails, heads], axis=1).astype(np.float32)
        if self.arrows.visible != bool(heads):
            self.arrows.visible = bool(heads)

        segment = int(plan.segment[knot])
        if segment != self.segment_shown:
            kind = plan.segment_kinds[segment]
            if len(plan.segment_kinds) > 1:
                self.label.text = f"{KIND_TEXT[kind]}   {segment + 1} / {len(plan.segment_kinds)}"
            before_kind = plan.segment_kinds[self.segment_shown] if self.segment_shown >= 0 else ""
            if (kind == "regrasp") != (before_kind == "regrasp"):
                for mesh in self.robot_meshes:
                    mesh.color = ROBOT_REGRASP if kind == "regrasp" else ROBOT
            self.segment_shown = segment

    # ---- text of the page ----

    def largest_force(self) -> float:
        return self.force_longest / self.force_scale

    def summary(self) -> list[tuple[str, str]]:
        plan = self.plan
        kinds = plan.segment_kinds
        region = [("goal", ", ".join(plan.goal_region))] if plan.goal_region else []
        return [
            ("status", plan.status),
            ("seed", str(plan.seed)),
            ("segments", f"{len(kinds)}, of which {kinds.count('regrasp')} regrasps"),
            *region,
            ("at the goal", f"{1000 * plan.error_position:.1f} mm, {plan.error_angle:.3f} rad off"),
            ("longest arrow", f"{self.largest_force():.{0 if self.largest_force() >= 10 else 2}f} N"),
            *self.loads_summary(),
        ]

    def loads_summary(self) -> list[tuple[str, str]]:
        """Rows of the largest effort and press, and where they are."""
        plan = self.plan
        return charts.summary(plan.loads, [f"{KIND_TEXT[plan.segment_kinds[s]]} {s + 1}" for s in plan.segment]) if plan.loads else []

    def keys(self) -> list[tuple[Color, str]]:
        kinds = [k for k in KIND_TEXT if k in self.plan.segment_kinds]
        return [*((KIND_COLOR[k], KIND_TEXT[k]) for k in kinds), *([(TREE, "search tree")] if self.has_tree else []), (GOAL, "goal"), (FORCE, "contact force")]

    def timeline(self) -> str:
        """CSS gradient: what kind of segment each moment of the show belongs to."""
        segment = self.plan.segment[self.frames]
        total = self.times[-1]
        stops = []
        starts = np.concatenate([[0], np.flatnonzero(np.diff(segment)) + 1])
        for start, end in zip(starts, np.append(starts[1:], len(segment))):
            color = "rgb(%d,%d,%d)" % KIND_COLOR[self.plan.segment_kinds[segment[start]]]
            stops.append(f"{color} {100 * self.times[start] / total:.2f}% {100 * self.times[end] / total:.2f}%")
        return f"linear-gradient(to right, {', '.join(stops)})"
