"""Small pictures of tasks, drawn by MuJoCo without a screen: the start, and as ghosts the objects where the goal has them."""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from ._core import InvalidInput, Task, load_task
from ._extras import require
from ._files import write_whole
from ._jobs import Died, Failed, Local, Stopped, run_all
from .pages import _load, _viewer

SIZE = (320, 240)  # of a picture [px]
FINER = 3  # drawn so much larger, so that edges are smooth in the picture
QUALITY = 85  # of WebP: a picture takes some kB
GROWN = 1.01  # a ghost, so that it is not lost in what stays where it is
GHOST: tuple[tuple[int, int, int], ...] = ((38, 160, 92), (190, 235, 205), (10, 84, 44))  # colours of its patches, as those of an object
GHOST_OPACITY, INSIDE_OPACITY = 0.4, 0.28  # of a ghost beside its object, and of one that is in it
STAYS = 1e-4  # [m or rad] an object that the goal has where it starts needs no ghost
CLOSER = 0.9  # the camera, since a picture has no panel to leave room for
OBJECTS, LEAST = 2.2, 0.25  # what is shown: so many times the room of the objects, and at least this share of everything
ELEVATIONS = (25.0, 45.0, 65.0)  # of other sides that a picture may be taken from [°]
MUCH_MORE = 2.0  # of the logarithm of what is seen
FLAT_FOV = 0.3  # [rad] of the view of a plane problem, which is seen from above its plane
PLANE = 3.0  # half the side of a half-space, in radii of what is shown
LIMIT_S = 120.0  # wall time of one picture
SKY, FLOOR = (0.93, 0.95, 0.98), (0.86, 0.88, 0.91)


class NoRenderer(RuntimeError):
    """MuJoCo cannot draw on this machine; the message says why, and what to do."""


def start_renderer() -> ModuleType:
    """The module mujoco, which draws into memory. Raises NoRenderer."""
    if "mujoco" not in sys.modules and not os.environ.get("DISPLAY"):
        os.environ.setdefault("MUJOCO_GL", "egl")
    try:
        mujoco: Any = require("benchmark", "pictures of tasks", "mujoco")
        mujoco.Renderer(mujoco.MjModel.from_xml_string("<mujoco/>"), 8, 8).close()
    except Exception as error:  # of the driver, of PyOpenGL, or of the package
        reason = " ".join(str(error).split()) or type(error).__name__
        raise NoRenderer(f"MuJoCo draws nothing here with MUJOCO_GL={os.environ.get('MUJOCO_GL', '')} ({reason[:160]}); `pip install pyopengl` and the library libEGL or libOSMesa make it draw") from None
    return mujoco


@dataclass(frozen=True)
class Part:
    """A mesh in a picture."""

    vertices: np.ndarray  # (n, 3) in W [m]
    triangles: np.ndarray  # (m, 3)
    color: tuple[int, int, int]
    opacity: float = 1.0
    role: str = ""  # object: that the goal moves; goal: its ghost


@dataclass(frozen=True)
class Camera:
    """Where a picture is taken from; up is z."""

    look_at: np.ndarray
    away: np.ndarray  # from there to the camera
    fov: float  # of the height [rad]
    radius: float  # of what is shown [m]


@dataclass(frozen=True)
class Picture:
    """The start of a task, and ghosts of its goal."""

    parts: list[Part]
    planes: list[tuple[np.ndarray, np.ndarray]]  # positions and rotations of half-spaces
    camera: Camera


def picture_of(task: Task) -> Picture:
    bodies, links, camera = (_viewer(name) for name in ("bodies", "links", "camera"))
    shown = _load(task)
    drawn = bodies.body_meshes(shown, links.find(shown)[0])
    goals = poses_at_goal(task, shown)
    parts, places = [], []
    for part in drawn:
        body, pose = shown.bodies[part.body], bodies.pose_at(shown, part.body, 0)
        if body.kind != "object":
            color = bodies.FIXED if body.kind == "fixed" else bodies.ROBOT if body.moving is not None else bodies.ROBOT_BASE
            parts.append(Part(bodies.in_world(part.mesh[0], pose), part.mesh[1], color))
            continue
        moves = part.body in goals
        parts += painted(part.mesh, bodies.OBJECT, pose, role="object" if moves else "")
        if moves:
            there = goals[part.body]
            places += [bodies.in_world(part.mesh[0], pose), bodies.in_world(part.mesh[0], there)]
            inside = np.linalg.norm(places[-1].mean(axis=0) - places[-2].mean(axis=0)) < np.ptp(part.mesh[0], axis=0).min() / 2
            parts += painted(part.mesh, GHOST, there, GROWN, INSIDE_OPACITY if inside else GHOST_OPACITY, "goal")
    view = camera.choose_view(shown, drawn, np.zeros(1, dtype=int))
    return Picture(parts, planes_of(shown), nearer(view, np.concatenate(places) if places else shown.goal.position[None]))


