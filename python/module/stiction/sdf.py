"""Scenes of Gazebo as MJCF: the parser of Drake reads an SDF with its frames and includes (docs/scenes.md).

    python -m stiction sdf scene.sdf scene.xml   # `stiction import scene.sdf -o task.yaml` does this first
"""

from __future__ import annotations

import argparse
import logging
import math
import os
import sys
import tempfile
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from . import _command
from ._core import InvalidInput
from ._extras import require
from ._sdf_files import DEEPEST as DEEPEST
from ._sdf_files import LEFT_OUT as LEFT_OUT
from ._sdf_files import Files, folders_of_models, load_mesh
from ._sdf_files import is_deep as is_deep

PURPOSE = "SDF files"
MESHES = (".obj", ".stl")  # that MuJoCo reads
MADE = b"<!-- Made by stiction of "  # how each MJCF begins; such a file may be written anew
LEAST_ARM = 3e-5  # radius of gyration of a link that has none [m]; MuJoCo takes no inertia of 0
CARRIED = {"revolute": "hinge", "prismatic": "slide", "ball_rpy": "ball"}
UNIVERSAL = "universal"


def convert_sdf(file: str | os.PathLike[str], out: str | os.PathLike[str], *, package_dirs: Iterable[str | os.PathLike[str]] = ()) -> list[str]:
    """Converts an SDF file to MJCF: links, joints with limits, collision shapes and inertias; frames become sites.

    A joint gets a motor if it states an effort that is finite and not 0, or if a <plugin> names it as <joint_name>. The name "model://NAME" is
    a folder NAME with a model.config, which is searched in package_dirs, in the folder of the file, and in the folders above it.

      file: SDF file.
      out: MJCF file to write.
      package_dirs: folders with packages.

    Returns remarks on elements that were converted differently from the file, one sentence each. Raises InvalidInput: the file cannot be read,
    or has joints that a scene cannot have; MissingExtra: Drake is not installed.
    """
    target = Path(out)
    text, notes = make_mjcf(Path(file), target, package_dirs=package_dirs)
    target.write_bytes(text)
    return notes


def make_mjcf(source: Path, target: Path | None = None, *, package_dirs: Iterable[str | os.PathLike[str]] = ()) -> tuple[bytes, list[str]]:
    """The MJCF, and the notes of convert_sdf. Meshes that MuJoCo does not read are written beside `target`; without one they stand in the MJCF.

    Raises InvalidInput, MissingExtra.
    """
    with tempfile.TemporaryDirectory() as folder, _warnings() as said:
        files = Files(folders_of_models(source, [Path(place) for place in package_dirs]), Path(folder))
        main = files.add(source)
        plant, inspector = _load(source, main, files)
        for line in said:
            if "Using default value" in line:  # for a size that no shape can have
                raise InvalidInput(f"{source}: sdf: got '{files.name(line)}', expected numbers > 0")
        converted = _Conversion(source, target, plant, inspector, files)
    ET.indent(converted.root)
    text = MADE + source.name.replace("--", "- -").encode() + b" -->\n" + ET.tostring(converted.root, encoding="utf-8") + b"\n"
    return text, converted.notes + files.notes() + [files.name(line) for line in dict.fromkeys(said)]


def is_sdf(file: str | os.PathLike[str]) -> bool:
    """By its root element; of a file that has none, by its name."""
    try:
        with Path(file).open("rb") as text:
            for _, root in ET.iterparse(text, events=("start",)):
                return str(root.tag) == "sdf"
    except (ET.ParseError, ValueError, LookupError, OSError):  # no XML, an encoding that is not known, no file
        pass
    return Path(file).suffix.lower() == ".sdf"


def made_of_sdf(mjcf: Path) -> bool:
    """It was written by convert_sdf."""
    with mjcf.open("rb") as text:
        return text.read(len(MADE)) == MADE


