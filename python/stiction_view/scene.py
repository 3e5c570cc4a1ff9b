"""Draws a plan with viser: the same scene for the recorded page and for the live view."""

from __future__ import annotations

import contextlib
import html
import io
import logging
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import viser

from . import links, meshes
from .plan import Plan, Pose, rotation_matrices

Color = tuple[int, int, int]

ROBOT: Color = (205, 208, 214)
ROBOT_BASE: Color = (128, 134, 144)
ROBOT_OPACITY = 0.72
ROBOT_REGRASP: Color = (96, 146, 232)
FIXED: Color = (172, 176, 184)
OBJECT: tuple[Color, Color, Color] = ((238, 126, 36), (253, 226, 178), (120, 52, 10))
GOAL: Color = (38, 160, 92)
FORCE: Color = (206, 24, 74)
TREE: Color = (128, 112, 196)
KIND_COLOR: dict[str, Color] = {"settle": (158, 162, 170), "contact": OBJECT[0], "regrasp": (70, 122, 214)}
KIND_TEXT = {"settle": "settle", "contact": "push", "regrasp": "regrasp"}

GOAL_AXES, OBJECT_AXES = 1.6, 1.3  # lengths, times the size of the object

FRAMES_PER_SECOND = 24.0  # one knot per frame: joints move at most 0.03 rad a knot, which is about human speed
MAX_FRAMES = 600
MAX_SECONDS = 50.0
HOLD_START, HOLD_END = 0.8, 1.5  # [s]


# ---- what is shown when ----


def choose_frames(plan: Plan) -> np.ndarray:
    """Knots to show: all of them, or an even choice that keeps the first and the last knot of every segment."""
    knots = len(plan.poses)
    if knots <= MAX_FRAMES:
        return np.arange(knots)
    ends = np.flatnonzero(np.diff(plan.segment)) if len(plan.segment_kinds) > 1 else np.array([], dtype=int)
    must = np.concatenate([[0], ends, ends + 1, [knots - 1]])
    even = np.linspace(0, knots - 1, max(2, MAX_FRAMES - len(must))).round().astype(int)
    return np.unique(np.concatenate([must, even]))


def frame_times(frames: np.ndarray) -> np.ndarray:
    """Seconds at which each frame appears, and the end of the show as one more entry."""
    knots = frames[-1] - frames[0]
    per_knot = min(1.0 / FRAMES_PER_SECOND, MAX_SECONDS / max(1, knots))
    times = HOLD_START + per_knot * (frames - frames[0])
    times[0] = 0.0
    return np.append(times, times[-1] + HOLD_END)


# ---- what is where ----


@dataclass
class BodyMesh:
    body: int
    mesh: meshes.Mesh  # in the body frame


def body_meshes(plan: Plan, rods: dict[int, list[meshes.Mesh]]) -> list[BodyMesh]:
    """One mesh per body: its geometries, and rods between spheres."""
    result = []
    for index in range(len(plan.bodies)):
        parts = list(rods.get(index, []))
        for geometry in plan.geometries:
            mesh = meshes.of_shape(geometry.shape) if geometry.body == index else None
            if mesh is not None:
                vertices = mesh[0] @ geometry.X_BG.rotation().T + geometry.X_BG.position
                parts.append((vertices, mesh[1], mesh[2]))
        if parts:
            result.append(BodyMesh(index, meshes.join(parts)))
    return result


def pose_at(plan: Plan, body: int, knot: int) -> Pose:
    column = plan.bodies[body].moving
    if column is None:
        fixed = plan.bodies[body].pose
        assert fixed is not None
        return fixed
    row = plan.poses[knot, column]
    return Pose(row[:3], row[3:])


def in_world(points: np.ndarray, pose: Pose) -> np.ndarray:
    return points @ pose.rotation().T + pose.position


@dataclass
class View:
    position: np.ndarray
    look_at: np.ndarray
    up: np.ndarray
    fov: float
    radius: float  # of what matters [m]
    label: np.ndarray  # above everything, in the picture