def painted(mesh: Any, colors: Iterable[tuple[int, int, int]], pose: Any, grown: float = 1.0, opacity: float = 1.0, role: str = "") -> list[Part]:
    """A body in the colours of its patches, so that a turn is seen."""
    bodies, meshes = _viewer("bodies"), _viewer("meshes")
    middle = mesh[0].mean(axis=0)
    out = []
    for patch, color in enumerate(colors):
        vertices, triangles = meshes.compact(mesh, mesh[2] == patch)
        if len(triangles):
            out.append(Part(bodies.in_world(middle + grown * (vertices - middle), pose), triangles, color, opacity, role))
    return out


def nearer(view: Any, points: np.ndarray) -> Camera:
    """The camera of a page, nearer to the objects where they are small beside everything else."""
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    room = float(np.linalg.norm(points - middle, axis=1).max())
    share = float(np.clip(OBJECTS * room / view.radius, LEAST, 1))
    look_at = share * view.look_at + (1 - share) * middle
    return Camera(look_at, CLOSER * share * (view.position - view.look_at), float(view.fov), share * view.radius)


def poses_at_goal(task: Task, shown: Any) -> dict[int, Any]:
    """Poses of the objects that the goal moves, by numbers of bodies."""
    bodies = _viewer("bodies")
    q = task.q_start.copy()
    q[: len(task.q_goal)] = task.q_goal
    try:
        there = _load(task.with_(start=q))
    except InvalidInput:  # the goal of its object is known in any case
        return {shown.goal_body: shown.goal}
    out = {}
    for number, body in enumerate(shown.bodies):
        if body.kind == "object" and body.moving is not None:
            before, after = (bodies.pose_at(plan, number, 0) for plan in (shown, there))
            moved = max(np.abs(before.position - after.position).max(), np.abs(before.rotation() - after.rotation()).max())
            if moved > STAYS:
                out[number] = after
    return out


def planes_of(shown: Any) -> list[tuple[np.ndarray, np.ndarray]]:
    """Positions and rotations of half-spaces, which have no mesh."""
    bodies = _viewer("bodies")
    out = []
    for geometry in shown.geometries:
        if geometry.shape["type"] == "half_space":
            pose = bodies.pose_at(shown, geometry.body, 0)
            out.append((bodies.in_world(geometry.X_BG.position[None], pose)[0], pose.rotation() @ geometry.X_BG.rotation()))
    return out


def draw(mujoco: Any, picture: Picture, size: tuple[int, int] = SIZE) -> np.ndarray:
    """Pixels (height, width, 3)."""
    from PIL import Image

    width, height = FINER * size[0], FINER * size[1]
    model = make_model(mujoco, picture, width, height)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    away = from_where(mujoco, model, data, picture)
    with mujoco.Renderer(model, height, width) as renderer:
        renderer.update_scene(data, to_camera(mujoco, picture.camera.look_at, away))
        return np.asarray(Image.fromarray(renderer.render()).resize(size, Image.Resampling.LANCZOS))


def to_camera(mujoco: Any, look_at: np.ndarray, away: np.ndarray) -> Any:
    distance = float(np.linalg.norm(away))
    camera = mujoco.MjvCamera()
    camera.lookat, camera.distance = look_at, distance
    camera.azimuth = float(np.degrees(np.arctan2(-away[1], -away[0])))
    camera.elevation = -float(np.degrees(np.arcsin(away[2] / distance)))
    return camera


def from_where(mujoco: Any, model: Any, data: Any, picture: Picture) -> np.ndarray:
    """From the view of a page, unless much more of the objects and of their goals is seen from another side."""
    away = picture.camera.away
    if picture.camera.fov < FLAT_FOV:
        return away
    distance = np.linalg.norm(away)
    sides = [away, *(distance * np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)]) for e in np.radians(ELEVATIONS) for a in np.arange(0, 2 * np.pi, np.pi / 6))]
    groups = [[i for i, part in enumerate(picture.parts) if part.role == role] for role in ("object", "goal")]
    scores = []
    with mujoco.Renderer(model, 60, 80) as renderer:
        renderer.enable_segmentation_rendering()
        for side in sides:
            renderer.update_scene(data, to_camera(mujoco, picture.camera.look_at, side))
            seen = renderer.render()[:, :, 0]
            scores.append(sum(np.log1p(np.isin(seen, group).sum()) for group in groups))
    best = int(np.argmax(scores))
    return sides[best] if scores[best] > scores[0] + MUCH_MORE else away