@contextmanager
def _warnings() -> Iterator[list[str]]:
    """What Drake logs meanwhile."""
    said: list[str] = []

    class Handler(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            said.append(" ".join(record.getMessage().split()))

    logger, handler = logging.getLogger("drake"), Handler(logging.WARNING)
    others, passes = logger.handlers[:], logger.propagate
    logger.handlers, logger.propagate = [handler], False
    try:
        yield said
    finally:
        logger.handlers, logger.propagate = others, passes


def check_drake(purpose: str = PURPOSE) -> None:
    """Raises MissingExtra: Drake is not installed."""
    require("sdf", purpose, "pydrake")


def _load(source: Path, main: Path, files: Files) -> tuple[Any, Any]:
    check_drake()
    plants, parsing = require("sdf", PURPOSE, "pydrake.multibody.plant"), require("sdf", PURPOSE, "pydrake.multibody.parsing")
    geometry = require("sdf", PURPOSE, "pydrake.geometry")
    plant = plants.MultibodyPlant(0.001)  # a step in time, without which Drake takes no joints that follow others
    graph = geometry.SceneGraph()
    plant.RegisterAsSourceForSceneGraph(graph)
    try:
        parsing.Parser(plant).AddModels(str(main))
        plant.Finalize()
    except (RuntimeError, ValueError) as error:
        raise InvalidInput(f"{source}: sdf: got '{files.name(' '.join(str(error).split()))}', expected a file that Drake's parser takes") from None
    return plant, graph.model_inspector()


def _numbers(values: Iterable[float]) -> str:
    return " ".join(repr(float(value) + 0.0) for value in values)


def _place(element: ET.Element, pose: Any) -> None:
    """The pose of a body, a geom or a site in what carries it."""
    if not np.array_equal(pose.translation(), np.zeros(3)):
        element.set("pos", _numbers(pose.translation()))
    wxyz = pose.rotation().ToQuaternion().wxyz()
    if not np.allclose(wxyz[1:], 0, atol=1e-15):
        element.set("quat", _numbers(wxyz))


class _Conversion:
    """One plant as an MJCF."""

    def __init__(self, source: Path, target: Path | None, plant: Any, inspector: Any, files: Files) -> None:
        texts = list(files.texts.values())
        self.files = files
        self.source, self.target, self.plant, self.inspector = source, target, plant, inspector
        self.tree = require("sdf", PURPOSE, "pydrake.multibody.tree")
        self.notes: list[str] = []
        self.root = ET.Element("mujoco", model=source.stem)
        ET.SubElement(self.root, "compiler", angle="radian", balanceinertia="true", inertiafromgeom="false", autolimits="true")
        gravity = texts[0].findtext("world/gravity", "0 0 -9.8")
        if len(gravity.split()) != 3:
            raise InvalidInput(f"{source}: gravity: got '{gravity}', expected three numbers")
        ET.SubElement(self.root, "option", gravity=gravity)
        self.assets = ET.SubElement(self.root, "asset")
        self.meshes: dict[tuple[str, tuple[float, ...]], str] = {}
        self.names: dict[Any, str] = {}
        self.taken: dict[str, set[str]] = {}
        self.actuators = {plant.get_joint_actuator(i).joint().index(): plant.get_joint_actuator(i) for i in plant.GetJointActuatorIndices()}
        self.named_by_plugins = {(name.text or "").strip() for text in texts for plugin in text.iter("plugin") for name in plugin.iter("joint_name")}
        self.motors: list[tuple[str, float]] = []
        self.joints = [plant.get_joint(i) for i in plant.GetJointIndices()]
        self.frames_of_joints = {int(frame.index()) for joint in self.joints for frame in (joint.frame_on_parent(), joint.frame_on_child())}
        self._name_bodies()
        self._add_bodies(ET.SubElement(self.root, "worldbody"))
        self._add_mimics(texts)
        if empty := [link.get("name", "") for text in texts for link in text.iter("link") if link.find("inertial") is None]:
            self.notes.append(f"links without <inertial> weigh 1 kg with moments of 1 kg·m², as SDF has it: {', '.join(empty)}")
        motors = ET.SubElement(self.root, "actuator")
        for joint, effort in self.motors:
            motor = ET.SubElement(motors, "motor", joint=joint)
            if math.isfinite(effort):
                motor.set("forcerange", _numbers([-effort, effort]))
        for section in list(self.root):
            if section.tag in ("asset", "actuator", "equality") and len(section) == 0:
                self.root.remove(section)

    def _name(self, kind: str, model: Any, name: str) -> str:
        """Free of the marks that mean something in a scene; with that of its model in front where it stands there twice."""
        taken = self.taken.setdefault(kind, set())
        plain = name.replace("::", ".").replace("/", "_").replace(" ", "_")
        if plain in taken:
            plain = f"{self.plant.GetModelInstanceName(model)}.{name}".replace("::", ".").replace("/", "_").replace(" ", "_")
        while plain in taken:
            plain += "_"
        taken.add(plain)
        return plain

    def _bodies(self) -> list[Any]:
        return [self.plant.get_body(self.tree.BodyIndex(i)) for i in range(1, self.plant.num_bodies())]  # 0 is the world

    def _name_bodies(self) -> None:
        """A link that is all of its model has the model's name."""
        counts: dict[Any, int] = {}
        for body in self._bodies():
            counts[body.model_instance()] = counts.get(body.model_instance(), 0) + 1
        for body in self._bodies():
            alone = counts[body.model_instance()] == 1
            name = self.plant.GetModelInstanceName(body.model_instance()) if alone else body.name()
            self.names[body.index()] = self._name("body", body.model_instance(), name)

    def _add_bodies(self, world: ET.Element) -> None:
        """Along the joints, from the world outwards; a joint may be passed from its child to its parent."""
        plant = self.plant
        context = plant.CreateDefaultContext()
        elements = {plant.world_body().index(): world}
        self._fill(world, plant.world_body())
        open_joints = list(self.joints)
        while open_joints:
            ready = [j for j in open_joints if j.parent_body().index() in elements or j.child_body().index() in elements]
            joint = ready[0]
            open_joints.remove(joint)
            forward = joint.parent_body().index() in elements
            near, far = (joint.parent_body(), joint.child_body()) if forward else (joint.child_body(), joint.parent_body())
            elements[far.index()] = self._add_body(elements[near.index()], joint, near, far, forward, context)

    def _add_body(self, parent: ET.Element, joint: Any, near: Any, far: Any, forward: bool, context: Any) -> ET.Element:
        """The pose of a body is that at q = 0 of its joint; that of a free one is its own."""
        from pydrake.math import RigidTransform

        X_PF = (joint.frame_on_parent() if forward else joint.frame_on_child()).GetFixedPoseInBodyFrame()
        X_CM = (joint.frame_on_child() if forward else joint.frame_on_parent()).GetFixedPoseInBodyFrame()
        element = ET.SubElement(parent, "body", name=self.names[far.index()])
        kind = joint.type_name()
        if kind.endswith("floating"):
            _place(element, self.plant.CalcRelativeTransform(context, near.body_frame(), far.body_frame()))
            if parent.tag != "worldbody":
                raise InvalidInput(f"{self.source}: link '{far.name()}': got a free body on a link, expected one in the world")
            ET.SubElement(element, "freejoint")
        else:
            X_FM = RigidTransform(joint.X_FM()) if kind == "weld" else RigidTransform()
            _place(element, X_PF.multiply(X_FM if forward else X_FM.inverse()).multiply(X_CM.inverse()))
            if kind != "weld":
                self._add_joint(element, joint, X_CM, 1.0 if forward else -1.0)
        self._fill(element, far)
        return element

    def _add_joint(self, element: ET.Element, joint: Any, X_CM: Any, sign: float) -> None:
        kind = joint.type_name()
        name = self._name("joint", joint.model_instance(), joint.name())
        if kind == UNIVERSAL:  # about x of the one frame, then about y of the other
            axes = [("x", np.array([1.0, 0, 0])), ("y", np.array([0, 1.0, 0]))]
            for letter, axis in axes if sign > 0 else axes[::-1]:
                made = ET.SubElement(element, "joint", name=f"{name}_{letter}", type="hinge", axis=_numbers(sign * X_CM.rotation().multiply(axis)), pos=_numbers(X_CM.translation()))
                made.set("damping", _numbers(joint.default_damping_vector()[:1]))
            return
        if kind not in CARRIED:
            raise InvalidInput(f"{self.source}: joint '{joint.name()}': got a joint of type '{kind}', expected revolute, continuous, prismatic, ball, universal or fixed")
        made = ET.SubElement(element, "joint", name=name, type=CARRIED[kind], pos=_numbers(X_CM.translation()))
        if kind == "ball_rpy":
            made.set("damping", _numbers(joint.default_damping_vector()[:1]))
            return
        axis = joint.revolute_axis() if kind == "revolute" else joint.translation_axis()
        made.set("axis", _numbers(sign * X_CM.rotation().multiply(axis)))
        lower, upper = float(joint.position_lower_limits()[0]), float(joint.position_upper_limits()[0])
        if math.isfinite(lower) or math.isfinite(upper):
            made.set("range", _numbers(np.clip([lower, upper], -1e10, 1e10)))  # a side without a limit, which the reader knows by its size
        if joint.default_damping_vector()[0] > 0:
            made.set("damping", _numbers(joint.default_damping_vector()))
        self._add_spring(made, joint)
        if (friction := self._friction_of(joint.name())) > 0:
            made.set("frictionloss", _numbers([friction]))
        actuator = self.actuators.get(joint.index())
        effort = abs(float(actuator.effort_limit())) if actuator is not None else 0.0
        if (math.isfinite(effort) and effort > 0) or joint.name() in self.named_by_plugins:
            self.motors.append((name, effort if effort > 0 else math.inf))

    def _friction_of(self, joint: str) -> float:
        """Dry friction, which Drake does not read: the largest of the joints of that name."""
        found = (element.findtext("axis/dynamics/friction") for text in self.files.texts.values() for element in text.iter("joint") if element.get("name") == joint)
        return max((float(friction) for friction in found if friction is not None), default=0.0)

    def _add_spring(self, made: ET.Element, joint: Any) -> None:
        for i in range(self.plant.num_force_elements()):
            spring = self.plant.get_force_element(self.tree.ForceElementIndex(i))
            if type(spring).__name__.split("_")[0] not in ("RevoluteSpring", "PrismaticSpring") or spring.joint().index() != joint.index():
                continue
            rest = spring.default_nominal_angle() if hasattr(spring, "default_nominal_angle") else spring.nominal_position()
            stiffness = spring.default_stiffness() if hasattr(spring, "default_stiffness") else spring.stiffness()
            made.set("stiffness", _numbers([stiffness]))
            made.set("springref", _numbers([rest]))

    # ---- what a body has ----

    def _fill(self, element: ET.Element, body: Any) -> None:
        if element.tag == "body":
            self._add_inertia(element, body)
        for geometry in self.plant.GetCollisionGeometriesForBody(body):
            self._add_geom(element, geometry)
        for i in range(self.plant.num_frames()):
            frame = self.plant.get_frame(self.tree.FrameIndex(i))
            if frame.body().index() == body.index() and self._is_of_the_user(frame):
                site = ET.SubElement(element, "site", name=self._name("site", frame.model_instance(), frame.name()))
                _place(site, frame.GetFixedPoseInBodyFrame())

    def _is_of_the_user(self, frame: Any) -> bool:
        name = frame.name()
        if frame.is_ephemeral():  # Drake's own
            return False
        return bool(name) and "__" not in name and name not in ("world", frame.body().name()) and int(frame.index()) not in self.frames_of_joints

    def _add_inertia(self, element: ET.Element, body: Any) -> None:
        mass = float(body.default_mass())
        if not (math.isfinite(mass) and mass > 0):
            return
        central = body.default_spatial_inertia().Shift(body.default_com()).CalcRotationalInertia().CopyToFullMatrix3()
        moments, axes = np.linalg.eigh(central)
        least = mass * LEAST_ARM**2
        if moments[0] < least:
            self.notes.append(f"link '{body.name()}' has moments of inertia of {least:.3g} kg·m² where its file has less")
            central = (axes * np.maximum(moments, least)) @ axes.T
        terms = central[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
        ET.SubElement(element, "inertial", pos=_numbers(body.default_com()), mass=_numbers([mass]), fullinertia=_numbers(terms))

    def _add_geom(self, element: ET.Element, geometry: Any) -> None:
        shape = self.inspector.GetShape(geometry)
        kind = type(shape).__name__
        geom = ET.SubElement(element, "geom")
        sizes: dict[str, Any] = {
            "Box": lambda: ("box", np.asarray(shape.size()) / 2),
            "Sphere": lambda: ("sphere", [shape.radius()]),
            "Cylinder": lambda: ("cylinder", [shape.radius(), shape.length() / 2]),
            "Capsule": lambda: ("capsule", [shape.radius(), shape.length() / 2]),
            "Ellipsoid": lambda: ("ellipsoid", [shape.a(), shape.b(), shape.c()]),
            "HalfSpace": lambda: ("plane", [0, 0, 1]),
        }
        if kind in sizes:
            type_, size = sizes[kind]()
            geom.set("type", type_)
            geom.set("size", _numbers(size))
        elif kind in ("Mesh", "Convex"):
            geom.set("type", "mesh")
            geom.set("mesh", self._mesh(shape))
        else:
            raise InvalidInput(f"{self.source}: collision '{self.inspector.GetName(geometry)}': got a shape {kind}, expected box, sphere, cylinder, capsule, ellipsoid, plane or mesh")
        _place(geom, self.inspector.GetPoseInFrame(geometry))
        material = self.inspector.GetProximityProperties(geometry)
        if material is not None and material.HasProperty("material", "coulomb_friction"):
            friction = material.GetProperty("material", "coulomb_friction").static_friction()
            geom.set("friction", _numbers([friction, 0.005, 0.0001]))

    def _mesh(self, shape: Any) -> str:
        path = self.files.meshes[str(shape.source().path())]
        scale = tuple(float(s) for s in np.ravel(shape.scale3()))
        key = (str(path), scale)
        if key in self.meshes:
            return self.meshes[key]
        name = self._name("mesh", None, path.stem)
        mesh = ET.SubElement(self.assets, "mesh", name=name)
        if path.suffix.lower() not in MESHES and self.target is None:
            loaded = load_mesh(path)
            mesh.set("vertex", _numbers(loaded.vertices.ravel()))
            mesh.set("face", " ".join(str(int(corner)) for corner in loaded.faces.ravel()))
        else:
            mesh.set("file", self._mesh_file(path, name))
        if scale != (1.0, 1.0, 1.0):
            mesh.set("scale", _numbers(scale))
        self.meshes[key] = name
        return name

    def _mesh_file(self, path: Path, name: str) -> str:
        """Its name in the MJCF: a file below the folder of that moves with it. Meshes of other formats are written beside the MJCF."""
        if self.target is None:
            return str(path)
        home = self.target.resolve().parent
        if path.suffix.lower() not in MESHES:
            out = home / f"{self.target.stem}_{name}.obj"
            load_mesh(path).export(out)
            path = out
        return path.resolve().relative_to(home).as_posix() if path.resolve().is_relative_to(home) else str(path)

    def _add_mimics(self, texts: list[ET.Element]) -> None:
        """q = multiplier (q_leader − reference) + offset."""
        equality = ET.SubElement(self.root, "equality")
        for joint in (joint for text in texts for joint in text.iter("joint")):
            for mimic in joint.findall("axis/mimic"):
                value = {tag: float(mimic.findtext(tag) or 0) for tag in ("multiplier", "offset", "reference")}
                names = (joint.get("name", ""), mimic.get("joint", ""))
                unknown = [name for name in names if name not in self.taken.get("joint", set())]
                if unknown:
                    self.notes.append(f"joint '{names[0]}' follows nothing here: the file has '{unknown[0]}' in a model of its own")
                    continue
                offset = value["offset"] - value["multiplier"] * value["reference"]
                ET.SubElement(equality, "joint", joint1=names[0], joint2=names[1], polycoef=_numbers([offset, value["multiplier"], 0, 0, 0]))


def main(words: Sequence[str]) -> int:
    """What `stiction import FILE.sdf -o TASK.yaml` does first."""
    parser = argparse.ArgumentParser(prog="python -m stiction sdf", description="Converts an SDF file to MJCF.", allow_abbrev=False)
    parser.add_argument("file", help="SDF file")
    parser.add_argument("out", help="MJCF file to write")
    parser.add_argument("--packages", action="append", default=[], metavar="FOLDER", help="folder that contains the packages which model:// and package:// name")
    arguments = parser.parse_args(words)
    for note in convert_sdf(arguments.file, arguments.out, package_dirs=arguments.packages):
        _command.say(f"note: {note}", sys.stderr)
    return _command.DONE