def choose_view(plan: Plan, parts: list[BodyMesh], frames: np.ndarray) -> View:
    """Frames what moves and the goal, from a side from which the object is seen.

    Plane problems are looked at along the normal of their plane. Otherwise the candidates are directions on the upper half of a sphere,
    and the one from which most of the object is not hidden behind anything else wins, over a few moments of the plan.
    """
    moments = frames[np.linspace(0, len(frames) - 1, 5).round().astype(int)]
    samples = sample_surfaces(plan, parts)

    interesting = [in_world(samples[plan.goal_body], plan.goal)] if plan.goal_body in samples else [plan.goal.position[None]]
    for body, points in samples.items():
        if plan.bodies[body].moving is not None:
            interesting += [in_world(points, pose_at(plan, body, knot)) for knot in moments]
    core = np.concatenate(interesting)
    size = np.linalg.norm(np.ptp(core, axis=0))
    # Robot bases and fixed bodies count where they are of the size of the rest; a table as large as a room does not.
    for body, points in samples.items():
        if plan.bodies[body].moving is None:
            world = in_world(points, pose_at(plan, body, 0))
            if np.linalg.norm(np.ptp(world, axis=0)) < 1.2 * size:
                interesting.append(world)
    object_size = np.abs(next(p.mesh[0] for p in parts if p.body == plan.goal_body)).max() if plan.goal_body in samples else 0.0
    interesting.append(in_world(GOAL_AXES * object_size * np.eye(3), plan.goal))
    interesting += [in_world(OBJECT_AXES * object_size * np.eye(3), pose_at(plan, plan.goal_body, knot)) for knot in moments]
    everything = np.concatenate(interesting)
    low, high = everything.min(axis=0), everything.max(axis=0)
    centre = (low + high) / 2

    joint = plan.object_joints.get(plan.bodies[plan.goal_body].name, "free")
    plane_views = {
        "planar_xy": (np.array([0.0, -0.1, 1.0]), np.array([0.0, 0.0, 1.0])),
        "planar_yz": (np.array([1.0, 0.07, 0.1]), np.array([0.0, 0.0, 1.0])),
        "planar_xz": (np.array([0.07, -1.0, 0.1]), np.array([0.0, 0.0, 1.0])),
    }
    fov = np.radians(40.0)
    if joint in plane_views:
        direction, up = plane_views[joint]
        fov = np.radians(12.0)  # from far away, so that the near side of a body hides nothing beside it
    else:
        up = np.array([0.0, 0.0, 1.0])
        candidates = [
            np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
            for e in np.radians([30.0, 42.0, 55.0])
            for a in np.radians(np.arange(0.0, 360.0, 22.5) - 45.0)
        ]
        scores = [sum(visible(plan, samples, knot, d) for knot in moments) for d in candidates]
        direction = candidates[int(np.argmax(np.round(scores, 2)))]
    direction = direction / np.linalg.norm(direction)

    # Distance at which all points fit, for a page that is wider than high.
    right = np.cross(up, direction)
    right /= np.linalg.norm(right)
    above = np.cross(direction, right)
    offset = everything - centre
    depth = offset @ direction
    vertical = np.abs(offset @ above) / np.tan(0.80 * fov / 2) + depth
    horizontal = np.abs(offset @ right) / np.tan(1.1 * fov / 2) + depth
    distance = max(vertical.max(), horizontal.max())
    radius = float(np.linalg.norm(offset, axis=1).max())
    label = centre + 1.08 * (offset @ above).max() * above
    # A little to the right, because the panel with the figures is on the left.
    look_at = centre - 0.2 * distance * np.tan(fov / 2) * right
    return View(look_at + distance * direction, look_at, up, fov, radius, label)


def _cell(points: np.ndarray) -> float:
    """Of the depth buffer: a fourteenth of the object."""
    return float(np.linalg.norm(np.ptp(points, axis=0))) / 14


