"""A scene in Drake, discretised with its SAP solver: the second-order simulation of the thesis.

Drake is needed by no other part of the project, so it is optional: `make experiments` puts it into .venv, and without it the
experiments show MuJoCo alone. The plant is built from the scene file that the library reads; there is no second model file.
"""

from __future__ import annotations

import importlib.util
import itertools
import logging
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import stiction as st
import yaml

MISSING = "Drake is not installed; `make experiments` installs it"
CORNER_RADIUS = 1e-5  # of the balls at the corners of a box [m]


def is_available() -> bool:
    return importlib.util.find_spec("pydrake") is not None


@dataclass
class Motion:
    times: np.ndarray  # of the samples [s]
    q: np.ndarray  # (n_q, samples) in the layout of the library
    steps: int


class DrakePlant:
    """Robots of URDF files on joint springs, whose impedance Drake treats implicitly; free objects of boxes and balls; fixed half-spaces.

    Weight acts on objects only, a pair has the friction 2 a b / (a + b), and only pairs of bodies that the library knows may touch: as there.
    """

    def __init__(self, scene: Path, timestep: float, damping: Sequence[float], near_rigid: float = 1.0) -> None:
        """`damping` of the joints in the order of u [N s/m or N m s/rad]; `near_rigid` is β of Castro et al. 2021 (Drake's default)."""
        from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, DiscreteContactApproximation, MultibodyPlant
        from pydrake.systems.framework import DiagramBuilder

        self.library = st.load_model(scene)
        whole = yaml.safe_load(scene.read_text(encoding="utf-8"))
        self._scene: dict[str, Any] = whole.get("scene", whole)
        self._folder = scene.parent
        self._timestep = timestep
        if len(damping) != self.library.n_a:
            raise ValueError(f"damping has {len(damping)} values, expected {self.library.n_a}")

        logging.getLogger("drake").setLevel(logging.ERROR)  # half-spaces cannot meet deformable bodies, it warns
        builder = DiagramBuilder()
        self._scene_graph = None  # where nothing can touch, Drake need not look
        if self.library.pairs:
            self._plant, self._scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=timestep)
        else:
            self._plant = builder.AddSystem(MultibodyPlant(time_step=timestep))
        self._plant.set_discrete_contact_approximation(DiscreteContactApproximation.kSap)
        self._plant.set_sap_near_rigid_threshold(near_rigid)
        self._plant.mutable_gravity_field().set_gravity_vector(self.library.scene.gravity)
        self._bodies: dict[str, Any] = {}  # by the library's name
        for robot in self._scene["robots"]:
            self._add_robot(robot, damping)
        for item in self._scene.get("objects", []):
            self._add_object(item)
        for item in self._scene.get("fixed", []):
            self._bodies[item["name"]] = self._plant.world_body()
            self._add_shapes(self._plant.world_body(), item)
        self._plant.Finalize()
        if self._scene_graph is not None:
            self._exclude_other_pairs()
        self._diagram = builder.Build()

    # ---- the scene

    def _add_robot(self, robot: dict[str, Any], damping: Sequence[float]) -> None:
        from pydrake.math import RigidTransform
        from pydrake.multibody.parsing import Parser
        from pydrake.multibody.tree import PdControllerGains

        if "urdf" not in robot or "base" in robot or "link_friction" in robot:
            raise ValueError(f"robot '{robot['name']}': only a URDF at the origin of the world, with one friction")
        plant, name = self._plant, robot["name"]
        parser = Parser(plant)
        parser.SetAutoRenaming(True)
        text = (self._folder / robot["urdf"]).read_text(encoding="utf-8")
        # Drake reads no infinite limit; one that is missing is infinite.
        (instance,) = parser.AddModelsFromString(re.sub(r'\b(lower|upper)="[-+]?inf"', "", text), "urdf")
        frames = [plant.get_body(i) for i in plant.GetBodyIndices(instance)]
        children = {plant.get_joint(i).child_body().index() for i in plant.GetJointIndices(instance)}
        (root,) = [body for body in frames if body.index() not in children]
        plant.WeldFrames(plant.world_frame(), root.body_frame(), RigidTransform())
        plant.set_gravity_enabled(instance, False)
        for body in frames:
            self._bodies[f"{name}/{body.name()}"] = body
            if self._scene_graph is not None:
                self._set_friction(body, robot.get("friction", 1.0))
        for i, joint_name in enumerate(self.library.joint_names):
            owner, _, joint = joint_name.partition("/")
            if owner == name:
                actuator = plant.AddJointActuator(joint, plant.GetJointByName(joint, instance))
                actuator.set_controller_gains(PdControllerGains(p=float(self.library.stiffness[i]), d=float(damping[i])))

    def _set_friction(self, body: Any, friction: float) -> None:
        from pydrake.geometry import ProximityProperties, RoleAssign

        source = self._plant.get_source_id()
        for geometry in self._plant.GetCollisionGeometriesForBody(body):
            properties = ProximityProperties(self._scene_graph.model_inspector().GetProximityProperties(geometry))
            properties.UpdateProperty("material", "coulomb_friction", coulomb(friction))
            self._scene_graph.AssignRole(source, geometry, properties, RoleAssign.kReplace)

    def _add_object(self, item: dict[str, Any]) -> None:
        from pydrake.multibody.tree import SpatialInertia, default_model_instance

        if item["joint"] != "free" or len(item["shapes"]) != 1 or "inertia" in item:
            raise ValueError(f"object '{item['name']}': only a free object of one shape, without an inertia of its own")
        (shape,) = item["shapes"]
        if "box" in shape:
            inertia = SpatialInertia.SolidBoxWithMass(item["mass"], *shape["box"]["size"])
        else:
            inertia = SpatialInertia.SolidSphereWithMass(item["mass"], shape["sphere"]["radius"])
        body = self._bodies[item["name"]] = self._plant.AddRigidBody(item["name"], default_model_instance(), inertia)
        self._add_shapes(body, item)

    def _add_shapes(self, body: Any, item: dict[str, Any]) -> None:
        """Point contact has one point per pair of shapes, so a box gets a ball at every corner, as in the thesis.

        Balls stand out by their radius: what touches is a contact from the first step on, or it would fall by g h² in that step.
        """
        from pydrake.geometry import Box, HalfSpace, Sphere
        from pydrake.math import RigidTransform

        for k, shape in enumerate(item["shapes"]):
            if "pose" in shape:
                raise ValueError(f"'{item['name']}': only shapes at the origin of their body")
            name = f"{item['name']}_{shape.get('name', k)}"
            friction = coulomb(shape.get("friction", item.get("friction", 1.0)))

            def add(what: Any, suffix: str = "", position: Sequence[float] = (0, 0, 0), name: str = name, friction: Any = friction) -> None:
                self._plant.RegisterCollisionGeometry(body, RigidTransform(np.array(position)), what, name + suffix, friction)

            if "half_space" in shape:
                add(HalfSpace())
            elif "sphere" in shape:
                add(Sphere(shape["sphere"]["radius"]))
            elif "box" in shape:
                size = np.array(shape["box"]["size"])
                add(Box(*size))
                for signs in itertools.product((-1, 1), repeat=3):
                    add(Sphere(CORNER_RADIUS), f"_corner{signs}", np.array(signs) * size / 2)
            else:
                raise ValueError(f"'{item['name']}': only boxes, spheres and half-spaces")

    def _exclude_other_pairs(self) -> None:
        from pydrake.geometry import CollisionFilterDeclaration, GeometrySet

        library = self.library
        body_of = [library.bodies[g.body].name for g in library.geometries]
        touching = {frozenset((body_of[p.geometry_a], body_of[p.geometry_b])) for p in library.pairs}
        sets = {name: self._plant.GetCollisionGeometriesForBody(body) for name, body in self._bodies.items()}
        declaration = CollisionFilterDeclaration()
        for a, b in itertools.combinations([name for name, found in sets.items() if found], 2):
            if frozenset((a, b)) not in touching:
                declaration.ExcludeBetween(GeometrySet(sets[a]), GeometrySet(sets[b]))
        self._scene_graph.collision_filter_manager().Apply(declaration)

    # ---- motion

    def simulate(self, q0: np.ndarray, knots: np.ndarray, commands: np.ndarray, record_interval: float, ahead: float = 1.0) -> Motion:
        """Commands (n_a, knots), linear between knots [s], from rest at q0 to the last knot.

        The step from t to t + h has the command of t + ahead · h: 1 is that of its end, as in a quasi-static step.
        """
        from pydrake.systems.analysis import Simulator

        plant, h = self._plant, self._timestep
        steps = round(knots[-1] / h)
        every = max(round(record_interval / h), 1)
        grid = h * (np.arange(steps) + ahead)
        # No velocity is commanded: D acts on the whole of it.
        targets = np.zeros((steps, 2 * self.library.n_a))
        targets[:, : self.library.n_a] = np.array([np.interp(grid, knots, row) for row in commands[self._actuators()]]).T

        simulator = Simulator(self._diagram)
        context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
        (instance,) = {plant.get_joint_actuator(i).model_instance() for i in plant.GetJointActuatorIndices()}
        target = plant.get_desired_state_input_port(instance)
        plant.SetPositions(context, self._to_drake(q0))
        times, positions = [0.0], [plant.GetPositions(context)]
        for k in range(steps):
            target.FixValue(context, targets[k])
            simulator.AdvanceTo((k + 1) * h)
            if (k + 1) % every == 0 or k + 1 == steps:
                times.append((k + 1) * h)
                positions.append(plant.GetPositions(context))
        return Motion(np.array(times), self._from_drake(np.array(positions).T), steps)

    def _actuators(self) -> list[int]:
        """Index in u of every actuator of Drake."""
        plant = self._plant
        indices = [self._joint_index(plant.get_joint_actuator(i).joint()) for i in plant.GetJointActuatorIndices()]
        assert sorted(indices) == list(range(self.library.n_a))
        return indices

    def _joint_index(self, joint: Any) -> int:
        return next(i for i, name in enumerate(self.library.joint_names) if name.endswith("/" + joint.name()))

    def _layout(self) -> np.ndarray:
        """For every number of the library's q its place in Drake's, which keeps the scalar of a quaternion first."""
        plant, library = self._plant, self.library
        place = np.full(library.n_q, -1)
        for item in library.objects:
            start = self._bodies[item.name].floating_positions_start()
            place[item.q_begin : item.q_begin + 7] = start + np.array([4, 5, 6, 1, 2, 3, 0])
        for i in plant.GetJointActuatorIndices():
            joint = plant.get_joint_actuator(i).joint()
            place[library.n_qu + self._joint_index(joint)] = joint.position_start()
        assert sorted(place) == list(range(library.n_q))
        return place

    def _to_drake(self, q: np.ndarray) -> np.ndarray:
        out = np.empty(len(q))
        out[self._layout()] = q
        return out

    def _from_drake(self, positions: np.ndarray) -> np.ndarray:
        return positions[self._layout()]


def coulomb(friction: float) -> Any:
    from pydrake.multibody.plant import CoulombFriction

    return CoulombFriction(friction, friction)