def make_model(mujoco: Any, picture: Picture, width: int, height: int) -> Any:
    """Meshes that stand still, with light and sky."""
    camera = picture.camera
    spec = mujoco.MjSpec()
    visual = spec.visual
    visual.global_.offwidth, visual.global_.offheight, visual.global_.fovy = width, height, float(np.degrees(camera.fov))
    visual.headlight.ambient, visual.headlight.diffuse, visual.headlight.specular = [0.38] * 3, [0.27] * 3, [0.0] * 3
    visual.quality.shadowsize, visual.quality.offsamples = 4096, 0
    visual.map.znear, visual.map.zfar, visual.map.shadowclip = 0.005, 100.0, 4.0  # of extent
    spec.stat.center, spec.stat.extent = camera.look_at, 2 * camera.radius
    spec.add_texture(name="sky", type=mujoco.mjtTexture.mjTEXTURE_SKYBOX, builtin=mujoco.mjtBuiltin.mjBUILTIN_FLAT, rgb1=SKY, rgb2=SKY, width=16, height=16)
    world = spec.worldbody
    lamp = np.array([0.3, -0.2, 1.0])
    world.add_light(pos=camera.look_at + 4 * camera.radius * lamp, dir=-lamp, type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL, diffuse=[0.4] * 3, specular=[0.05] * 3, castshadow=True)
    for number, part in enumerate(picture.parts):
        mesh = spec.add_mesh(name=f"part{number}", uservert=part.vertices.astype(float).ravel(), userface=part.triangles.astype(int).ravel())
        mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL  # of whatever is closed or not
        world.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=mesh.name, rgba=[*(np.array(part.color) / 255), part.opacity], contype=0, conaffinity=0)
    for position, rotation in picture.planes:
        quat = np.empty(4)
        mujoco.mju_mat2Quat(quat, np.ascontiguousarray(rotation).ravel())
        normal = rotation[:, 2]
        middle = camera.look_at - normal * (normal @ (camera.look_at - position))  # only what is near is drawn
        side = PLANE * camera.radius
        world.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, pos=middle, quat=quat, size=[side, side, 0.01], rgba=[*FLOOR, 1], contype=0, conaffinity=0)
    return spec.compile()


def draw_tasks(tasks: Path, folder: Path, names: Iterable[str], processes: int | None = None) -> str:
    """Draws the tasks of files, each in a process of its own; those that were drawn and are the same are left as they are. Returns what went wrong, in a sentence."""
    made_of = {name: hashlib.sha256((tasks / f"{name}.yaml").read_bytes()).hexdigest() for name in names}
    notes = {name: tasks / f"{name}.drawn" for name in made_of}
    todo = [name for name, sha in made_of.items() if not ((folder / f"{name}.webp").exists() and notes[name].exists() and notes[name].read_text(encoding="utf-8") == sha)]
    faults = []
    for name, _, result in run_all(Local(processes, LIMIT_S), DrawTask(str(tasks), str(folder)), todo) if todo else ():
        if isinstance(result, Failed) and result.message.startswith(f"{NoRenderer.__name__}: "):
            return result.message.removeprefix(f"{NoRenderer.__name__}: ")
        if isinstance(result, (Failed, Died, Stopped)) or result:
            faults.append(f"{name} ({result if isinstance(result, str) else result.message})")
        else:
            notes[name].write_text(made_of[name], encoding="utf-8")
    return f"{len(faults)} of {len(made_of)} tasks could not be drawn, the first one is {faults[0]}" if faults else ""


@dataclass(frozen=True)
class DrawTask:
    """Draws the task of a file into a folder; called with its name. Returns why it could not, or nothing."""

    tasks: str  # folder of task files
    folder: str

    def __call__(self, name: str) -> str:
        mujoco = start_renderer()
        try:
            task = load_task(Path(self.tasks) / f"{name}.yaml")
        except InvalidInput as error:
            return str(error)
        save(draw(mujoco, picture_of(task)), Path(self.folder) / f"{name}.webp")
        return ""


def save(pixels: np.ndarray, file: Path) -> None:
    from PIL import Image

    write_whole(file, lambda to: Image.fromarray(pixels).save(to, "WEBP", quality=QUALITY, method=6))