def sample_surfaces(plan: Plan, parts: list[BodyMesh]) -> dict[int, np.ndarray]:
    """Points on every body, as close as the cells of the depth buffer: a wall with gaps would hide nothing."""
    rng = np.random.default_rng(0)
    cell = _cell(next((part.mesh[0] for part in parts if part.body == plan.goal_body), np.zeros((1, 3))))

    def count(area: float) -> int:
        return int(np.clip(3 * area / cell**2 if cell > 0 else 0, 400, 20000))

    return {part.body: meshes.surface_points(part.mesh, count(meshes.surface_area(part.mesh)), rng) for part in parts}


def visible(plan: Plan, samples: dict[int, np.ndarray], knot: int, direction: np.ndarray) -> float:
    """Part of the picture of the object that nothing else covers, seen from `direction`: a coarse depth buffer of surface points."""
    if plan.goal_body not in samples:
        return 0.0
    right = np.cross([0.0, 0.0, 1.0], direction)
    right /= np.linalg.norm(right)
    up = np.cross(direction, right)
    points = [in_world(p, pose_at(plan, body, knot)) for body, p in samples.items()]
    is_object = np.concatenate([np.full(len(p), body == plan.goal_body) for body, p in samples.items()])
    world = np.concatenate(points)
    cell = _cell(samples[plan.goal_body])
    column, row = (np.round(world @ axis / cell).astype(int) for axis in (right, up))
    near = np.ones(len(world), dtype=bool)
    for index in (column, row):  # nothing else can cover the object
        near &= (index >= index[is_object].min()) & (index <= index[is_object].max())
    world, is_object, column, row = world[near], is_object[near], column[near], row[near]
    key = (column - column.min()) * (np.ptp(row) + 1) + row - row.min()
    # Sorted by cell and, within a cell, by depth: the last point of a cell is the one that is seen.
    order = np.lexsort((world @ direction, key))
    seen = order[np.append(np.diff(key[order]) > 0, True)]
    return float(is_object[seen].sum() / len(np.unique(key[is_object])))


# ---- drawing ----


def _slug(name: str) -> str:
    """A node name without the separators of the scene tree."""
    return "".join(c if c.isalnum() or c in "-_." else "_" for c in name)


def _wxyz(rotation: np.ndarray) -> np.ndarray:
    return viser.transforms.SO3.from_matrix(rotation).wxyz


class Drawing:
    """The scene of one plan on a server; show(knot) moves it."""

    def __init__(self, server: viser.ViserServer, plan: Plan):
        self.plan = plan
        self.frames = choose_frames(plan)
        self.times = frame_times(self.frames)
        rods, self.loose_rods = links.find(plan)
        parts = body_meshes(plan, rods)
        self.view = choose_view(plan, parts, self.frames)
        self.segment_shown = -1
        self.has_tree = False
        self.poses_shown: dict[int, np.ndarray] = {}
        self.moving_nodes: list[tuple[int, viser.SceneNodeHandle]] = []
        self.robot_meshes: list[viser.MeshHandle] = []
        scene, view = server.scene, self.view

        scene.set_up_direction("+z")
        server.initial_camera.up = tuple(view.up)
        server.initial_camera.fov = view.fov
        server.initial_camera.near = float(0.01 * view.radius)
        server.initial_camera.far = float(300 * view.radius)
        server.initial_camera.look_at = tuple(view.look_at)
        server.initial_camera.position = tuple(view.position)
        scene.world_axes.visible = False
        # Soft light from everywhere and one lamp that casts a shadow; both from the page itself.
        scene.configure_default_lights(True, cast_shadow=True)

        for part in parts:
            body = plan.bodies[part.body]
            node = f"/{body.kind}/{_slug(body.name)}"
            pose = pose_at(plan, part.body, int(self.frames[0]))
            frame = scene.add_frame(node, show_axes=False, wxyz=pose.wxyz, position=pose.position)
            if body.kind == "object":
                self._paint(scene, node, part.mesh)
            else:
                color = FIXED if body.kind == "fixed" else ROBOT if body.moving is not None else ROBOT_BASE
                vertices, triangles = part.mesh[:2]
                # Fingers are a little transparent: what they touch and the arrow heads inside them can be seen.
                opacity = ROBOT_OPACITY if body.kind == "robot" and body.moving is not None else None
                handle = scene.add_mesh_simple(f"{node}/shape", vertices, triangles, color=color, opacity=opacity)
                if body.kind == "robot" and body.moving is not None:
                    self.robot_meshes.append(handle)
            if body.moving is not None:
                self.moving_nodes.append((part.body, frame))
        self.loose_nodes = []
        for number, rod in enumerate(self.loose_rods):
            vertices, triangles, _ = meshes.capsule(rod.radius, rod.length / 2)
            handle = scene.add_mesh_simple(f"/robot/rod{number}", vertices, triangles, color=ROBOT, opacity=ROBOT_OPACITY)
            self.loose_nodes.append(handle)
            self.robot_meshes.append(handle)
        self._add_planes(scene)
        self._add_goal(scene, parts)
        self._add_tree(scene, parts)

        self.force_scale, self.force_longest = self._force_scale(parts)
        self.arrows = scene.add_arrows(
            "/forces",
            np.zeros((1, 2, 3)),
            FORCE,
            shaft_radius=0.045 * self.force_longest,
            head_radius=0.11 * self.force_longest,
            head_length=0.25 * self.force_longest,
            visible=False,
        )
        self.label = scene.add_label(
            "/segment",
            " ",
            position=tuple(view.label),
            anchor="bottom-center",
            font_screen_scale=1.4,
        )

    def _paint(self, scene: viser.SceneApi, node: str, mesh: meshes.Mesh, opacity: float | None = None) -> None:
        for patch, color in enumerate(OBJECT):
            vertices, triangles = meshes.compact(mesh, mesh[2] == patch)
            if len(triangles) > 0:
                scene.add_mesh_simple(f"{node}/patch{patch}", vertices, triangles, color=color, opacity=opacity)

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
                f"/fixed/plane{number}",
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

    def _add_goal(self, scene: viser.SceneApi, parts: list[BodyMesh]) -> None:
        """The object at its goal as a green ghost, and two frames that must meet: thin at the goal, thick on the object."""
        plan, goal = self.plan, self.plan.goal
        part = next((p for p in parts if p.body == plan.goal_body), None)
        extent = np.abs(part.mesh[0]).max() if part is not None else 0.3 * self.view.radius
        name = _slug(plan.bodies[plan.goal_body].name)
        scene.add_frame(
            "/goal",
            wxyz=goal.wxyz,
            position=goal.position,
            axes_length=float(GOAL_AXES * extent),
            axes_radius=float(0.016 * extent),
            origin_radius=0.0,
        )
        if part is not None:
            # Only the far side of a slightly larger copy: it neither tints nor hides what is in front of it, and where object and goal
            # coincide it is a rim around the object.
            middle = part.mesh[0].mean(axis=0)
            scene.add_mesh_simple(
                "/goal/ghost",
                middle + 1.05 * (part.mesh[0] - middle),
                part.mesh[1],
                color=GOAL,
                opacity=0.42,
                side="back",
                cast_shadow=False,
                receive_shadow=False,
            )
        scene.add_frame(
            f"/object/{name}/axes",
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
                scene.add_line_segments(name, points.astype(np.float32), color, thickness=width, thickness_units="screen")
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

    def show(self, knot: int) -> None:
        """Moves everything to a knot; sends only what changed."""
        plan = self.plan
        for body, node in self.moving_nodes:
            row = plan.poses[knot, plan.bodies[body].moving]
            before = self.poses_shown.get(body)
            if before is None or np.abs(row - before).max() > 2e-5:
                node.position = row[:3]
                node.wxyz = row[3:]
                self.poses_shown[body] = row

        for rod, node in zip(self.loose_rods, self.loose_nodes):
            end = pose_at(plan, rod.child, knot).position
            start = in_world(rod.p_P[None], pose_at(plan, rod.parent, knot))[0]
            node.position = (start + end) / 2
            node.wxyz = _wxyz(links.along(end - start))

        tails, heads = [], []
        for contact in plan.contacts[knot]:
            force = np.linalg.norm(contact.force)
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
        ]

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


@contextlib.contextmanager
def _server(port: int):
    """A viser server on localhost that neither prints nor logs."""
    logging.getLogger("websockets").setLevel(logging.ERROR)
    with contextlib.redirect_stdout(io.StringIO()):
        server = viser.ViserServer(host="127.0.0.1", port=port, label="stiction", verbose=False)
    try:
        yield server
    finally:
        with contextlib.redirect_stdout(io.StringIO()):
            server.stop()


def make_page(plan: Plan) -> str:
    """One self-contained page: the recorded scene with a time bar."""
    return record(lambda server: Drawing(server, plan))


def record(make_drawing: Callable[[viser.ViserServer], Drawing]) -> str:
    """The page of a drawing."""
    with _server(port=0) as server:
        drawing = make_drawing(server)
        drawing.show(int(drawing.frames[0]))
        recording = server.get_scene_serializer()
        for index, knot in enumerate(drawing.frames):
            if index > 0:
                drawing.show(int(knot))
            recording.insert_sleep(float(drawing.times[index + 1] - drawing.times[index]))
        page = recording.as_html()
    return _with_overlay(page, drawing)


def _with_overlay(page: str, drawing: Drawing) -> str:
    """Adds a title, figures and a key to viser's page, and colours its time bar by kind of segment."""
    task = html.escape(drawing.plan.task)
    rows = "".join(f"<tr><td>{html.escape(k)}</td><td>{html.escape(v)}</td></tr>" for k, v in drawing.summary())

    def key(color: Color, text: str) -> str:
        return f'<span><i style="background:rgb{color}"></i>{text}</span>'

    keys = "".join(key(color, text) for color, text in drawing.keys())
    style = f"""<style>
#stiction {{ position: fixed; bottom: 56px; left: 14px; z-index: 2; pointer-events: none; color: #23262d; padding: 8px 12px;
  background: rgba(255, 255, 255, 0.8); border-radius: 8px;
  font: 13px/1.45 system-ui, "Segoe UI", "DejaVu Sans", sans-serif; }}
#stiction h1 {{ font-size: 19px; margin: 0 0 4px; font-weight: 650; }}
#stiction td {{ padding: 0 14px 0 0; }} #stiction td:first-child {{ color: #767c88; }}
#stiction p {{ margin: 8px 0 0; display: flex; gap: 14px; }}
#stiction i {{ display: inline-block; width: 10px; height: 10px; border-radius: 3px; margin-right: 5px; }}
.mantine-Slider-track::before {{ background: {drawing.timeline()} !important; }}
.mantine-Slider-bar {{ background: rgba(20, 22, 28, 0.42) !important; }}
</style>"""
    panel = f'<div id="stiction"><h1>{task}</h1><table>{rows}</table><p>{keys}</p></div>'
    page = page.replace("<title>Viser</title>", f"<title>{task} · stiction</title>", 1)
    head, rest = page.split("</head>", 1)
    body, end = rest.rsplit("</body>", 1)
    return f"{head}{style}</head>{body}{panel}</body>{end}"


def serve(plan: Plan, port: int) -> None:
    """Live view on localhost until interrupted."""
    with _server(port) as server:
        drawing = Drawing(server, plan)
        last = len(drawing.frames) - 1
        server.gui.add_markdown(
            f"## {plan.task}\n" + "\n".join(f"- {name}: {value}" for name, value in drawing.summary())
        )
        playing = server.gui.add_checkbox("play", True)
        speed = server.gui.add_slider("speed", 0.1, 4.0, 0.1, 1.0)
        slider = server.gui.add_slider("frame", 0, max(1, last), 1, 0)
        print(f"http://localhost:{server.get_port()}   (Ctrl-C ends)", flush=True)
        drawing.show(int(drawing.frames[0]))
        shown = 0
        while True:
            wait = 0.03
            if playing.value:
                following = 0 if shown >= last else shown + 1
                wait = float(drawing.times[shown + 1] - drawing.times[shown]) / speed.value
                slider.value = following
            index = min(int(slider.value), last)
            if index != shown:
                drawing.show(int(drawing.frames[index]))
                shown = index
            time.sleep(wait)
