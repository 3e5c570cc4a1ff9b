"""Robot motion through contact."""

from collections.abc import Callable, Iterator, Mapping, Sequence
import enum
import os
import pathlib
from typing import Annotated, Any, Self, overload

import numpy
import numpy.typing
from numpy.typing import NDArray


def version() -> str:
    """Returns the version of the library as MAJOR.MINOR.PATCH."""

class InvalidInput(ValueError):
    pass

class Status(enum.Enum):
    """
    Outcome of a numerical procedure. Wrong arguments raise InvalidInput instead.
    """

    Solved = 0
    """the procedure reached its tolerance or goal"""

    MaxIterations = 1
    """
    the budget of iterations, nodes or time was used up; the best result so far is returned
    """

    Infeasible = 2
    """there is no solution, as a certificate proves"""

    NumericalFailure = 3
    """the computation failed; do not use the results"""

    Cancelled = 4
    """the caller stopped the procedure; the best result so far is returned"""

class Pose:
    """Rigid transform X_AB: a point p_B in B is at R p_B + p in A."""

    def __init__(self, R: numpy.typing.ArrayLike, p: numpy.typing.ArrayLike) -> None:
        """
        Makes a pose.

          R: rotation matrix (3, 3).
          p: position [m] (3).

            >>> X_WA = st.Pose([[0, -1, 0], [1, 0, 0], [0, 0, 1]], [1, 0, 0])  # a quarter turn about z
            >>> (X_WA @ st.Pose(np.eye(3), [2, 0, 0])).p
            array([1., 2., 0.])
        """

    @property
    def R(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3, 3), order='F')]:
        """rotation (3, 3)"""

    @property
    def p(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """position [m] (3)"""

    @property
    def quaternion_wxyz(self) -> Annotated[NDArray[numpy.float64], dict(shape=(4), order='C')]:
        """quaternion of R in the order w, x, y, z, with w >= 0 (4)"""

    def __matmul__(self, arg: Pose, /) -> Pose: ...

    def inverse(self) -> Pose:
        """Returns the inverse transform: X_BA for X_AB."""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class BodyKind(enum.Enum):
    """Kind of a body."""

    Fixed = 0
    """the body does not move"""

    Object = 1
    """the body is an object"""

    Robot = 2
    """the body is a link of a robot"""

class DofKind(enum.Enum):
    """Kind of a coordinate: translation or rotation."""

    Prismatic = 0
    """translation [m]"""

    Revolute = 1
    """rotation [rad]"""

class Body:
    """Rigid body: a fixed body, an object, or a link of a robot."""

    @property
    def name(self) -> str:
        """name of the body"""

    @property
    def kind(self) -> BodyKind:
        """kind of the body"""

    @property
    def dofs(self) -> list[int]:
        """indices of the velocity coordinates that move the body"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class RobotLink:
    """Link of a robot, with the name of its parent."""

    @property
    def name(self) -> str:
        """name of the link, as robot/link"""

    @property
    def parent(self) -> str | None:
        """name of the parent link; None: the link is attached to the world"""

    @property
    def moves(self) -> bool:
        """True: a joint moves the link relative to its parent"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Geometry:
    """Collision shape on a body."""

    @property
    def name(self) -> str:
        """name of the geometry"""

    @property
    def body(self) -> int:
        """index into Model.bodies"""

    @property
    def X_BG(self) -> Pose:
        """pose of the geometry in the body"""

    @property
    def shape(self) -> dict[str, object]:
        """
        dict with the `type` of the shape and its dimensions [m], as in a plan file (docs/plan_file.md); a mesh has arrays
        """

    @property
    def friction(self) -> float:
        """friction coefficient of the geometry"""

    @property
    def max_force(self) -> float:
        """
        largest normal force that the geometry bears from one other geometry [N]; infinite: no limit
        """

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Pair:
    """Two geometries that may touch."""

    @property
    def geometry_a(self) -> int:
        """index of A in Model.geometries"""

    @property
    def geometry_b(self) -> int:
        """index of B in Model.geometries"""

    @property
    def friction(self) -> float:
        """friction coefficient of the pair"""

    @property
    def torsional(self) -> float:
        """
        torsional friction: largest moment about the normal divided by the normal force [m]; 0: none
        """

    @property
    def rolling(self) -> float:
        """
        rolling friction: largest moment about the tangents divided by the normal force [m]. Only simulation uses it
        """

    @property
    def max_distance(self) -> float:
        """the pair counts as a contact only if it is nearer than this [m]"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Dof:
    """Velocity coordinate of an object, or joint of a robot."""

    @property
    def name(self) -> str:
        """name of the coordinate"""

    @property
    def kind(self) -> DofKind:
        """translation or rotation"""

    @property
    def lower(self) -> float:
        """lower limit [m or rad]"""

    @property
    def upper(self) -> float:
        """upper limit [m or rad]"""

    @property
    def command_lower(self) -> float:
        """smallest command of a robot joint [m or rad]; see Model.command_lower"""

    @property
    def command_upper(self) -> float:
        """largest command of a robot joint [m or rad]; see Model.command_upper"""

    @property
    def stiffness(self) -> float:
        """stiffness K_a of the joint [N/m or N m/rad]; 0 for objects"""

    @property
    def effort(self) -> float:
        """largest force or torque of the motor [N or N m]; infinite: no limit"""

    @property
    def friction(self) -> float:
        """
        dry friction of a hinge, slider or robot joint [N m or N]; step() uses it for objects only
        """

    @property
    def damping(self) -> float:
        """
        viscous friction of a hinge, slider or robot joint [N m s/rad or N s/m]; only simulation uses it
        """

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class ObjectInfo:
    """An object, and the indices of its coordinates in q and v."""

    @property
    def name(self) -> str:
        """name of the object"""

    @property
    def body(self) -> int:
        """index into Model.bodies"""

    @property
    def v_begin(self) -> int:
        """index of its first coordinate in v"""

    @property
    def n_v(self) -> int:
        """number of its coordinates in v"""

    @property
    def q_begin(self) -> int:
        """index of its first number in q"""

    @property
    def n_q(self) -> int:
        """number of its numbers in q"""

    @property
    def parent(self) -> int:
        """index of the object that carries it through a joint, or -1"""

    @property
    def mass(self) -> float:
        """mass [kg]"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Kinematics:
    """Poses of all bodies and axes of all coordinates at one configuration."""

    @property
    def X_WB(self) -> list[Pose]:
        """pose of each body in W"""

    @property
    def axis_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3, None), order='F')]:
        """unit axis of each coordinate in W (3, n_v)"""

    @property
    def origin_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3, None), order='F')]:
        """a point on each axis, in W [m] (3, n_v)"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Scene:
    """Description of robots, objects and fixed bodies, as in a scene file."""

    @property
    def name(self) -> str:
        """name of the scene"""

    @property
    def gravity(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """gravity [m/s^2] (3); it acts on objects only"""

    @property
    def contact_distance(self) -> float:
        """pairs closer than this count as contacts [m]"""

    @property
    def robot_urdfs(self) -> dict[str, str]:
        """
        text of each robot's URDF file: {robot: text}; without tools that are mounted on the robot, and without robots from MJCF files
        """

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

@overload
def load_scene(file: str | os.PathLike) -> Scene:
    """
    Loads a scene from a YAML file, which may be a task file. Raises InvalidInput: "FILE:LINE: field: got …".
    """

@overload
def load_scene(scene: dict, *, base: str | os.PathLike | None = None) -> Scene:
    """
    Makes a scene from a dict with the keys of a scene file.

      scene: dict. The keys `urdf` and `mjcf` of a robot are paths, or the text of the URDF or MJCF itself.
      base: folder to which paths in the dict are relative. None: the working folder.

    Raises InvalidInput with the text "field: got …, expected …".
    """

@overload
def load_model(file: str | os.PathLike) -> Model:
    """Loads the model of a scene file: Model.make(load_scene(file))."""

@overload
def load_model(scene: dict, *, base: str | os.PathLike | None = None) -> Model:
    """
    Makes the model of a scene that is a dict: Model.make(load_scene(scene, base=base)).

        >>> model = st.load_model({
        ...     "gravity": [0, 0, -9.81],
        ...     "robots": [{"name": "arm", "urdf": "package://example-robot-data/robots/ur_description/urdf/ur5_robot.urdf"}],
        ...     "objects": [{"name": "box", "joint": "free", "mass": 0.5, "shapes": [{"box": {"size": [0.1, 0.1, 0.1]}}]}],
        ...     "fixed": [{"name": "table", "shapes": [{"half_space": {}}]}],
        ...     "filters": [{"exclude": ["arm", "table"]}],
        ... })
        >>> model.n_a, model.n_q, model.object_names
        (6, 13, ['box'])
        >>> cart = \"\"\"<robot name="cart"><link name="rail"/><link name="body"/>
        ...   <joint name="x" type="prismatic"><parent link="rail"/><child link="body"/></joint></robot>\"\"\"
        >>> st.load_model({"robots": [{"name": "cart", "urdf": cart}]}).joint_names
        ['cart/x']
    """

class Model:
    """
    Kinematics, actuation, geometry and friction of a scene. A model is immutable, and threads may share it.
    """

    @staticmethod
    def make(scene: Scene) -> Model:
        """Makes the model of a scene. Raises InvalidInput."""

    def __reduce__(self) -> tuple: ...

    @property
    def scene(self) -> Scene:
        """scene of the model"""

    @property
    def n_q(self) -> int:
        """length of a configuration q"""

    @property
    def n_v(self) -> int:
        """number of velocity coordinates"""

    @property
    def n_vu(self) -> int:
        """number of velocity coordinates of the objects"""

    @property
    def n_qu(self) -> int:
        """length of the objects' part of q"""

    @property
    def n_a(self) -> int:
        """number of actuated joints, the length of a command u"""

    @property
    def stiffness(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """stiffness K_a of the joints (n_a) [N/m or N m/rad]"""

    @property
    def effort(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        largest forces and torques of the motors (n_a) [N or N m]; infinite: no limit
        """

    @property
    def speed_limit(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        speed limits of the joints from the URDF (n_a) [m/s or rad/s]; infinite: no limit
        """

    @property
    def lower(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """lower joint limits (n_a) [m or rad]"""

    @property
    def upper(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """upper joint limits (n_a) [m or rad]"""

    @property
    def command_lower(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        smallest commands (n_a) [m or rad]: the lower joint limits, or less where ctrlrange in an MJCF goes further
        """

    @property
    def command_upper(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        largest commands (n_a) [m or rad]: the upper joint limits, or more where ctrlrange in an MJCF goes further
        """

    @property
    def reach(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """bound on the lever arm of each joint (n_a) [m]"""

    @property
    def joint_names(self) -> list[str]:
        """names of the joints as robot/joint, in the order of u"""

    @property
    def object_names(self) -> list[str]:
        """names of the objects"""

    @property
    def bodies(self) -> list[Body]:
        """all bodies"""

    @property
    def links(self) -> list[RobotLink]:
        """links of all robots, parents first"""

    @property
    def geometries(self) -> list[Geometry]:
        """all collision shapes"""

    @property
    def pairs(self) -> list[Pair]:
        """pairs of geometries that may touch"""

    @property
    def dofs(self) -> list[Dof]:
        """all velocity coordinates, objects first"""

    @property
    def objects(self) -> list[ObjectInfo]:
        """all objects"""

    @property
    def notes(self) -> list[str]:
        """
        remarks, one sentence each: values that differ from the files, or that were chosen because the files do not give them
        """

    @property
    def planar_axis(self) -> int | None:
        """
        index of the axis normal to the plane in which everything moves, or None
        """

    def neutral(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        Returns a configuration (n_q): every object at its placed frame, every joint as near to 0 as its limits allow.
        """

    def joint_index(self, name: str) -> int:
        """Returns the index of a joint in u. Raises InvalidInput: no such joint."""

    def object_index(self, name: str) -> int:
        """
        Returns the index of an object in `objects`. Raises InvalidInput: no such object.
        """

    def retract(self, q: numpy.typing.ArrayLike, delta: numpy.typing.ArrayLike) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        Moves a configuration: returns q ⊕ δ (n_q). Use it instead of q + δ, since q contains quaternions.

          q: configuration (n_q).
          delta: displacement δ in tangent coordinates (n_v) [m, rad].

            >>> model = st.load_task("allegro_ball").model
            >>> q = model.neutral()
            >>> delta = np.full(model.n_v, 0.1)
            >>> bool(np.allclose(model.local(q, model.retract(q, delta)), delta))
            True
        """

    def local(self, q0: numpy.typing.ArrayLike, q1: numpy.typing.ArrayLike) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        Returns the displacement q1 ⊖ q0 from q0 to q1 in tangent coordinates (n_v) [m, rad].
        """

    def object_pose(self, q: numpy.typing.ArrayLike, object: str) -> Pose:
        """Returns the pose X_WB of a named object at q (n_q)."""

    def object_poses(self, q: numpy.typing.ArrayLike, object: str) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """
        Returns the poses X_WB of a named object at many configurations (N, n_q), as (N, 7): x y z [m], then the quaternion w x y z with w >= 0.
        """

    def calc_kinematics(self, q: numpy.typing.ArrayLike) -> Kinematics:
        """
        Returns the Kinematics at q (n_q): poses of all bodies and axes of all coordinates.
        """

    def body_poses(self, q: numpy.typing.ArrayLike) -> dict[str, Pose]:
        """Returns the poses X_WB of all bodies at q (n_q): {body: pose}."""

    def __repr__(self) -> str: ...

    def __copy__(self) -> Self: ...

    def __deepcopy__(self, memo: object, /) -> Self: ...

class Visual:
    """Visual shape or mesh of a body."""

    @property
    def body(self) -> int:
        """index into Model.bodies"""

    @property
    def X_BV(self) -> Pose:
        """pose of the visual in the body"""

    @property
    def shape(self) -> dict[str, object] | None:
        """shape, as in Geometry.shape; None: the visual is a mesh"""

    @property
    def mesh(self) -> int | None:
        """index into Visuals.meshes; None: the visual is a shape"""

    @property
    def color(self) -> Annotated[NDArray[numpy.float64], dict(shape=(4), order='C')]:
        """red, green, blue and opacity in [0, 1]"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Visuals:
    """Visual shapes and meshes of a scene."""

    @property
    def visuals(self) -> list[Visual]:
        """visuals of all bodies"""

    @property
    def meshes(self) -> list[tuple[Annotated[NDArray[numpy.float32], dict(shape=(None, 3), order='C')], Annotated[NDArray[numpy.int32], dict(shape=(None, 3), order='C')]]]:
        """vertices (n, 3) [m] and triangles (m, 3) of each mesh"""

    @property
    def notes(self) -> list[str]:
        """remarks on elements that were left out, one sentence each"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def read_visuals(model: Model) -> Visuals:
    """
    Reads the visual shapes and meshes of links and objects: <visual> elements of a URDF, and visible geoms of an MJCF.

    Elements that cannot be read are left out, with a remark in `notes`. A body without visuals in its file has none; draw its geometries.
    """

class PlacedLinks:
    """
    Result of place_links(): joint positions at which links have given poses.
    """

    @property
    def status(self) -> Status:
        """
        Solved; MaxIterations: no posture within the joint limits has the poses; NumericalFailure: every such posture overlaps something
        """

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """configuration that was found, or the nearest one (n_q)"""

    @property
    def position(self) -> float:
        """largest position error of a link at q [m]"""

    @property
    def angle(self) -> float:
        """largest angle error of a link at q [rad]"""

    @property
    def pair(self) -> int:
        """index into Model.pairs of the pair that overlaps most, or -1"""

    @property
    def depth(self) -> float:
        """depth of this overlap [m]"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def place_links(model: Model, q: numpy.typing.ArrayLike, poses: Mapping[str, Pose | numpy.typing.ArrayLike], *, postures: int = 96, overlap: bool = False) -> PlacedLinks:
    """
    Finds joint positions at which links have given poses (inverse kinematics), within the joint limits and without overlap.

    The result is the posture nearest to q. Objects do not move.

      model: Model with the robot.
      q: configuration (n_q).
      poses: for each link, by its name ("robot/link", or "link" if one robot has it), its Pose X_WB, or its position alone (3) [m].
      postures: number of postures from which the search starts. 1: only q; this is fast, and joints do not jump while a link is dragged.
      overlap: True: accept postures in which bodies overlap.

    Returns a PlacedLinks.

        >>> task = st.load_task("iiwa_bimanual_box")
        >>> hand = "left/link_7"
        >>> X = task.model.body_poses(task.q_start)[hand]
        >>> placed = st.place_links(task.model, task.q_start, {hand: st.Pose(X.R, X.p + [0, 0, 0.05])})
        >>> placed.status.name, bool(abs(task.model.body_poses(placed.q)[hand].p - X.p)[2] > 0.049)
        ('Solved', True)
    """

class ContactImpulse:
    """
    One contact of a step. Its impulse acts on geometry a, and the opposite impulse on geometry b.
    """

    @property
    def a(self) -> str:
        """name of the first geometry, as body/geometry"""

    @property
    def b(self) -> str:
        """name of the second geometry"""

    @property
    def pair(self) -> int:
        """index into Model.pairs"""

    @property
    def id(self) -> int:
        """number of the contact, the same from step to step"""

    @property
    def phi(self) -> float:
        """signed distance before the step [m]"""

    @property
    def p_WA(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """closest point on a, in W [m] (3)"""

    @property
    def p_WB(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """closest point on b, in W [m] (3)"""

    @property
    def nhat_BA_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """unit normal from b to a, in W (3)"""

    @property
    def t1_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """first unit tangent, in W (3)"""

    @property
    def t2_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """second unit tangent, in W (3)"""

    @property
    def friction(self) -> float:
        """friction coefficient"""

    @property
    def spin(self) -> float:
        """
        arm of a contact that resists turning [m]: its moment about the normal is spin times the force along t2 (S.26)
        """

    @property
    def lambda_(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """impulse along (n, t1, t2) [N s] (3)"""

    @property
    def force(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """force along (n, t1, t2) [N] (3)"""

    @property
    def force_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """force in W [N] (3)"""

    @property
    def displacement(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """displacement of a relative to b, J_c δq, along (n, t1, t2) [m] (3)"""

    @property
    def gap(self) -> float:
        """slack of the contact constraint, φ + J_n δq - μ‖J_t δq‖ [m]"""

    @property
    def active(self) -> bool:
        """True: the contact carries a force that counts"""

    @property
    def slide(self) -> float:
        """sliding distance ‖J_t δq‖ [m]"""

    @property
    def anitescu_gap(self) -> float:
        """distance after the step, φ + J_n δq [m]"""

    def calc_wrench(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        Returns the force on a and its moment about the world origin, in W [N, N m] (6).
        """

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Residuals:
    """Residuals of the optimality conditions of a step."""

    @property
    def stationarity(self) -> float:
        """residual of the force balance, relative"""

    @property
    def primal(self) -> float:
        """residual of the constraint slacks, relative"""

    @property
    def complementarity(self) -> float:
        """largest violation of complementarity"""

    @property
    def cone(self) -> float:
        """largest distance by which a slack or an impulse leaves its cone"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class StepResult:
    """
    Result of step(): the next configuration, the contacts, and derivatives if asked for.
    """

    @property
    def status(self) -> Status: ...

    @property
    def q_next(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """next configuration (n_q)"""

    @property
    def delta(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """displacement δq in tangent coordinates (n_v) [m, rad]"""

    @property
    def torque(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        torques of the joint springs (n_a) [N m, N]; at most Model.effort if effort_limits is set
        """

    @property
    def joint_friction(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        friction torques of the objects' hinges and sliders (n_vu) [N m, N]; empty if no joint has friction
        """

    @property
    def saturated(self) -> Annotated[NDArray[numpy.bool_], dict(shape=(None,), order='C')]:
        """True for each joint whose motor is at its effort limit (n_a)"""

    @property
    def contacts(self) -> list[ContactImpulse]:
        """contacts of the step (n_c)"""

    @property
    def phi(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """signed distances before the step [m] (n_c)"""

    @property
    def gap(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """slacks of the contact constraints [m] (n_c)"""

    @property
    def active(self) -> Annotated[NDArray[numpy.bool_], dict(shape=(None,), order='C')]:
        """True for each contact that carries a force (n_c)"""

    @property
    def lambda_(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')]:
        """impulses along (n, t1, t2) [N s] (n_c, 3)"""

    @property
    def A(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')] | None:
        """derivative of q_next by q (n_v, n_v); None unless with_A was set"""

    @property
    def B(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')] | None:
        """derivative of q_next by u (n_v, n_a); None unless with_B was set"""

    @property
    def D_lambda_q(self) -> list[Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')]] | None:
        """
        derivative of each impulse by q, a list of (3, n_v); None unless with_force_derivatives and with_A were set
        """

    @property
    def D_lambda_u(self) -> list[Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')]] | None:
        """
        derivative of each impulse by u, a list of (3, n_a); None unless with_force_derivatives and with_B were set
        """

    @property
    def epsilon(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """regularisation that was used for each object"""

    @property
    def residuals(self) -> Residuals:
        """residuals of the optimality conditions"""

    @property
    def iterations(self) -> int:
        """number of solver iterations"""

    @property
    def h(self) -> float:
        """time step [s]"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class LocalModel:
    """Linear model of a step: q_next(q ⊕ δq, u + δu) ≈ c ⊕ (A δq + B δu)."""

    @property
    def status(self) -> Status: ...

    @property
    def c(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """next configuration, smoothed by the scheme (n_q)"""

    @property
    def A(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')] | None:
        """derivative by q (n_v, n_v); None unless with_A was set"""

    @property
    def B(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')]:
        """derivative by u (n_v, n_a)"""

    @property
    def failed(self) -> int:
        """number of samples whose step had no solution; they are left out"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Knot:
    """State after one sub-step of rollout()."""

    @property
    def u(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """command (n_a) [m or rad]"""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """configuration (n_q)"""

    @property
    def contacts(self) -> list[ContactImpulse]:
        """active contacts"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class RolloutResult:
    """Result of rollout(): the states after its sub-steps."""

    @property
    def status(self) -> Status: ...

    @property
    def knots(self) -> list[Knot]:
        """states after the sub-steps"""

    @property
    def steps(self) -> int:
        """number of steps that were computed"""

    @property
    def max_slide(self) -> float:
        """largest mu * slip of an active contact in a sub-step [m]"""

    @property
    def min_phi(self) -> float:
        """smallest signed distance [m]; negative: penetration"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Exact:
    """Contact dynamics without smoothing (2.6)."""

    def __init__(self) -> None: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Analytic:
    """
    Contact dynamics that are smoothed by a log barrier (2.27).

    kappa is the weight of the barrier [1/J], > 0; larger values are closer to Exact. Contacts among robot parts and fixed bodies have the
    weight self_sharpness * kappa, and joint limits have limit_sharpness * kappa.
    """

    def __init__(self, *, kappa: float = 100.0, self_sharpness: float = 10.0, limit_sharpness: float = 10.0) -> None: ...

    @property
    def kappa(self) -> float:
        """weight of the barrier [1/J]"""

    @property
    def self_sharpness(self) -> float:
        """factor of kappa for contacts among robot parts and fixed bodies"""

    @property
    def limit_sharpness(self) -> float:
        """factor of kappa for joint limits"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class RandomizedFirstOrder:
    """
    Smoothing by the average of exact steps and their derivatives at random samples (2.22).
    """

    def __init__(self, *, std_q: numpy.typing.ArrayLike, std_u: numpy.typing.ArrayLike, samples: int = 100, seed: int = 0) -> None:
        """
        A scheme that samples configurations and commands from a normal distribution.

          std_q: standard deviations of q in tangent coordinates [m, rad], >= 0: (n_v), or (1) for all.
          std_u: standard deviations of u [m or rad], >= 0: (n_a), or (1) for all.
          samples: number of samples, >= 1.
          seed: of the samples.
        """

    @property
    def std_q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """standard deviations of q [m, rad]"""

    @property
    def std_u(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """standard deviations of u [m or rad]"""

    @property
    def samples(self) -> int:
        """number of samples"""

    @property
    def seed(self) -> int:
        """seed of the samples"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class RandomizedZerothOrder:
    """
    Smoothing by a least-squares fit to exact steps at random samples (2.23).
    """

    def __init__(self, *, std_q: numpy.typing.ArrayLike, std_u: numpy.typing.ArrayLike, samples: int = 100, seed: int = 0) -> None:
        """
        A scheme that samples configurations and commands from a normal distribution.

          std_q: standard deviations of q in tangent coordinates [m, rad], >= 0: (n_v), or (1) for all.
          std_u: standard deviations of u [m or rad], >= 0: (n_a), or (1) for all.
          samples: number of samples, >= 1.
          seed: of the samples.
        """

    @property
    def std_q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """standard deviations of q [m, rad]"""

    @property
    def std_u(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """standard deviations of u [m or rad]"""

    @property
    def samples(self) -> int:
        """number of samples"""

    @property
    def seed(self) -> int:
        """seed of the samples"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class ByRule:
    """
    Regularisation of the objects as a ratio to the stiffness of the joint springs, > 0 (docs/theory/step.md).
    """

    def __init__(self, *, ratio: float = 0.1) -> None: ...

    @property
    def ratio(self) -> float: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class FixedEpsilon:
    """
    Regularisation of the objects as a factor epsilon of their mass matrix (2.6c), > 0; 1: the true mass.
    """

    def __init__(self, *, epsilon: float = 1.0) -> None: ...

    @property
    def epsilon(self) -> float: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class SecondOrderCone:
    """Exact friction cone. In planar models two rays represent it exactly."""

    def __init__(self) -> None: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class PolyhedralCone:
    """
    Friction pyramid with this number of rays, in [3, 64], inside the friction cone.
    """

    def __init__(self, *, rays: int = 4) -> None: ...

    @property
    def rays(self) -> int: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class FrictionLaw(enum.Enum):
    """Law of sliding contacts."""

    Anitescu = 0
    """convex relaxation: a sliding contact opens by mu |J_t dq| (2.3.4)"""

    Coulomb = 1
    """
    a sliding contact stays closed (S.14); only in exact steps of spatial models with second-order cones
    """

class StepWorkspace:
    """
    Memory and warm starts that several calls of step() or rollout() share. Only one thread may use it at a time.
    """

    def __init__(self, model: Model) -> None: ...

    def forget(self) -> None:
        """
        Drops the warm starts, so that the next step depends only on its arguments.
        """

    def __reduce__(self) -> tuple: ...

def step(model: Model, q: numpy.typing.ArrayLike, u: numpy.typing.ArrayLike, *, tau_ext: numpy.typing.ArrayLike | None = None, damping: numpy.typing.ArrayLike | None = None, with_A: bool | numpy.bool_ = False, with_B: bool | numpy.bool_ = False, with_force_derivatives: bool | numpy.bool_ = False, warm_start: bool | numpy.bool_ = True, workspace: StepWorkspace | None = None, h: float = 0.1, smoothing: Exact | Analytic = ..., regularisation: ByRule | FixedEpsilon = ..., friction_cone: SecondOrderCone | PolyhedralCone = ..., friction_law: FrictionLaw = FrictionLaw.Anitescu, friction_scale: float = 1.0, contact_margin: float = 0.0, joint_limits: bool | numpy.bool_ = True, effort_limits: bool | numpy.bool_ = False, tol_complementarity: float = 1e-10, kappa: float | None = None, epsilon: float | None = None) -> StepResult:
    """
    Computes one quasi-static step of robots and objects (2.6).

    The robot joints are springs that pull towards the command u. The step finds the next configuration, in which spring forces, gravity and
    contact forces are in balance. Use it to simulate contact without inertia, or to get its derivatives.

      model: Model of the scene.

      q: configuration (n_q): objects first, quaternions of length 1.
      u: commanded joint positions (n_a) [m or rad].
      tau_ext: external generalised forces besides gravity (n_v) [N, N m]; None: 0.
      damping: coefficients of a viscous force -damping dq/h on each coordinate (n_v) [N s/m, N m s/rad], >= 0; None: 0.
      with_A, with_B: also compute the derivatives StepResult.A and StepResult.B.
      with_force_derivatives: also compute StepResult.D_lambda_q (with with_A) and StepResult.D_lambda_u (with with_B).
      warm_start: start the solver from the previous step in the workspace.
      workspace: StepWorkspace to share memory between calls; only one thread may use it at a time. None: a new one for this call.

    Returns a StepResult. Its status is Solved; MaxIterations; Infeasible: bodies overlap, and no motion within reach separates them; or
    NumericalFailure.

        >>> task = st.load_task("planar_pushing")
        >>> result = st.step(task.model, task.q_start, [0.0, 0.1], h=0.1, smoothing=st.Analytic(kappa=100), with_B=True)
        >>> result.status, result.q_next.shape, result.B.shape
        (Status.Solved, (5,), (5, 2))

    Arguments of the step:
      h: time step [s], > 0.
      smoothing: Exact() (2.6), or Analytic(kappa=...) [1/J] (2.27).
      regularisation: regularisation of the objects: ByRule(ratio=...) (docs/theory/step.md), or FixedEpsilon(epsilon=...), where 1 is the true mass.
      friction_cone: SecondOrderCone(), or PolyhedralCone(rays=...).
      friction_law: law of exact steps. Anitescu: a sliding contact opens by mu |J_t dq|. Coulomb: a sliding contact stays closed (S.14).
      friction_scale: factor of every coefficient of friction, >= 0.
      contact_margin: distance that is added to the contact distance of the scene [m], >= 0.
      joint_limits: True: the joint limits are constraints of the step.
      effort_limits: True: a joint pushes with Model.effort at most (S.15). False: the spring forces have no limit.
      tol_complementarity: largest |v lambda| of a contact, divided by 5 L F h with the scales L and F of docs/theory/scales.md [-], in [1e-12, 1e-2].
      kappa, epsilon: deprecated; use smoothing=Analytic(kappa=...) and regularisation=FixedEpsilon(epsilon=...).

    Raises InvalidInput, which names the argument.
    """

def calc_local_model(model: Model, q: numpy.typing.ArrayLike, u: numpy.typing.ArrayLike, *, scheme: Exact | Analytic | RandomizedFirstOrder | RandomizedZerothOrder | None = None, tau_ext: numpy.typing.ArrayLike | None = None, damping: numpy.typing.ArrayLike | None = None, with_A: bool | numpy.bool_ = False, threads: int = 1, h: float = 0.1, smoothing: Exact | Analytic = ..., regularisation: ByRule | FixedEpsilon = ..., friction_cone: SecondOrderCone | PolyhedralCone = ..., friction_law: FrictionLaw = FrictionLaw.Anitescu, friction_scale: float = 1.0, contact_margin: float = 0.0, joint_limits: bool | numpy.bool_ = True, effort_limits: bool | numpy.bool_ = False, tol_complementarity: float = 1e-10, kappa: float | None = None, epsilon: float | None = None) -> LocalModel:
    """
    Linearises a step around a configuration and a command (2.4.1): q_next(q + dq, u + du) ~ c + (A dq + B du) in tangent coordinates.

      q: configuration (n_q). u: command (n_a) [m or rad].
      scheme: Exact, Analytic, RandomizedFirstOrder or RandomizedZerothOrder. None: the argument `smoothing`.
      tau_ext, damping: as in step() (n_v).
      with_A: also compute LocalModel.A.
      threads: number of threads for randomised schemes. The result does not depend on it.

    Returns a LocalModel. Its status is Solved, or the status of the step that failed. A randomised scheme leaves failed samples out and counts
    them in LocalModel.failed.

        >>> task = st.load_task("planar_pushing")
        >>> local = st.calc_local_model(task.model, task.q_start, task.q_start[3:], scheme=st.Analytic(kappa=100), with_A=True)
        >>> local.A.shape, local.B.shape, local.failed
        ((5, 5), (5, 2), 0)

    Arguments of the step:
      h: time step [s], > 0.
      smoothing: Exact() (2.6), or Analytic(kappa=...) [1/J] (2.27).
      regularisation: regularisation of the objects: ByRule(ratio=...) (docs/theory/step.md), or FixedEpsilon(epsilon=...), where 1 is the true mass.
      friction_cone: SecondOrderCone(), or PolyhedralCone(rays=...).
      friction_law: law of exact steps. Anitescu: a sliding contact opens by mu |J_t dq|. Coulomb: a sliding contact stays closed (S.14).
      friction_scale: factor of every coefficient of friction, >= 0.
      contact_margin: distance that is added to the contact distance of the scene [m], >= 0.
      joint_limits: True: the joint limits are constraints of the step.
      effort_limits: True: a joint pushes with Model.effort at most (S.15). False: the spring forces have no limit.
      tol_complementarity: largest |v lambda| of a contact, divided by 5 L F h with the scales L and F of docs/theory/scales.md [-], in [1e-12, 1e-2].
      kappa, epsilon: deprecated; use smoothing=Analytic(kappa=...) and regularisation=FixedEpsilon(epsilon=...).

    Raises InvalidInput, which names the argument.
    """

def rollout(model: Model, q: numpy.typing.ArrayLike, u_start: numpy.typing.ArrayLike, u_end: numpy.typing.ArrayLike, *, joint_angle: float = 0.03, joint_travel: float = 0.01, slide: float = 0.001, max_substeps: int = 400, workspace: StepWorkspace | None = None, h: float = 0.1, smoothing: Exact | Analytic = ..., regularisation: ByRule | FixedEpsilon = ..., friction_cone: SecondOrderCone | PolyhedralCone = ..., friction_law: FrictionLaw = FrictionLaw.Anitescu, friction_scale: float = 1.0, contact_margin: float = 0.0, joint_limits: bool | numpy.bool_ = True, effort_limits: bool | numpy.bool_ = False, tol_complementarity: float = 1e-10, kappa: float | None = None, epsilon: float | None = None) -> RolloutResult:
    """
    Simulates a straight motion of the command from u_start to u_end in small exact steps, from the configuration q.

      q: configuration at the start (n_q).
      u_start, u_end: commands (n_a) [m or rad].
      joint_angle, joint_travel: largest change of a command in a sub-step, for revolute [rad] and prismatic [m] joints, > 0.
      slide: largest mu * slip of an active contact in a sub-step [m], > 0. The sub-steps are made smaller for it as far as max_substeps allows.
      max_substeps: largest number of sub-steps, >= 1.
      workspace: StepWorkspace to share memory between calls; only one thread may use it at a time. None: a new one for this call.

    Returns a RolloutResult. Its status is Solved, or the status of the sub-step that failed; the knots before that sub-step are kept.

        >>> task = st.load_task("planar_pushing")
        >>> path = st.rollout(task.model, task.q_start, [0.0, 0.0], [0.0, 0.1], joint_travel=0.01)
        >>> path.status, len(path.knots)
        (Status.Solved, 10)

    Arguments of the step:
      h: time step [s], > 0.
      smoothing: Exact() (2.6), or Analytic(kappa=...) [1/J] (2.27).
      regularisation: regularisation of the objects: ByRule(ratio=...) (docs/theory/step.md), or FixedEpsilon(epsilon=...), where 1 is the true mass.
      friction_cone: SecondOrderCone(), or PolyhedralCone(rays=...).
      friction_law: law of exact steps. Anitescu: a sliding contact opens by mu |J_t dq|. Coulomb: a sliding contact stays closed (S.14).
      friction_scale: factor of every coefficient of friction, >= 0.
      contact_margin: distance that is added to the contact distance of the scene [m], >= 0.
      joint_limits: True: the joint limits are constraints of the step.
      effort_limits: True: a joint pushes with Model.effort at most (S.15). False: the spring forces have no limit.
      tol_complementarity: largest |v lambda| of a contact, divided by 5 L F h with the scales L and F of docs/theory/scales.md [-], in [1e-12, 1e-2].
      kappa, epsilon: deprecated; use smoothing=Analytic(kappa=...) and regularisation=FixedEpsilon(epsilon=...).

    Raises InvalidInput, which names the argument.
    """

class BatchWorkspace:
    """
    Threads and their memory, kept for many small batches. Only one thread of the caller may use it at a time.
    """

    def __init__(self, model: Model, threads: int = 0) -> None:
        """
        Makes the threads for batches of one model.

          model: Model of the batches.
          threads: number of threads; 0: all cores.

        Raises InvalidInput.

            >>> model = st.load_task("planar_pushing").model
            >>> work = st.BatchWorkspace(model, threads=1)
            >>> q = model.neutral()[None]
            >>> [st.step_batch(model, q, q[:, 3:], workspace=work).failed for _ in range(2)]
            [0, 0]
        """

    def __reduce__(self) -> tuple: ...

class StepBatch:
    """
    Results of step_batch(): N steps. The first axis of each array is the index of the step.
    """

    @property
    def status(self) -> list[Status]:
        """status of each step (N)"""

    @property
    def solved(self) -> Annotated[NDArray[numpy.bool_], dict(shape=(None,), order='C')]:
        """
        True for each step with the status Solved (N); otherwise q_next is q, and A and B are 0
        """

    @property
    def failed(self) -> int:
        """number of steps that are not Solved"""

    @property
    def q_next(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """next configurations (N, n_q)"""

    @property
    def torque(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """torques of the joint springs (N, n_a) [N m, N]"""

    @property
    def A(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None, None), writable=False)] | None:
        """
        derivatives of q_next by q (N, n_v, n_v), a read-only array; None unless with_A was set
        """

    @property
    def B(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None, None), writable=False)] | None:
        """
        derivatives of q_next by u (N, n_v, n_a), a read-only array; None unless with_B was set
        """

    @property
    def wall_s(self) -> float:
        """wall time of the steps, without copies of arrays [s]"""

    def __len__(self) -> int: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def step_batch(model: Model, q: numpy.typing.ArrayLike, u: numpy.typing.ArrayLike, *, tau_ext: numpy.typing.ArrayLike | None = None, with_A: bool | numpy.bool_ = False, with_B: bool | numpy.bool_ = False, threads: int = 0, workspace: BatchWorkspace | None = None, h: float = 0.1, smoothing: Exact | Analytic = ..., regularisation: ByRule | FixedEpsilon = ..., friction_cone: SecondOrderCone | PolyhedralCone = ..., friction_law: FrictionLaw = FrictionLaw.Anitescu, friction_scale: float = 1.0, contact_margin: float = 0.0, joint_limits: bool | numpy.bool_ = True, effort_limits: bool | numpy.bool_ = False, tol_complementarity: float = 1e-10, kappa: float | None = None, epsilon: float | None = None) -> StepBatch:
    """
    Computes N independent steps in parallel, as step() does for one, with their derivatives if asked for (docs/theory/local_models.md).

      model: Model of the scene.
      q: configurations (N, n_q).
      u: commands (N, n_a) [m or rad].
      tau_ext: external generalised forces besides gravity (N, n_v) [N, N m]. None: 0.
      with_A, with_B: also compute the derivatives StepBatch.A and StepBatch.B.
      threads: 0: all cores. The result does not depend on this number, bit for bit, since no step uses a warm start.
      workspace: BatchWorkspace of the model, which saves time for many small batches. None: a new one for this call.

    Returns a StepBatch.

        >>> task = st.load_task("planar_pushing")
        >>> q = np.tile(task.q_start, (1000, 1))
        >>> batch = st.step_batch(task.model, q, q[:, 3:] + np.linspace(0, 0.2, 1000)[:, None], smoothing=st.Analytic(kappa=100), with_B=True)
        >>> batch.q_next.shape, batch.B.shape, batch.failed
        ((1000, 5), (1000, 5, 2), 0)

    Arguments of the step:
      h: time step [s], > 0.
      smoothing: Exact() (2.6), or Analytic(kappa=...) [1/J] (2.27).
      regularisation: regularisation of the objects: ByRule(ratio=...) (docs/theory/step.md), or FixedEpsilon(epsilon=...), where 1 is the true mass.
      friction_cone: SecondOrderCone(), or PolyhedralCone(rays=...).
      friction_law: law of exact steps. Anitescu: a sliding contact opens by mu |J_t dq|. Coulomb: a sliding contact stays closed (S.14).
      friction_scale: factor of every coefficient of friction, >= 0.
      contact_margin: distance that is added to the contact distance of the scene [m], >= 0.
      joint_limits: True: the joint limits are constraints of the step.
      effort_limits: True: a joint pushes with Model.effort at most (S.15). False: the spring forces have no limit.
      tol_complementarity: largest |v lambda| of a contact, divided by 5 L F h with the scales L and F of docs/theory/scales.md [-], in [1e-12, 1e-2].
      kappa, epsilon: deprecated; use smoothing=Analytic(kappa=...) and regularisation=FixedEpsilon(epsilon=...).

    Raises InvalidInput, which names the argument.
    """

def calc_weights_aside(model: Model, q: numpy.typing.ArrayLike, angle: float, draw: int) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
    """
    Computes the forces that tilt gravity by an angle, for free objects at many configurations. Use them as tau_ext of step_batch(), to test
    whether an object rests stably.

      q: configurations (N, n_q).
      angle: angle by which gravity is tilted [rad], in [0, pi/2).
      draw: direction of the tilt, in [0, 3]; each direction is a quarter turn from the previous one.

    Returns generalised forces (N, n_v) [N, N m]. They are 0 without gravity, and for objects on joints.

        >>> task = st.load_task("allegro_ball")
        >>> st.calc_weights_aside(task.model, task.q_start[None], 0.1, 0)[0, :3].round(4)
        array([0.    , 0.0502, 0.    ])
    """

class RolloutBatch:
    """Results of rollout_batch(): N trajectories of T steps each."""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None, None), writable=False)]:
        """configurations, the start first (N, T + 1, n_q); a read-only array"""

    @property
    def status(self) -> list[Status]:
        """
        status of each trajectory (N): Solved, or the status of its first step that is not Solved
        """

    @property
    def steps(self) -> list[int]:
        """
        number of solved steps of each trajectory (N); a trajectory stays where a step failed
        """

    @property
    def failed(self) -> int:
        """number of trajectories that are not Solved"""

    @property
    def wall_s(self) -> float:
        """wall time of the steps, without copies of arrays [s]"""

    def __len__(self) -> int: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def rollout_batch(model: Model, q_start: numpy.typing.ArrayLike, u: numpy.typing.ArrayLike, *, threads: int = 0, workspace: BatchWorkspace | None = None, h: float = 0.1, smoothing: Exact | Analytic = ..., regularisation: ByRule | FixedEpsilon = ..., friction_cone: SecondOrderCone | PolyhedralCone = ..., friction_law: FrictionLaw = FrictionLaw.Anitescu, friction_scale: float = 1.0, contact_margin: float = 0.0, joint_limits: bool | numpy.bool_ = True, effort_limits: bool | numpy.bool_ = False, tol_complementarity: float = 1e-10, kappa: float | None = None, epsilon: float | None = None) -> RolloutBatch:
    """
    Computes N trajectories q[t + 1] = step(q[t], u[t]) in parallel.

      model: Model of the scene.
      q_start: configurations at the start (N, n_q).
      u: commands (N, T, n_a) [m or rad].
      threads: 0: all cores. The result does not depend on this number, bit for bit, since no step uses a warm start.
      workspace: BatchWorkspace of the model, which saves time for many small batches. None: a new one for this call.

    Returns a RolloutBatch.

        >>> task = st.load_task("planar_pushing")
        >>> q = np.tile(task.q_start, (100, 1))
        >>> u = q[:, None, 3:] + np.linspace(0, 0.2, 8)[None, :, None]
        >>> rolled = st.rollout_batch(task.model, q, u)
        >>> rolled.q.shape, rolled.failed
        ((100, 9, 5), 0)

    Arguments of the step:
      h: time step [s], > 0.
      smoothing: Exact() (2.6), or Analytic(kappa=...) [1/J] (2.27).
      regularisation: regularisation of the objects: ByRule(ratio=...) (docs/theory/step.md), or FixedEpsilon(epsilon=...), where 1 is the true mass.
      friction_cone: SecondOrderCone(), or PolyhedralCone(rays=...).
      friction_law: law of exact steps. Anitescu: a sliding contact opens by mu |J_t dq|. Coulomb: a sliding contact stays closed (S.14).
      friction_scale: factor of every coefficient of friction, >= 0.
      contact_margin: distance that is added to the contact distance of the scene [m], >= 0.
      joint_limits: True: the joint limits are constraints of the step.
      effort_limits: True: a joint pushes with Model.effort at most (S.15). False: the spring forces have no limit.
      tol_complementarity: largest |v lambda| of a contact, divided by 5 L F h with the scales L and F of docs/theory/scales.md [-], in [1e-12, 1e-2].
      kappa, epsilon: deprecated; use smoothing=Analytic(kappa=...) and regularisation=FixedEpsilon(epsilon=...).

    Raises InvalidInput, which names the argument.
    """

def pull_back_rollout(model: Model, rolled: RolloutBatch, u: numpy.typing.ArrayLike, D_L_q: numpy.typing.ArrayLike, *, threads: int = 0, workspace: BatchWorkspace | None = None, h: float = 0.1, smoothing: Exact | Analytic = ..., regularisation: ByRule | FixedEpsilon = ..., friction_cone: SecondOrderCone | PolyhedralCone = ..., friction_law: FrictionLaw = FrictionLaw.Anitescu, friction_scale: float = 1.0, contact_margin: float = 0.0, joint_limits: bool | numpy.bool_ = True, effort_limits: bool | numpy.bool_ = False, tol_complementarity: float = 1e-10, kappa: float | None = None, epsilon: float | None = None) -> tuple[Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')], Annotated[NDArray[numpy.float64], dict(shape=(None, None, None), writable=False)]]:
    """
    Back-propagates the gradient of a scalar L through the trajectories of rollout_batch(), by the adjoint of the steps (S.25).

    Use it to optimise commands: give dL/dq at all configurations, and get dL/dq_start and dL/du.

      model: Model of the scene.
      rolled: RolloutBatch of rollout_batch(), for the same u.
      u: commands of that call (N, T, n_a) [m or rad].
      D_L_q: dL/dq (N, T + 1, n_q).
      threads, workspace: as in rollout_batch().

    The arguments of the step are those of rollout_batch(), or smoother ones: an exact step has the derivative 0 if nothing touches.

    Returns dL/dq_start (N, n_q) and dL/du (N, T, n_a). The derivative by a quaternion is tangent to the sphere of unit quaternions.

        >>> task = st.load_task("planar_pushing")
        >>> q = task.q_start[None]
        >>> u = q[:, None, 3:] + np.linspace(0, 0.2, 8)[None, :, None]
        >>> rolled = st.rollout_batch(task.model, q, u)
        >>> D_L_q = np.zeros_like(rolled.q)
        >>> D_L_q[:, -1, 1] = 1  # L: where the box ends along z
        >>> D_L_q_start, D_L_u = st.pull_back_rollout(task.model, rolled, u, D_L_q, smoothing=st.Analytic(kappa=100))
        >>> D_L_q_start.shape, D_L_u.shape
        ((1, 5), (1, 8, 2))

    Arguments of the step:
      h: time step [s], > 0.
      smoothing: Exact() (2.6), or Analytic(kappa=...) [1/J] (2.27).
      regularisation: regularisation of the objects: ByRule(ratio=...) (docs/theory/step.md), or FixedEpsilon(epsilon=...), where 1 is the true mass.
      friction_cone: SecondOrderCone(), or PolyhedralCone(rays=...).
      friction_law: law of exact steps. Anitescu: a sliding contact opens by mu |J_t dq|. Coulomb: a sliding contact stays closed (S.14).
      friction_scale: factor of every coefficient of friction, >= 0.
      contact_margin: distance that is added to the contact distance of the scene [m], >= 0.
      joint_limits: True: the joint limits are constraints of the step.
      effort_limits: True: a joint pushes with Model.effort at most (S.15). False: the spring forces have no limit.
      tol_complementarity: largest |v lambda| of a contact, divided by 5 L F h with the scales L and F of docs/theory/scales.md [-], in [1e-12, 1e-2].
      kappa, epsilon: deprecated; use smoothing=Analytic(kappa=...) and regularisation=FixedEpsilon(epsilon=...).

    Raises InvalidInput, which names the argument.
    """

class PairForce:
    """
    Contact force of one pair of geometries A and B, summed over its contact points.
    """

    @property
    def pair(self) -> int:
        """index into Model.pairs"""

    @property
    def normal(self) -> float:
        """normal force [N]"""

    @property
    def tangential(self) -> float:
        """magnitude of the friction force [N]"""

    @property
    def force_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """contact force on A, in W [N] (3)"""

    @property
    def friction_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """friction force, in W [N] (3)"""

    @property
    def p_WC(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """mean contact point in W, weighted by the normal forces [m] (3)"""

    @property
    def depth(self) -> float:
        """deepest penetration [m]"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class SimulationResult:
    """Result of simulate(): samples of the motion and of the forces."""

    @property
    def status(self) -> Status: ...

    @property
    def message(self) -> str:
        """reason of a numerical failure"""

    @property
    def times(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """times of the samples [s] (samples)"""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """configurations (samples, n_q)"""

    @property
    def v(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """velocities in tangent coordinates (samples, n_v) [m/s, rad/s]"""

    @property
    def torque(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """
        largest torque of each motor since the previous sample (samples, n_a) [N m or N]
        """

    @property
    def forces(self) -> list[list[PairForce]]:
        """
        for each sample, the forces of the pairs that touch, ordered by pair index
        """

    @property
    def max_depth(self) -> float:
        """deepest penetration [m]"""

    @property
    def steps(self) -> int:
        """number of time steps"""

    @property
    def wall_s(self) -> float:
        """wall time [s]"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Plant:
    """
    A model prepared for second-order simulation in MuJoCo. docs/theory/simulation.md explains the effect of each argument.

      model: Model of the scene.
      timestep: time step [s], > 0.
      damping_ratio: damping ratio of each joint spring with the inertia that the joint moves, >= 0.
      armature: least inertia of every motor, reflected to its joint [kg or kg m^2], >= 0. A joint has more if its file says so, or if its
        spring would turn by more than spring_resolution [rad] in a time step.
      time_constant: time constant of contacts in the normal direction [s].
      friction_time_constant: time constant with which slip decays [s].
      impedance: contact impedance, in (0, 0.9999]; 1 would be rigid.
      friction_stiffening: stiffness of friction relative to the normal direction, >= 1.
      noslip_iterations: number of solver sweeps that remove the remaining creep.
      friction_scale: factor of every coefficient of friction, >= 0.
      ground_softness: factor of both time constants for objects on fixed geometry, >= 1.
      velocity_reference: True: joint damping acts on the difference of commanded and actual velocity. False: it acts on the actual velocity.
      effort_limits: True: no motor gives more than Model.effort.
      joint_friction: True: robot joints have the dry friction of their files, and servos do not overcome their damping. Joints of objects always have
        both.

    Raises InvalidInput, which names the argument.
    """

    def __init__(self, model: Model, *, timestep: float = 0.0002, damping_ratio: float = 1.0, armature: float = 0.0, spring_resolution: float = 1.0, time_constant: float = 0.002, friction_time_constant: float = 0.02, impedance: float = 0.95, friction_stiffening: float = 100.0, noslip_iterations: int = 0, friction_scale: float = 1.0, ground_softness: float = 2.5, velocity_reference: bool | numpy.bool_ = False, effort_limits: bool | numpy.bool_ = False, joint_friction: bool | numpy.bool_ = False) -> None: ...

    @property
    def timestep(self) -> float:
        """time step [s]"""

    @property
    def damping(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """damping of the joint springs (n_a) [N s/m or N m s/rad]"""

    @property
    def armature(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """inertia of the motors (n_a) [kg or kg m^2]"""

    def __reduce__(self) -> tuple: ...

def simulate(plant: Plant, q0: numpy.typing.ArrayLike, times: numpy.typing.ArrayLike, u: numpy.typing.ArrayLike, *, v0: numpy.typing.ArrayLike | None = None, record_interval: float = 0.01, timeout_s: float | None = None) -> SimulationResult:
    """
    Simulates commands in MuJoCo, with inertia and impacts, from q0 to the last knot.

      plant: Plant of the model.
      q0: configuration at the start (n_q).
      times: times of the knots, increasing from 0 (knots) [s].
      u: commanded joint positions at the knots, linear between them (knots, n_a) [m or rad].
      v0: velocity at the start in tangent coordinates (n_v) [m/s, rad/s]. None: at rest.
      record_interval: time between two samples of the result [s], > 0.
      timeout_s: largest wall time [s], > 0. None: no limit.

    Returns a SimulationResult. Its status is Solved; MaxIterations: the time was used up; or NumericalFailure: `message` gives the reason.
    Raises InvalidInput.

        >>> task = st.load_task("planar_pushing")
        >>> run = st.simulate(st.Plant(task.model), task.q_start, [0.0, 0.5], [[0, 0], [0, 0.1]], record_interval=0.05)
        >>> run.status, run.q.shape
        (Status.Solved, (11, 5))
    """

class DrivenPlant:
    """
    A simulation that you advance tick by tick: an impedance controller turns joint commands into joint torques (C.7).

    Use it to test your own controller. Only one thread may use it at a time.

      plant: Plant(model, damping_ratio=0), since the impedance controller provides the damping.
      damping_ratio: damping ratio of each joint with the inertia that the joint moves, >= 0.
      velocity_cutoff, gain_cutoff: cut-off frequencies of the low-passes on joint velocities and on the damping [Hz], > 0.
      period: time between two torques, in whole time steps of the plant [s], > 0.

    Raises InvalidInput, which names the argument.

        >>> task = st.load_task("planar_pushing")
        >>> plant = st.DrivenPlant(st.Plant(task.model, damping_ratio=0))
        >>> plant.reset(task.q_start)
        >>> plant.advance([0.0, 0.02], 0.1), round(plant.time, 3)
        (Status.Solved, 0.1)
    """

    def __init__(self, plant: Plant, *, damping_ratio: float = 1.0, velocity_cutoff: float = 400.0, gain_cutoff: float = 1.0, period: float = 0.0002) -> None: ...

    def reset(self, q: numpy.typing.ArrayLike) -> None:
        """Resets the simulation: at rest in q (n_q) at time 0, without a push."""

    def set_push(self, body: str, p_BP: numpy.typing.ArrayLike, force_W: numpy.typing.ArrayLike) -> None:
        """
        Applies a constant force force_W [N] (3) from now on, at the point p_BP of a body, in its frame [m] (3). A zero force ends it.
        """

    def advance(self, command: numpy.typing.ArrayLike, duration: float) -> Status:
        """
        Simulates with a constant command.

          command: commanded joint positions (n_a) [rad or m].
          duration: time [s], > 0. It is rounded to whole periods of the impedance controller, at least one.

        Returns Solved, or NumericalFailure: `message` gives the reason, and only reset() continues from there.
        """

    @property
    def time(self) -> float:
        """simulated time [s]"""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """configuration (n_q)"""

    @property
    def v(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """velocity in tangent coordinates (n_v) [m/s, rad/s]"""

    @property
    def torque(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """joint torques (n_a) [N m or N]"""

    @property
    def external(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        external torques of contacts, joint stops and the push (n_a) [N m or N]; the argument tau of Sensor.sense
        """

    @property
    def damping(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """damping of the impedance controller (n_a) [N m s/rad or N s/m]"""

    @property
    def forces(self) -> list[PairForce]:
        """contact forces of the pairs that touch, ordered by pair index"""

    @property
    def message(self) -> str:
        """reason of a numerical failure"""

    def __reduce__(self) -> tuple: ...

class PlannerOptions:
    """
    Options of the planner. The attributes have the names and values of the section `planner` of a task file (tasks/schema/task.schema.json). dir() lists them, and planner_schema() explains them.
    """

    def __init__(self, model: Model, **values: object) -> None:
        """
        Options for a model: the defaults, changed by the keyword arguments. Raises InvalidInput: an unknown name, or a value out of range.
        """

    def replace(self, **changes: object) -> PlannerOptions:
        """
        Returns a copy of these options with the given changes. A change replaces the whole value of an option; None restores its default. Raises InvalidInput.

            >>> options = st.load_task("planar_pushing").options
            >>> options.replace(goal_bias=0.25).goal_bias
            0.25
        """

    def to_dict(self) -> dict[str, object]:
        """Returns all options as a dict from name to value."""

    def __getattr__(self, name: str, /) -> Any: ...

    def __dir__(self) -> list[str]: ...

    def __eq__(self, other: object, /) -> bool: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def planner_schema() -> dict[str, object]:
    """
    Returns the JSON schema of the section `planner` of a task file. It gives the meaning, unit and range of every option.

        >>> "goal_bias" in st.planner_schema()["properties"]
        True
    """

class Goal:
    """Target pose of an object, with tolerances."""

    @property
    def object(self) -> int:
        """index of the object"""

    @property
    def X_WG(self) -> Pose:
        """target pose of the object in W"""

    @property
    def open(self) -> list[bool]:
        """
        for each velocity coordinate of the objects (n_vu), True if any value is accepted; empty: all coordinates count
        """

    @property
    def tol_position(self) -> float:
        """tolerance of the position [m]"""

    @property
    def tol_angle(self) -> float:
        """tolerance of the rotation angle [rad]"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class GoalError:
    """Distance of an object from its goal."""

    @property
    def position(self) -> float:
        """distance of the positions [m]"""

    @property
    def angle(self) -> float:
        """angle of the rotation between the orientations [rad]"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Task:
    """
    A scene with robots and objects, a start configuration, a goal for an object, and planner options.
    """

    def __init__(self, task: dict, *, base: str | os.PathLike | None = None) -> None:
        """
        Makes a task in memory, without a task file.

          task: dict with the keys of a task file (tasks/schema/task.schema.json). Its values may also be arrays, Pose objects, paths, and robots
            as text.
          base: folder to which paths in the dict are relative. None: the working folder.

        Raises InvalidInput with the text "field: got …, expected …".

            >>> folder = st.load_task("planar_pushing").file.parent
            >>> task = st.Task({"base": "planar_pushing.yaml", "name": "wide", "tolerance": {"position": 0.05, "angle": 0.2}}, base=folder)
            >>> task.name, task.goal.tol_position
            ('wide', 0.05)
        """

    @property
    def name(self) -> str:
        """name of the task"""

    @property
    def description(self) -> str:
        """one line about the task"""

    @property
    def file(self) -> pathlib.Path:
        """
        path of the task file; for a task made in memory, the folder to which its paths are relative
        """

    @property
    def text(self) -> str:
        """text of a task made in memory, as in a task file; otherwise empty"""

    @property
    def model(self) -> Model:
        """model of the scene"""

    @property
    def q_start(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """start configuration (n_q)"""

    @property
    def q_goal(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        configuration of the objects at the goal (n_qu); for a goal region, its point nearest to the start
        """

    @property
    def goal(self) -> Goal:
        """target pose and tolerances"""

    @property
    def goal_objects(self) -> list[int]:
        """
        indices of the objects that the goal names, ascending; an object that carries another named object through a joint is left out
        """

    @property
    def options(self) -> PlannerOptions:
        """planner options of the task"""

    @property
    def scene_sha256(self) -> str:
        """SHA-256 of the scene; plans store it"""

    def with_(self, *, start: numpy.typing.ArrayLike | None = None, goal: Sequence[float | None] | numpy.typing.ArrayLike | None = None, options: PlannerOptions | dict | None = None) -> Task:
        """
        Returns a copy of the task with another start, goal or options. The task itself does not change.

          start: start configuration (n_q).
          goal: numbers as in set_goal().
          options: PlannerOptions, or a dict with the options to change.

        None keeps the value of the task. Raises InvalidInput.

            >>> task = st.load_task("planar_pushing")
            >>> other = task.with_(goal=[0.6, 0.1, 0.0], options={"goal_bias": 0.3})
            >>> other.q_goal, other.options.goal_bias
            (array([0.6, 0.1, 0. ]), 0.3)
        """

    def goal_errors(self, q: numpy.typing.ArrayLike) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """
        Returns the distance of the object from the goal, or from the nearest pose of a goal region, at many configurations.

          q: configurations (N, n_q).

        Returns position [m] and angle [rad] for each (N, 2).
        """

    def as_plan(self) -> Plan:
        """
        Returns a plan that stays at the start, to show, export or compare the task without planning. Its status is MaxIterations, unless the start is at the goal.
        """

    def follow(self, u: numpy.typing.ArrayLike, *, u_start: numpy.typing.ArrayLike | None = None) -> Plan:
        """
        Simulates commands from the start with the dynamics of the planner, and returns the motion as a plan with one push.

          u: commands (N, n_a) [m or rad].
          u_start: commands at the start (n_a) [m or rad]. None: each joint is commanded to its start position.

        The status of the plan is Solved if it ends at the goal, and MaxIterations otherwise. If a step has no solution, the plan ends there and
        has the status of that step. Raises InvalidInput.

            >>> task = st.load_task("planar_pushing")
            >>> plan = task.follow([[0.0, 0.0], [0.0, 0.1]])
            >>> plan.status, plan.u[-1]
            (Status.MaxIterations, array([0. , 0.1]))
        """

    def set_goal(self, values: Sequence[float | None] | numpy.typing.ArrayLike) -> None:
        """
        Replaces the goal of the task; the tolerances stay.

          values: for a free object x y z [m] roll pitch yaw [rad], for any other object its coordinates. Several objects follow one another. None
            in place of a number accepts any value of this coordinate.

        Raises InvalidInput.
        """

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def list_tasks() -> list[str]:
    """
    Returns the names of the built-in tasks.

        >>> "allegro_cube" in st.list_tasks()
        True
    """

def _import_scene(file: str | os.PathLike, *, out: str | os.PathLike | None = None, object: str = '') -> Task:
    """Of scenes.py: an MJCF or URDF file."""

def _parse_task(text: str, base: str | os.PathLike | None = None) -> Task:
    """Of scenes.py: the text of a task file."""

def list_keyframes(file: str | os.PathLike) -> list[str]:
    """
    Returns the names of the keyframes of an MJCF file. The key `start` of a task accepts them. Raises InvalidInput.

        >>> with open("keyed.xml", "w") as file:
        ...     _ = file.write("<mujoco><worldbody><body><joint name='j' type='slide'/><geom size='.1'/></body></worldbody>"
        ...                    "<keyframe><key name='home' qpos='.5'/></keyframe></mujoco>")
        >>> st.list_keyframes("keyed.xml")
        ['home']
    """

def load_task(name_or_file: str | str | os.PathLike) -> Task:
    """
    Loads a task: a scene with a start, a goal and planner options.

      name_or_file: name of a built-in task, or a task file. A str that ends in .yaml or .yml or contains a '/' is a file, and so is any
        os.PathLike.

    Returns a Task. Raises InvalidInput with the text "FILE:LINE: field: got …, expected …".

        >>> task = st.load_task("allegro_cube")
        >>> task.model.n_a, task.model.object_names
        (16, ['cube'])
    """

class SegmentKind(enum.Enum):
    """Kind of a segment of a plan."""

    Settle = 0
    """
    objects come to rest from the given start, without overlaps (first segment only)
    """

    Contact = 1
    """the robot pushes an object"""

    Regrasp = 2
    """the robot moves to new contacts while the object rests"""

class Progress:
    """Argument of the function `on_progress` of long calls."""

    @property
    def iteration(self) -> int:
        """number of iterations so far"""

    @property
    def fraction(self) -> float:
        """share of the budget that is used, in [0, 1]"""

    @property
    def best(self) -> float:
        """smallest distance to the goal so far, or lowest cost"""

    @property
    def size(self) -> int:
        """size of the search, such as the number of nodes"""

    @property
    def elapsed_s(self) -> float:
        """wall time since the start [s]"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Growth:
    """New nodes of a search tree since the last call of `on_growth`."""

    @property
    def tree(self) -> int:
        """
        index of the tree, from 0; trees grow side by side, and a tree that stalls is replaced by a new one
        """

    @property
    def first(self) -> int:
        """index of the first new node in its tree"""

    @property
    def parents(self) -> list[int]:
        """index of each node's parent in the tree; -1 for the root (nodes)"""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """configurations (nodes, n_q) [m, rad]"""

    @property
    def u(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """commands at the configurations (nodes, n_a) [m or rad]"""

    @property
    def best(self) -> int:
        """index of the node that is nearest the goal"""

    @property
    def best_ratio(self) -> float:
        """distance of this node from the goal, in tolerances"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class TreeNode:
    """A node of the search tree of Algorithm 2."""

    @property
    def parent(self) -> int:
        """index of the parent; -1 for the root"""

    @property
    def edge(self) -> SegmentKind:
        """kind of the edge from the parent"""

    @property
    def iteration(self) -> int:
        """number of extensions when the node was added"""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """configuration (n_q)"""

    @property
    def c_u(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """configuration of the objects after a smoothed step (n_qu)"""

    @property
    def B_u(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')]:
        """rows of B for the objects (n_vu, n_a)"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class RefusedMoves:
    """
    Regrasps that were tried from one node of a search tree, of which some were refused.
    """

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """configuration of the node (n_q)"""

    @property
    def counts(self) -> dict[str, int]:
        """counts by cause, as in PlanResult.regrasps"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class PlanContact:
    """
    An active contact at a knot of a plan. Numbers are rounded to 1e-6 if the plan was read from a file.
    """

    @property
    def a(self) -> str:
        """name of the first geometry, as body/geometry"""

    @property
    def b(self) -> str:
        """name of the second geometry"""

    @property
    def point(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """contact point in W, on the surface of b before the sub-step [m] (3)"""

    @property
    def normal(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """unit normal in W, from b to a (3)"""

    @property
    def force(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """
        contact force in W, which acts on a; the opposite force acts on b [N] (3)
        """

    @property
    def friction(self) -> float:
        """friction coefficient of the pair"""

    @property
    def gap(self) -> float:
        """signed distance before the sub-step [m]"""

    @property
    def moment(self) -> float:
        """moment about the normal, which acts on a [N m]"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Trajectory:
    """
    A plan with times: commands, linear between knots, and the configurations that the plan predicts.
    """

    @property
    def times(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """times of the knots, from 0 [s] (knots)"""

    @property
    def u(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """commands (knots, n_a) [m or rad]"""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """predicted configurations (knots, n_q)"""

    @property
    def segments(self) -> Annotated[NDArray[numpy.int32], dict(shape=(None,), order='C')]:
        """index of the plan's segment that leads to each knot (knots)"""

    @property
    def knots(self) -> Annotated[NDArray[numpy.int32], dict(shape=(None,), order='C')]:
        """
        row of Plan.q for each knot: the end of the sub-step that the knot belongs to (knots)
        """

    @property
    def speed(self) -> float:
        """factor on the full speed of make_trajectory()"""

    @property
    def duration(self) -> float:
        """time of the last knot [s]"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

OPEN_LOOP_SPEED: float = 0.1

def make_trajectory(plan: Plan, *, speed: float = 0.1, pause: float = 0.0) -> Trajectory:
    """
    Gives times to the commands of a plan, for execution without feedback.

    The full speed follows from the object of the goal and from the motors (E.8), (E.13). If an object moves on a damped joint, the commands
    lead the plan to compensate the damping (E.17).

      speed: factor on the full speed, > 0. A factor above 1 makes only pushes faster. Without feedback most plans succeed at the default of
        0.1, and few succeed at 1. At any speed, no command is faster than the `velocity` of the URDF.
      pause: time for which the command is constant between pushes and regrasps [s], >= 0.

    Returns a Trajectory. Raises InvalidInput.

        >>> plan = st.plan(st.load_task("planar_pushing"), seed=0).plan
        >>> trajectory = st.make_trajectory(plan, speed=0.5)
        >>> trajectory.u.shape == (len(trajectory.times), 2), float(trajectory.times[0]), trajectory.speed
        (True, 0.0, 0.5)
    """

class Segment:
    """
    A part of a plan with one kind of motion; its knots are one sub-step apart.
    """

    @property
    def kind(self) -> SegmentKind:
        """Settle, Contact or Regrasp"""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """configurations (knots, n_q)"""

    @property
    def u(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """commands (knots, n_a) [m or rad]"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Plan:
    """
    Commands and predicted configurations from the start towards the goal, together with the task.

    A plan is a sequence of segments: plan[i] is a Segment and plan[i:j] is a Plan. It can be pickled.

        >>> plan = st.plan(st.load_task("planar_pushing"), seed=0).plan
        >>> plan.q.shape == (len(plan.u), 5), len(plan) == len(plan.segments)
        (True, True)
        >>> first = plan[:1]
        >>> first.q.shape == (1 + len(plan[0].q), 5)
        True
    """

    @property
    def task(self) -> Task:
        """task that the plan was made for"""

    @property
    def options(self) -> PlannerOptions:
        """options with which the plan was made"""

    @property
    def status(self) -> Status:
        """Solved: the plan reaches the goal"""

    @property
    def seed(self) -> int:
        """seed of the search"""

    @property
    def error(self) -> GoalError:
        """distance of the object from the goal at the last knot"""

    @property
    def h(self) -> float:
        """time step of one knot [s]"""

    @property
    def segments(self) -> list[Segment]:
        """list of the segments"""

    def __len__(self) -> int: ...

    def __iter__(self) -> Iterator[Segment]: ...

    @overload
    def __getitem__(self, index: int) -> Segment:
        """Returns one segment. Raises IndexError."""

    @overload
    def __getitem__(self, segments: slice) -> Plan:
        """
        Returns neighbouring segments as a plan. It starts at the end of the preceding segment, and is Solved if it ends at the goal. Raises InvalidInput: no segment.
        """

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """predicted configurations, the start first (knots + 1, n_q)"""

    @property
    def u(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """commands, the start first (knots + 1, n_a) [m or rad]"""

    def write(self, file: str | os.PathLike) -> None:
        """
        Writes the plan to a file, which read_plan() and the commands of the program read (docs/plan_file.md). Raises InvalidInput.
        """

    @property
    def contacts(self) -> list[list[PlanContact]]:
        """
        for each row of q, the contacts that were active in the sub-step before it (knots + 1); none at the start
        """

    def export(self, file: str | os.PathLike, *, format: str | None = None, trajectory: Trajectory | None = None) -> list[pathlib.Path]:
        """
        Writes the motion over time in a format of other programs (docs/exports.md).

        The file holds joint positions, commands, velocities, torques, object poses and contacts.

          file: the file to write, or the folder for the format lerobot.
          format: csv, npz, json, mcap or lerobot. None: the suffix of the file name decides.
          trajectory: from make_trajectory(). None: a trajectory at the default speed.

        Returns the paths of the written files. Raises InvalidInput; MissingExtra: mcap needs `pip install stiction[mcap]`.

            >>> plan = st.plan(st.load_task("planar_pushing"), seed=0).plan
            >>> [file.name for file in plan.export("motion.csv")]
            ['motion.csv', 'motion.contacts.csv']
            >>> with np.load(plan.export("motion.npz")[0]) as motion:
            ...     motion["q"].shape == (len(motion["time"]), 2)
            True
        """

    def to_text(self, folder: str | os.PathLike | None = None) -> str:
        """
        Returns the text of the plan file. The path of the task in it is relative to `folder`; None: the working folder.
        """

    def __getstate__(self) -> tuple[str, str]: ...

    def __setstate__(self, arg: tuple[str, str], /) -> None: ...

    def __repr__(self) -> str: ...

def read_plan(file: str | os.PathLike) -> Plan:
    """
    Reads a plan from a file, or from a folder that has a plan.json, and loads the task that the plan was made for.

    Raises InvalidInput with the text "FILE: field: got …, expected …", also if the scene of the task has changed since.

        >>> plan = st.plan(st.load_task("planar_pushing"), seed=0).plan
        >>> plan.write("plan.json")
        >>> bool((st.read_plan("plan.json").q == plan.q).all())
        True
    """

def parse_plan(text: str, folder: str | os.PathLike | None = None) -> Plan:
    """
    Makes a plan from the text of a plan file, as Plan.to_text() returns it.

      folder: folder to which the path of the task in the text is relative. None: the working folder.

    Raises InvalidInput.

        >>> plan = st.plan(st.load_task("planar_pushing"), seed=0).plan
        >>> st.parse_plan(plan.to_text()).seed
        0
    """

class RefineResult:
    """Result of refine(): the refined plan and what changed."""

    @property
    def status(self) -> Status:
        """see refine()"""

    @property
    def plan(self) -> Plan:
        """the refined plan, or the given plan if it could not be refined"""

    @property
    def variant(self) -> str:
        """kind of the result: refined or unchanged"""

    @property
    def pushes(self) -> tuple[int, int]:
        """number of pushes (before, after)"""

    @property
    def regrasps(self) -> tuple[int, int]:
        """number of regrasps (before, after)"""

    @property
    def least_clearance(self) -> float:
        """
        smallest clearance of the regrasps that were planned again [m]; 0: there was no such regrasp
        """

    @property
    def rest_planned_anew(self) -> int:
        """
        number of searches for the rest of the plan after a push that missed its end in small steps
        """

    @property
    def steps(self) -> int:
        """number of steps that were simulated"""

    @property
    def failed_steps(self) -> int:
        """number of steps without a solution"""

    @property
    def wall_s(self) -> float:
        """wall time [s]"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def refine(plan: Plan, *, options: PlannerOptions | dict | None = None, threads: int | None = None, timeout_s: float = 20.0, on_progress: Callable[[Progress], bool | None] | None = None) -> RefineResult:
    """
    Shortens a plan and gives its regrasps more clearance (docs/theory/refinement.md). Use it before a plan is executed.

    Refinement drops pushes that move nothing, follows the others in small time steps, and plans the motions between them again.

      plan: a plan with the status Solved.
      options: PlannerOptions, or a dict with the options to change. None: the options with which the plan was made.
      threads: 0: all cores. None: as in the options. The result does not depend on this number.
      timeout_s: largest wall time [s], > 0.
      on_progress: function that is called with Progress. Ctrl-C, an error in the function or the return value False stop the refinement.

    Returns a RefineResult. Its status is Solved; MaxIterations (time used up) or Cancelled: its plan is the given plan; NumericalFailure: the given plan does not reach its goal. Raises InvalidInput.

        >>> plan = st.plan(st.load_task("planar_pushing"), seed=0).plan
        >>> refined = st.refine(plan)
        >>> refined.status, st.check_plan(refined.plan).pass_
        (Status.Solved, True)
    """

class CheckItem:
    """One result of check_plan(): a value and its limit."""

    @property
    def name(self) -> str:
        """name of the item"""

    @property
    def value(self) -> float:
        """measured value, in `unit`"""

    @property
    def limit(self) -> float | None:
        """largest value that passes; None: the value is reported but not judged"""

    @property
    def unit(self) -> str:
        """unit of value and limit, such as m; empty: no unit"""

    @property
    def pass_(self) -> bool:
        """True: the value is within the limit"""

    @property
    def where(self) -> str:
        """body, joint or knot with the worst value; may be empty"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class CheckReport:
    """Result of check_plan(): the verdict and the items behind it."""

    @property
    def pass_(self) -> bool:
        """True: the plan passed every check"""

    @property
    def status(self) -> Status:
        """Solved: all checks were made"""

    @property
    def items(self) -> list[CheckItem]:
        """results of the single checks"""

    def at(self, name: str) -> CheckItem:
        """Returns the item of this name. Raises InvalidInput: no such item."""

    @property
    def knots(self) -> int:
        """number of knots that were checked"""

    @property
    def steps(self) -> int:
        """number of steps that were simulated"""

    @property
    def threshold_N(self) -> float:
        """contacts with a smaller force than this are ignored [N]"""

    @property
    def wall_s(self) -> float:
        """wall time [s]"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def check_plan(plan: Plan) -> CheckReport:
    """
    Checks a plan independently of the planner: does it reach the goal, and are its forces physically possible?

    The check simulates the plan again with the exact dynamics, at half of the plan's sub-step. It compares the numbers stored in the plan with
    this simulation and with the task, and shares no planning code with the planner.

    Returns a CheckReport: its attribute pass_ is the verdict, and its items give the single checks.

        >>> report = st.check_plan(st.plan(st.load_task("planar_pushing"), seed=0).plan)
        >>> report.pass_, report.at("goal_position").unit
        (True, 'm')
    """

class PlanResult:
    """Result of plan(): the plan, its status, and statistics of the search."""

    @property
    def plan(self) -> Plan:
        """best plan found, also if the status is not Solved"""

    @property
    def status(self) -> Status: ...

    @property
    def reason(self) -> str:
        """why there is no solution, if the reason is not a used-up budget"""

    @property
    def options(self) -> PlannerOptions:
        """options with which the plan was made"""

    @property
    def seed(self) -> int: ...

    @property
    def cost(self) -> float:
        """
        cost of the plan: duration of its commands plus a cost for each regrasp [s]
        """

    @property
    def start_penetration(self) -> float:
        """deepest penetration in the given start [m], >= 0"""

    @property
    def iterations(self) -> int:
        """number of extensions of the trees"""

    @property
    def linearisations(self) -> int:
        """number of smoothed steps with the derivative B"""

    @property
    def nodes(self) -> int:
        """number of nodes"""

    @property
    def steps(self) -> int:
        """number of exact steps"""

    @property
    def failed_steps(self) -> int:
        """number of steps without a solution"""

    @property
    def profile(self) -> dict[str, tuple[float, int]]:
        """
        processor time [s] and number of calls for each activity: {name: (time, calls)}; all 0 with the option `thesis`
        """

    @property
    def regrasps(self) -> dict[str, int]:
        """
        number of regrasps that were tried and accepted, and the number refused for each cause
        """

    @property
    def refused(self) -> list[RefusedMoves]:
        """
        nodes from which regrasps were refused before a plan was found; empty with the option `thesis`
        """

    @property
    def wall_s(self) -> float:
        """wall time of the search [s]"""

    @property
    def tree(self) -> list[TreeNode]:
        """
        nodes of the search tree, the root first; only with the option `thesis`
        """

    @property
    def tree_errors(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """
        distance of each node of `tree` from the goal: position [m], angle [rad] (nodes, 2)
        """

    def packing_ratio(self, threshold: float = 3.0, samples: int = 1000, seed: int = 0) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        Packing ratio (3.9) of the search tree after each of its nodes (nodes).

        The packing ratio is the share of sampled configurations that lie within `threshold` of a node.

          threshold: η in (3.9), > 0.
          samples: number of configurations, drawn from the sample boxes of the task.
          seed: of these samples.

        The regularisation γ is the value of the task.
        """

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def plan(task: Task, *, q_start: numpy.typing.ArrayLike | None = None, u_start: numpy.typing.ArrayLike | None = None, options: PlannerOptions | dict | None = None, seed: int | None = None, threads: int | None = None, timeout_s: float = 20.0, on_progress: Callable[[Progress], bool | None] | None = None, on_growth: Callable[[Growth], None] | None = None) -> PlanResult:
    """
    Searches for a motion of the robot that moves the object from the start to the goal of a task (Algorithms 2 and 3).

      task: Task with the model, the start and the goal.
      q_start: measured configuration from which to plan (n_q). Overlaps of bodies are removed first. None: the start of the task.
      u_start: measured commands at q_start (n_a) [m or rad]; they give the load of the joint springs at the start. None: each joint is
        commanded to its position in q_start.
      options: PlannerOptions, or a dict with the options to change. None: the options of the task.
      seed: of the random samples. None: the seed of the options.
      threads: 0: all cores. None: as in the options. The plan does not depend on this number.
      timeout_s: largest wall time [s], > 0.
      on_progress: function that is called with Progress. Ctrl-C or an error in the function stops the search. The return value False also
        stops the search, and plan() returns the best plan so far with the status Cancelled.
      on_growth: function that is called with Growth, the new nodes of a search tree. It does not change the plan.

    Returns a PlanResult. Its status is Solved; MaxIterations: the time or the budget was used up, or see `reason`; Cancelled; or
    NumericalFailure: the objects do not come to rest at the start. Raises InvalidInput.

        >>> task = st.load_task("planar_pushing")
        >>> result = st.plan(task, seed=0)
        >>> result.status, st.check_plan(result.plan).pass_
        (Status.Solved, True)
        >>> st.plan(task, seed=0, on_progress=lambda progress: False).status
        Status.Cancelled
    """

class CostTerms:
    """Terms of the cost of a trajectory (T.1)."""

    @property
    def objects(self) -> float:
        """tracking error of the objects before the final time"""

    @property
    def objects_final(self) -> float:
        """tracking error of the objects at the final time"""

    @property
    def robots(self) -> float:
        """tracking error of the robots before the final time"""

    @property
    def robots_final(self) -> float:
        """tracking error of the robots at the final time"""

    @property
    def input(self) -> float:
        """changes of the command between steps"""

    @property
    def total(self) -> float:
        """sum of the terms"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class IterationLog:
    """One iteration of optimize()."""

    @property
    def cost(self) -> CostTerms:
        """cost of the trajectory after this iteration"""

    @property
    def best(self) -> float:
        """lowest total cost so far"""

    @property
    def length(self) -> float:
        """length of the accepted step, 1: the full step; 0: no step was accepted"""

    @property
    def sharpness(self) -> float:
        """
        smoothing of the iteration: kappa [1/J], or the largest standard deviation of u [rad or m]; 0: exact
        """

    @property
    def qp_iterations(self) -> int:
        """number of iterations of the QP solver"""

    @property
    def failed_models(self) -> int:
        """number of time steps whose local model had no solution"""

    @property
    def elapsed_s(self) -> float:
        """wall time since the start [s]"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class OptimizeResult:
    """
    Result of optimize(): the best trajectory and the history of the iterations.
    """

    @property
    def status(self) -> Status: ...

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """configurations of the best trajectory (T + 1, n_q)"""

    @property
    def u(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """commands of the best trajectory (T, n_a) [m or rad]"""

    @property
    def cost(self) -> CostTerms:
        """cost of the best trajectory"""

    @property
    def history(self) -> list[IterationLog]:
        """iterations, the initial guess first"""

    @property
    def steps(self) -> int:
        """number of steps that were computed"""

    @property
    def linearisations(self) -> int:
        """number of local models that were computed"""

    @property
    def wall_s(self) -> float:
        """wall time [s]"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def optimize(task: Task, *, scheme: str | None = None, solver: str | None = None, iterations: int | None = None, forces: bool | numpy.bool_ = False, seed: int | None = None, timeout_s: float = 60.0, threads: int = 0, on_progress: Callable[[Progress], bool | None] | None = None, section: dict | None = None, reference: numpy.typing.ArrayLike | None = None, u_guess: numpy.typing.ArrayLike | None = None, u_before: numpy.typing.ArrayLike | None = None) -> OptimizeResult:
    """
    Optimises a trajectory through contact by iterative MPC (iMPC, Alg. 1).

    Use it to improve a motion near an initial guess; plan() searches for a motion from scratch. The section `optimize` of the task gives the
    weights, the horizon and the defaults.

      task: Task with a section `optimize`.
      scheme: local model: exact, analytic, randomized-first or randomized-zeroth. None: as in the task.
      solver: sweep or receding. None: as in the task.
      iterations: largest number of iterations. None: as in the task.
      forces: True: use the contact trust region.
      seed: of the randomised schemes. None: as in the task.
      timeout_s: largest wall time [s], > 0.
      threads: 0: all cores. The result does not depend on this number.
      on_progress: function that is called with Progress. Ctrl-C, an error in the function or the return value False stop the optimisation.
      section: dict with the keys of the section `optimize`, which replaces the section of the task.
      reference: configurations to track, the start first (T + 1, n_q). The step has the options of the planner then. None: the goal at all times.
      u_guess: initial guess of the commands (T, n_a) [m or rad]. None: the commands of the start at all times.
      u_before: command before the first one (n_a) [m or rad]. None: the joint positions of the start.

    Returns an OptimizeResult. Its status is Solved; or MaxIterations (time used up) or Cancelled, with the best trajectory so far. Raises
    InvalidInput.

        >>> result = st.optimize(st.load_task("impc_planar_pushing"), iterations=2)
        >>> result.status, len(result.q) == len(result.u) + 1
        (Status.Solved, True)
    """

class Finding:
    """Likely mistake in a task, as lint() reports it."""

    @property
    def kind(self) -> str:
        """kind of the mistake"""

    @property
    def message(self) -> str:
        """
        field or body, the value that was found, and the value that was likely meant
        """

    @property
    def where(self) -> str:
        """start or goal, if the mistake is in one of them; otherwise empty"""

    @property
    def names(self) -> list[str]:
        """names of the geometries (body/geometry) or of the object"""

    @property
    def p_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')] | None:
        """
        place of an overlap or a gap in W, halfway between the nearest points [m] (3)
        """

    @property
    def amount(self) -> float | None:
        """
        depth of an overlap, width of a gap, or distance by which the robot cannot reach [m]
        """

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def lint(task: Task) -> list[Finding]:
    """
    Checks a task for likely mistakes before you plan it: overlaps, objects without support, goals out of reach, and wrong units.

    Returns a list of Finding; an empty list if nothing was found.

        >>> st.lint(st.load_task("planar_pushing"))
        []
    """

class SolveRun:
    """One run of a plan in the second-order simulation, without feedback."""

    @property
    def friction(self) -> float:
        """factor of every coefficient of friction"""

    @property
    def status(self) -> Status:
        """Solved: the run came to its end"""

    @property
    def reached(self) -> bool:
        """True: the object is within the tolerances of the goal"""

    @property
    def dropped(self) -> bool:
        """True: an object fell"""

    @property
    def lost(self) -> bool:
        """True: the object is too far from its plan, and the run was ended"""

    @property
    def duration_s(self) -> float:
        """simulated time [s]"""

    @property
    def error(self) -> GoalError:
        """distance of the object from the goal at the end"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class SolveTry:
    """Result of solve() for one seed."""

    @property
    def seed(self) -> int:
        """seed of the search"""

    @property
    def status(self) -> Status:
        """status of the search"""

    @property
    def reason(self) -> str:
        """why the search has no solution"""

    @property
    def plan(self) -> Plan:
        """refined plan, if there is one"""

    @property
    def accepted(self) -> bool:
        """True: check_plan() accepts the plan"""

    @property
    def runs(self) -> list[SolveRun]:
        """
        one run for each friction factor; only the first run if that misses the goal
        """

    @property
    def holds(self) -> bool:
        """True: every run reached the goal"""

    @property
    def plan_s(self) -> float:
        """wall time of planning [s]"""

    @property
    def refine_s(self) -> float:
        """wall time of refinement [s]"""

    @property
    def simulate_s(self) -> float:
        """wall time of simulation [s]"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class SolveResult:
    """Result of solve(): the best try and all tries."""

    @property
    def status(self) -> Status:
        """see solve()"""

    @property
    def best(self) -> SolveTry:
        """the first try whose runs all reach the goal, or else the best try"""

    @property
    def tries(self) -> list[SolveTry]:
        """all tries, in the order of their seeds"""

    @property
    def wall_s(self) -> float:
        """wall time [s]"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def solve(task: Task, *, options: PlannerOptions | dict | None = None, seed: int | None = None, tries: int = 20, friction: Sequence[float] = [1.0], speed: float = 0.1, threads: int = 0, timeout_s: float = 120.0, on_progress: Callable[[Progress], bool | None] | None = None) -> SolveResult:
    """
    Searches for a plan that reaches its goal in the second-order simulation, without feedback.

    For one seed after the other it plans, refines, checks and simulates, until a plan reaches the goal under every friction factor.

      task: Task.
      options: of the planner: PlannerOptions, or a dict with the options to change. None: the options of the task.
      seed: of the first try; the following tries count up from it. None: the seed of the options.
      tries: largest number of tries, >= 1.
      friction: factors of every coefficient of friction, >= 0. The plan has to reach the goal with each of them.
      speed: of the simulated runs, a factor on the full speed that follows from the object and the motors (E.13), > 0. A factor above 1 makes
        only pushes faster.
      threads: 0: all cores. The result does not depend on this number.
      timeout_s: largest wall time of all tries [s], > 0.
      on_progress: function that is called with Progress. Ctrl-C, an error in the function or the return value False stop the search.

    Returns a SolveResult. Its status is Solved: all runs of `best` reach the goal; MaxIterations: no such plan was found, or the time was used
    up; or Cancelled. Raises InvalidInput.

        >>> found = st.solve(st.load_task("planar_pushing"), seed=0, tries=1, speed=20.0)
        >>> [(one.seed, one.status) for one in found.tries]
        [(0, Status.Solved)]
    """

class PieceError:
    """
    Difference of the planned and the simulated object pose over one push or regrasp (3.10)-(3.12).
    """

    @property
    def mean_position(self) -> float:
        """mean position error over time (3.10) [m]"""

    @property
    def mean_angle(self) -> float:
        """mean angle error over time (3.10) [rad]"""

    @property
    def start_position(self) -> float:
        """position error at the start [m]"""

    @property
    def start_angle(self) -> float:
        """angle error at the start [rad]"""

    @property
    def end_position(self) -> float:
        """position error at the end [m]"""

    @property
    def end_angle(self) -> float:
        """angle error at the end [rad]"""

    @property
    def length_position(self) -> float:
        """length of the object's planned path (3.12) [m]"""

    @property
    def length_angle(self) -> float:
        """rotation along the object's planned path (3.12) [rad]"""

    @property
    def normalised_position(self) -> float | None:
        """
        mean position error divided by the path length (3.11); None: the plan moves the object by less than a thousandth of its length
        """

    @property
    def normalised_angle(self) -> float | None:
        """
        mean angle error divided by the planned rotation (3.11); None: the plan does not turn the object
        """

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class PieceReport:
    """Errors of one push or regrasp in the simulation."""

    @property
    def kind(self) -> SegmentKind:
        """Contact or Regrasp"""

    @property
    def first_segment(self) -> int:
        """index of its first segment in the plan"""

    @property
    def last_segment(self) -> int:
        """index of its last segment in the plan"""

    @property
    def begin_s(self) -> float:
        """simulated time of its start [s]"""

    @property
    def end_s(self) -> float:
        """simulated time of its end [s]"""

    @property
    def in_plan(self) -> PieceError | None:
        """
        errors in the run of the whole plan, errors of earlier pieces included; None: that run ended earlier
        """

    @property
    def alone(self) -> PieceError | None:
        """errors in a run that starts from the planned state; None for regrasps"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class TransferResult:
    """
    Result of transfer(): a plan executed without feedback, compared with its prediction.
    """

    @property
    def status(self) -> Status: ...

    @property
    def message(self) -> str:
        """reason of a numerical failure"""

    @property
    def pieces(self) -> list[PieceReport]:
        """errors of each push and regrasp"""

    @property
    def error(self) -> GoalError:
        """distance of the object from the goal at the end"""

    @property
    def reached(self) -> bool:
        """
        True: the whole plan was run, and the object is within the tolerances of the goal
        """

    @property
    def dropped(self) -> int | None:
        """index of the first object that fell, or None"""

    @property
    def dropped_s(self) -> float:
        """simulated time at which the object fell [s]"""

    @property
    def max_depth(self) -> float:
        """deepest penetration [m]"""

    @property
    def duration_s(self) -> float:
        """simulated duration of the run [s]"""

    @property
    def times(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """times of the samples [s] (samples)"""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """simulated configurations (samples, n_q)"""

    @property
    def q_plan(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """planned configurations (samples, n_q)"""

    @property
    def piece(self) -> list[int]:
        """index into `pieces` (samples)"""

    @property
    def wall_s(self) -> float:
        """wall time [s]"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class SpeedLimits:
    """
    Fixed speed limits of commands, which do not depend on the object or the robot (E.1), (E.8), (E.9).
    """

    def __init__(self, *, revolute: float = 0.1, prismatic: float = 0.0125, regrasp_factor: float = 4.0, load_time: float = 0.5, pause: float = 4.0) -> None:
        """
        Fixed speed limits.

          revolute, prismatic: largest speed of a command during pushes [rad/s], [m/s], > 0.
          regrasp_factor: regrasps are this many times as fast, > 0.
          load_time: time in which joint springs take up the weight of the lightest object [s], >= 0.
          pause: time for which the command is constant between pushes and regrasps [s], >= 0.

        Raises InvalidInput.
        """

    @property
    def revolute(self) -> float:
        """largest speed of revolute joints in pushes [rad/s]"""

    @property
    def prismatic(self) -> float:
        """largest speed of prismatic joints in pushes [m/s]"""

    @property
    def regrasp_factor(self) -> float:
        """factor on the speeds in regrasps"""

    @property
    def load_time(self) -> float:
        """time in which springs take up the weight of the lightest object [s]"""

    @property
    def pause(self) -> float:
        """time of constant commands between pushes and regrasps [s]"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def transfer(plan: Plan, *, speed: float = 0.1, pause: float = 0.0, uniform: SpeedLimits | None = None, substeps: int | None = None, rest_time: float = 0.05, friction_scale: float = 1.0, mass_scale: float = 1.0, start_error: numpy.typing.ArrayLike | None = None, velocity_reference: bool | numpy.bool_ = True, hold: float = 4.0, whole: bool | numpy.bool_ = True, alone: bool | numpy.bool_ = True, threads: int = 0, timeout_s: float | None = None) -> TransferResult:
    """
    Executes a plan without feedback in the second-order simulation and compares the motion with the plan (3.10)-(3.12).

      plan: Plan.
      speed: factor on the full speed that follows from the object and the motors (E.13), > 0. A factor above 1 makes only pushes faster.
        Without feedback most plans succeed at the default of 0.1, and few succeed at 1.
      pause: time for which the command is constant between pushes and regrasps [s], >= 0.
      uniform: SpeedLimits that replace speed and pause; the commands are then those of the plan, without lead for damping (E.1). None: not used.
      substeps: number of steps in which every contact edge of the plan is predicted again before the comparison. None: the prediction of the
        plan.
      rest_time: time in which objects on joints come to rest [s].
      friction_scale, mass_scale: factors of every coefficient of friction, >= 0, and of the mass of every object, > 0.
      start_error: displacement of the objects from their start in tangent coordinates (n_vu) [m, rad]. Overlaps that result are removed. None:
        no displacement.
      velocity_reference: True: damping of the joint springs acts on the difference of commanded and actual velocity. False: it acts on the
        actual velocity, so that joints lag behind their commands, as in the thesis.
      hold: time for which the last command is held before the goal is judged [s].
      whole: True: run the whole plan.
      alone: True: also run every push by itself from its planned start.
      threads: for the runs of single pushes; 0: all cores. The result does not depend on this number.
      timeout_s: largest wall time [s], > 0. None: no limit.

    Returns a TransferResult. Its status is Solved if the run came to its end, whether or not the goal was reached; MaxIterations: the time was
    used up; or NumericalFailure: `message` gives the reason. Raises InvalidInput.

        >>> plan = st.plan(st.load_task("planar_pushing"), seed=0).plan
        >>> run = st.transfer(plan, speed=20.0, pause=0.2, hold=0.2, alone=False)
        >>> run.status, run.q.shape == (len(run.times), 5)
        (Status.Solved, True)
    """

class ErrorSets:
    """
    Bounds on the errors of a model: start pose, friction, mass and contact geometry (docs/theory/tube.md).
    """

    def __init__(self, *, position: float = 0.002, angle: float = 0.03490658503988659, friction: float = 0.3, mass: float = 0.3, contact: float = 0.005) -> None:
        """
        Bounds on the errors of a model.

          position, angle: largest error of an object's pose at the start [m], [rad], >= 0.
          friction, mass: largest relative error of the coefficients of friction and of the masses of the objects, in [0, 1).
          contact: largest error of the gap of a contact, in lengths of the object of the goal, >= 0.

        Raises InvalidInput.
        """

    @property
    def position(self) -> float:
        """bound on the position error of objects at the start [m]"""

    @property
    def angle(self) -> float:
        """bound on the angle error of objects at the start [rad]"""

    @property
    def friction(self) -> float:
        """bound on the relative error of friction"""

    @property
    def mass(self) -> float:
        """bound on the relative error of masses"""

    @property
    def contact(self) -> float:
        """bound on the error of a gap, in lengths of the object"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class WorldError:
    """One sample of the model errors, as draw_world() returns it."""

    @property
    def start(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """error of the objects' start in tangent coordinates (n_vu) [m, rad]"""

    @property
    def friction(self) -> float:
        """factor of every coefficient of friction"""

    @property
    def mass(self) -> float:
        """factor of the mass of every object"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def draw_world(plan: Plan, errors: ErrorSets = ..., *, seed: int = 0, index: int = 0) -> WorldError:
    """
    Draws a random sample of the model errors within their bounds, for the start of a plan.

      plan: Plan whose start and model are used.
      errors: ErrorSets with the bounds.
      seed, index: each index gives another sample; the same seed and index give the same sample.

        >>> plan = st.plan(st.load_task("planar_pushing"), seed=0).plan
        >>> world = st.draw_world(plan, st.ErrorSets(friction=0.0), index=3)
        >>> world.friction, len(world.start), bool(0.7 <= world.mass <= 1.3)
        (1.0, 3, True)
    """

class TubeRest:
    """Bound on the object's pose at the end of a push or a regrasp."""

    @property
    def kind(self) -> SegmentKind:
        """Contact or Regrasp"""

    @property
    def last_segment(self) -> int:
        """index of the plan's last segment before this rest"""

    @property
    def centre(self) -> Pose:
        """centre of the bound, a pose in W"""

    @property
    def offset(self) -> GoalError:
        """distance of the centre from the planned pose"""

    @property
    def position(self) -> float:
        """largest distance of the object from the centre [m]"""

    @property
    def angle(self) -> float:
        """
        largest angle of the object from the centre [rad]; infinite if a scenario failed
        """

    @property
    def scenarios(self) -> list[Pose]:
        """poses of the object in the scenarios, the nominal one first"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class TubeResult:
    """Result of calc_tube(): bounds on the object's pose along a plan."""

    @property
    def status(self) -> Status: ...

    @property
    def rests(self) -> list[TubeRest]:
        """bounds at the ends of pushes and regrasps, in order"""

    @property
    def goal(self) -> GoalError:
        """bound on the distance from the goal at the end"""

    @property
    def calibrated(self) -> bool:
        """
        True: simulated runs stay inside the bound as often as the calibration promises; only in planar scenes
        """

    @property
    def inside(self) -> bool:
        """
        True: the bound is calibrated and lies within the tolerances of the goal
        """

    @property
    def lost(self) -> int:
        """number of scenarios in which a step had no solution"""

    @property
    def steps(self) -> int:
        """number of steps that were simulated"""

    @property
    def wall_s(self) -> float:
        """wall time [s]"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def calc_tube(plan: Plan, errors: ErrorSets = ..., *, factors: tuple[float, float] = (1.0, 1.0), scenarios: int = 16, seed: int = 0, threads: int = 1, timeout_s: float | None = None) -> TubeResult:
    """
    Bounds the pose of the object after every push and regrasp, if a plan is executed without feedback under model errors (docs/theory/tube.md).

    The plan is simulated in several scenarios, each with random errors within the bounds `errors`. The bound encloses all scenarios.

      errors: ErrorSets with the bounds on the model errors.
      factors: factors (position, angle) by which the bound is larger than the spread of the scenarios, > 0. The default was calibrated on runs
        in MuJoCo.
      scenarios: number of random scenarios besides the nominal one, >= 1.
      seed: of the scenarios.
      threads: 0: all cores. The result does not depend on this number.
      timeout_s: largest wall time [s], > 0. None: no limit.

    Returns a TubeResult. Its status is Solved, or MaxIterations: the time was used up, and there are no rests. Raises InvalidInput.

        >>> plan = st.refine(st.plan(st.load_task("iiwa_bimanual_planar"), seed=0, options={"margins": True}).plan).plan
        >>> tube = st.calc_tube(plan)
        >>> tube.status, tube.inside, len(tube.rests[0].scenarios)
        (Status.Solved, True, 17)
    """

class RunEnd(enum.Enum):
    """Reason why a run ended."""

    Reached = 0
    """the object stayed within the tolerances of the goal"""

    Dropped = 1
    """an object fell"""

    NoPlan = 2
    """the planner found no plan, or refused the start"""

    Replans = 3
    """the run used up its `replans`"""

    TimeUp = 4
    """the `duration` by the clock of the plant is over"""

    Deadline = 5
    """the wall time `timeout_s` is over"""

    Cancelled = 6
    """the caller stopped the run"""

    Silent = 7
    """the plant does not answer, or its objects are not seen any more"""

    Unfelt = 8
    """a guarded move before the run did not end as expected"""

class RunState(enum.Enum):
    """Activity of a run at one moment."""

    Hold = 0
    """
    the command is constant: objects come to rest, or the object has to stay at the goal
    """

    Push = 1
    """the robot pushes"""

    Regrasp = 2
    """the robot moves to new contacts"""

    Replan = 3
    """the command is constant while the planner works"""

class RunSample:
    """
    Measurement, command and activity of a run at one sample; a run takes 50 samples a second.
    """

    @property
    def time(self) -> float:
        """since the start of the run [s]"""

    @property
    def state(self) -> RunState: ...

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """measured configuration (n_q)"""

    @property
    def q_plan(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        configuration that the plan predicts for this moment (n_q); equal to q if no plan is carried out
        """

    @property
    def u(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """commands (n_a) [rad or m]"""

    @property
    def piece(self) -> int:
        """index into RunResult.pieces; -1 before the first piece"""

    @property
    def plans(self) -> int:
        """number of plans so far"""

    @property
    def goal_share(self) -> float:
        """distance of the object from the goal, in tolerances of the goal"""

    @property
    def goal(self) -> int:
        """index of the current goal in `goals`"""

    @property
    def torque(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        largest torque of each motor since the previous sample (n_a) [N m or N]; empty if `plant` was given
        """

    @property
    def forces(self) -> list[PairForce]:
        """
        contact forces, one PairForce for each pair that touches; empty if `plant` was given
        """

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class RunPlan:
    """One call of the planner in a run."""

    @property
    def time(self) -> float:
        """time of the run at which the planner was called [s]"""

    @property
    def wall_s(self) -> float:
        """wall time of the call [s]"""

    @property
    def processor_s(self) -> float:
        """processor time of the call on all cores of the process [s]"""

    @property
    def clock_s(self) -> float:
        """time that the call took by the clock of the plant [s]"""

    @property
    def status(self) -> Status: ...

    @property
    def cause(self) -> str:
        """why the run called the planner"""

    @property
    def joined(self) -> bool:
        """True: the run continued the previous plan, without a search"""

    @property
    def reason(self) -> str:
        """message of the planner if it found no plan"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class RunGoal:
    """One goal of a run."""

    @property
    def reached(self) -> bool: ...

    @property
    def begin_s(self) -> float:
        """time of the run at which it became the current goal [s]"""

    @property
    def end_s(self) -> float:
        """
        time of the run at which the goal counted as reached, or the run ended [s]
        """

    @property
    def replans(self) -> int:
        """number of plans for this goal after the first one"""

    @property
    def error(self) -> GoalError:
        """measured distance from this goal at end_s"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class RunPiece:
    """One push or regrasp that a run carried out, whole or in part."""

    @property
    def kind(self) -> SegmentKind:
        """Contact or Regrasp"""

    @property
    def plan(self) -> int:
        """
        index into RunResult.plans; -1: the plan that was given, or no plan was needed yet
        """

    @property
    def begin_s(self) -> float:
        """time of the run [s]"""

    @property
    def end_s(self) -> float:
        """time of the run [s]"""

    @property
    def off(self) -> float:
        """
        distance of the object from its planned path at the end, in tolerances of the goal
        """

    @property
    def given_up(self) -> bool:
        """
        True: the run stopped the piece because the object was too far off its path
        """

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Measurement:
    """
    State of a plant as its sensors measured it: the return value of read().
    """

    def __init__(self, time: float, q: numpy.typing.ArrayLike, u: numpy.typing.ArrayLike, object_time: float | None = None) -> None:
        """
        A measurement for run().

          time: time on the clock of the plant at which the joints were measured [s].
          q: configuration: the objects as last seen, the joints as measured (n_q).
          u: commands in force (n_a) [rad or m].
          object_time: time at which the objects were at the poses in q [s], <= time. None: the same as `time`.
        """

    @property
    def time(self) -> float:
        """time on the clock of the plant at which the joints were measured [s]"""

    @property
    def object_time(self) -> float:
        """time at which the objects were at the poses in q [s]"""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """configuration: objects as last seen, joints as measured (n_q)"""

    @property
    def u(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """commands in force (n_a) [rad or m]"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class SimulatedPlant:
    """
    A simulation in MuJoCo that begins at rest at the start of a task; bodies that overlap there are moved apart. run() uses it if no `plant` is given.
    """

    def __init__(self, task: Task) -> None: ...

    def read(self) -> Measurement | None:
        """Returns a Measurement, or None if the simulation has failed."""

    def command(self, u: numpy.typing.ArrayLike, period: float) -> bool:
        """
        Moves the commands linearly to u (n_a) [rad or m] within period [s]. Returns False if the command was not taken.
        """

    def push(self, body: str, force_W: numpy.typing.ArrayLike, p_BP: numpy.typing.ArrayLike | None = None) -> None:
        """
        Applies a constant force to a body from now on. It replaces the force of the previous call; a zero force ends it.

          body: name of the body.
          force_W: force in the world frame [N] (3).
          p_BP: point of application in the frame of the body [m] (3). None: the centre of mass; only for objects.

            >>> task = st.load_task("planar_pushing")
            >>> plant = st.SimulatedPlant(task)
            >>> plant.push("box", [0, 5, 0])
            >>> plant.command(plant.read().u, 0.1), bool(plant.read().q[0] > task.q_start[0])
            (True, True)
        """

    def __reduce__(self) -> tuple: ...

class RunResult:
    """
    Result of run(): how the run ended, its plans, and the recorded motion.
    """

    @property
    def status(self) -> Status:
        """Solved: all goals were reached"""

    @property
    def end(self) -> RunEnd:
        """why the run ended"""

    @property
    def message(self) -> str:
        """explanation in words if a goal was not reached"""

    @property
    def reached(self) -> bool:
        """True: all goals were reached"""

    @property
    def goals(self) -> list[RunGoal]:
        """goals that the run began, in their order"""

    @property
    def goals_reached(self) -> int:
        """number of goals that were reached"""

    @property
    def error(self) -> GoalError:
        """measured distance of the object from the goal at the end"""

    @property
    def true_error(self) -> GoalError:
        """
        exact distance from the goal in the simulation; equal to `error` if `plant` was given
        """

    @property
    def touch(self) -> GuardedResult:
        """
        result of the guarded moves of `touch_first`; None: there were no moves
        """

    @property
    def duration_s(self) -> float:
        """length of the run by the clock of the plant [s]"""

    @property
    def planning_s(self) -> float:
        """wall time of all plans [s]"""

    @property
    def wall_s(self) -> float:
        """wall time of the run [s]"""

    @property
    def plans(self) -> list[RunPlan]:
        """calls of the planner"""

    @property
    def pieces(self) -> list[RunPiece]:
        """pushes and regrasps that were carried out"""

    @property
    def replans(self) -> int:
        """
        number of plans after the first one of each goal; a plan that is asked for again after a refusal counts once
        """

    @property
    def pushes(self) -> int:
        """number of pushes that were carried out"""

    @property
    def regrasps(self) -> int:
        """number of regrasps that were carried out"""

    @property
    def dropped(self) -> int | None:
        """index of the object that fell, or None"""

    @property
    def max_depth(self) -> float:
        """deepest penetration of any contact [m]; NaN if `plant` was given"""

    @property
    def start_overlap(self) -> float:
        """
        deepest overlap of bodies in the given start [m]; run() moves them apart before the simulation begins. 0: no overlap
        """

    @property
    def start_moved(self) -> float:
        """
        largest motion of an object when overlaps were removed from the start [m or rad]
        """

    @property
    def largest_effort(self) -> float:
        """
        largest torque of a motor as a share of its effort limit, at most 1; NaN if `plant` was given
        """

    @property
    def largest_press(self) -> float | None:
        """
        largest normal force of one contact pair on a free object, as a multiple of the object's weight; None: no free object, or `plant` was given
        """

    @property
    def slip_speeds(self) -> list[float]:
        """
        for each piece, the largest excess of a free object's speed over its planned speed until the next piece began [m/s]; empty if `plant` was given
        """

    @property
    def times(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """time of each sample [s] (samples)"""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """measured configurations (samples, n_q)"""

    @property
    def q_plan(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """planned configurations (samples, n_q)"""

    @property
    def u(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """commands (samples, n_a) [rad or m]"""

    @property
    def piece(self) -> list[int]:
        """index into `pieces` (samples); -1 before the first piece"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def run(target: Task | Plan, *, goals: str | str | os.PathLike | Sequence | None = None, hold: float = 1.0, plant: object | None = None, options: PlannerOptions | dict | None = None, seed: int | None = None, speed: float = 1.0, replans: int = 60, duration: float = 600.0, friction_scale: float = 1.0, mass_scale: float = 1.0, pose_noise: tuple[float, float] = (0.0, 0.0), pose_delay: float = 0.0, pushes: Sequence[tuple[float, float, numpy.typing.ArrayLike]] = (), threads: int = 0, timeout_s: float = 300.0, plan_timeout_s: float = 20.0, plan_processor_s: float | None = None, planning_rate: float = 1.0, plan_step_time_s: float | None = None, active_hold: bool = False, join: bool = True, finger_gait: bool = True, touch_first: str | str | os.PathLike | TouchScenario | None = None, on_progress: Callable[[Progress], bool | None] | None = None, on_sample: Callable[[RunSample], None] | None = None) -> RunResult:
    """
    Moves the object of a task to its goal in closed loop, in MuJoCo or on your own robot (E.13)-(E.15).

    The run carries a plan out at real speed and watches the object. When the object leaves its planned path, the planner makes a new plan
    from the measured state. Use run() to test a task under wrong friction, mass or noise, or to control a robot.

      target: a Task, or a Plan with which the run begins.
      goals: goals that replace the goal of the task: a list, or the name of a file (.yaml) with a list. Each goal is a list of numbers as in
        Task.set_goal, or a dict as `goal` in a task file. The run brings the object to one goal after another, while the clock goes on. It
        holds each goal before it begins the next one, and a goal that is not reached ends the run. `duration` and `timeout_s` are for all
        goals together. None: the goal of the task.
      hold: time that the object has to stay within the tolerances before a goal counts as reached [s], >= 0. 0: the goal counts as soon as
        the object is seen within the tolerances, also during a push.
      plant: your own robot or simulation; docs/theory/running.md describes the interface. It is an object with two methods. read() returns a
        Measurement, or None if the robot does not answer. command(u, period) moves the commands linearly to u within period [s], returns
        when the period is over, and may return False if the command was not taken. If the clock of the plant runs by itself, give it an
        attribute real_time = True: the robot is then commanded while the planner works. An error in these methods ends the run and is raised.
        None: a simulation in MuJoCo, to which friction_scale, mass_scale, pose_noise, pose_delay and pushes apply.
      options: of the planner: PlannerOptions, or a dict with the options to change. None: the options of the target.
      seed: of the plans and of the noise. None: the seed of the options.
      speed: factor on the speed that follows from the object and the motors (E.13), > 0. A factor above 1 makes only the pushes faster.
      replans: largest number of plans after the first plan of a goal, >= 0.
      duration: largest length of the run by the clock of the plant [s], > 0.
      friction_scale, mass_scale: factors of every coefficient of friction and of the mass of every object in the simulation.
      pose_noise: standard deviations of the measured object poses: (position [m], angle [rad]).
      pose_delay: age of an object pose when the run receives it [s].
      pushes: external forces on the object, each as (begin [s], duration [s], force in W [N] (3)).
      threads: of the planner; 0: all cores. The result does not depend on this number.
      timeout_s: largest wall time of the run [s], > 0.
      plan_timeout_s: largest wall time of one plan [s], > 0.
      plan_processor_s: largest processor time of one plan, summed over all cores of the process [s], > 0. Other load on the machine does not
        shorten this budget. None: only plan_timeout_s limits a plan.
      planning_rate: processor time that the planner gets in one second of the plant's clock [s], >= 0 (E.20). The clock goes on while the
        planner works. 0: the clock stands still while the planner works.
      plan_step_time_s: time that the plant's clock is charged for each step of the planner [s], > 0, in place of the measured processor time.
        A run is then the same on every machine. None: the measured processor time.
      active_hold: while no piece of a plan is carried out, the fingers of a hand keep a free object where it is (E.21). False: the command is constant.
      join: before a search, the run tries to continue the previous plan from the measured state (E.22). It searches only if the previous
        plan does not lead to the goal.
      finger_gait: if an object would roll out of an open hand, the fingers turn it to its goal step by step; one finger at a time goes back
        to its first contact (E.23). The planner is called only if this does not reach the goal. False: the planner is always called.
      touch_first: guarded moves that the robot carries out before the run, in the same simulated world (docs/guarded_moves.md). Give a
        TouchScenario of this task, or the name or file of a scenario with the key `task`. The planner then takes the fixed bodies to be where
        the arm felt them. If target is a Plan, it is replaced by a new plan.
      on_progress: function that is called with Progress (iteration: number of plans; size: number of pieces; best: distance from the goal in
        tolerances). Ctrl-C, an error in the function or the return value False stop the run, and the robot holds its last command.
      on_sample: function that is called with a RunSample 50 times a second of the plant's clock. An error in the function stops the run.

    Returns a RunResult. Its status is Solved if all goals were reached; otherwise it is MaxIterations, Cancelled or NumericalFailure, and
    `end` and `message` give the reason. Raises InvalidInput.

        >>> run = st.run(st.load_task("planar_pushing"), seed=0, duration=0.5)
        >>> run.end, run.reached
        (RunEnd.TimeUp, False)
    """

class Law(enum.Enum):
    """Control law of ContactController."""

    ContactAware = 0
    """tracks the reference within bounds on the contact forces (C.3)"""

    Unconstrained = 1
    """
    baseline: tracks the reference, without bounds on forces and without limits
    """

    NullSpace = 2
    """
    baseline: controls the contact force, and tracks in the stiffness-consistent null space
    """

    ForceEquality = 3
    """
    baseline: the early published form, in which the force of one contact is an equality constraint
    """

class TrackingCost(enum.Enum):
    """Quantity that the controller compares with the reference."""

    Command = 0
    """the command (5.24); for contacts with friction"""

    Equilibrium = 1
    """
    the equilibrium that the command leads to (5.22); for contacts without friction
    """

class ForceDampingOptions:
    """
    Damping that slows the command down if contact forces differ from their prediction (5.28), (5.29).

      largest: largest damping w_max [-], >= 0.
      force_scale: force error at which the damping is 1 - 1/e of its largest value [N], > 0.
      forget_rate: coefficient alpha of the low-pass, in (0, 1].
      period: tick for which largest and forget_rate are given [s], > 0. They are converted for other ticks, so that the damping per second is
        the same.
      printed: True: use (5.29) as printed, an average of two ticks. False: use a low-pass.
    """

    def __init__(self, *, largest: float = 5.0, force_scale: float = 5.0, forget_rate: float = 0.2, period: float = 0.005, printed: bool | numpy.bool_ = False) -> None: ...

    @property
    def largest(self) -> float:
        """largest damping w_max"""

    @property
    def force_scale(self) -> float:
        """scale of the force error [N]"""

    @property
    def forget_rate(self) -> float:
        """coefficient alpha of the low-pass"""

    @property
    def period(self) -> float:
        """tick for which the options are given [s]"""

    @property
    def printed(self) -> bool:
        """True: (5.29) as printed"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class ContactForce:
    """
    A measured or estimated contact force on the robot.

      body: link in contact, as robot/link.
      p_WC: contact point in W [m] (3).
      force_W: contact force on the robot in W [N] (3). Its direction is the normal of (5.4).
      id: number of the contact. Give the same contact the same number in every tick, so that the controller can predict its force.
      lambda_max: bound on this force [N], > 0. None: the bound of the controller.
    """

    def __init__(self, *, body: str, p_WC: numpy.typing.ArrayLike, force_W: numpy.typing.ArrayLike, id: int = 0, lambda_max: float | None = None) -> None: ...

    @property
    def body(self) -> str:
        """link in contact, as robot/link"""

    @property
    def id(self) -> int:
        """number of the contact"""

    @property
    def p_WC(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """contact point in W [m] (3)"""

    @property
    def force_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """force on the robot in W [N] (3)"""

    @property
    def lambda_max(self) -> float | None:
        """bound on this force [N], or None"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class ToolReference:
    """
    Reference pose of a tool that is fixed to a link.

      body: link, as robot/link.
      X_BT: pose of the tool in the link.
      X_WT: reference pose of the tool in W.
    """

    def __init__(self, *, body: str, X_BT: Pose, X_WT: Pose) -> None: ...

    @property
    def body(self) -> str:
        """link, as robot/link"""

    @property
    def X_BT(self) -> Pose:
        """pose of the tool in the link"""

    @property
    def X_WT(self) -> Pose:
        """reference pose of the tool in W"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class ControllerState:
    """
    Measurement and reference of one tick of ContactController.

      time: time of the measurement [s].
      q: measured joint positions (n_a) [rad or m].
      q_ref: reference joint positions of the next tick (n_a) [rad or m]. If a tool is given, q_ref is the preferred posture.
      contacts: list of ContactForce on the robot.
      tool: ToolReference to track. None: the controller tracks q_ref.
    """

    def __init__(self, *, time: float, q: numpy.typing.ArrayLike, q_ref: numpy.typing.ArrayLike, contacts: Sequence[ContactForce] = [], tool: ToolReference | None = None) -> None: ...

    @property
    def time(self) -> float:
        """time of the measurement [s]"""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """measured joint positions (n_a)"""

    @property
    def q_ref(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """reference joint positions of the next tick (n_a)"""

    @property
    def contacts(self) -> list[ContactForce]:
        """contact forces on the robot"""

    @property
    def tool(self) -> ToolReference | None:
        """tool reference, or None"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class ControllerCommand:
    """
    Command of one tick, with predicted forces. The predictions are for the contacts in `taken`, and None unless the law is ContactAware.
    """

    @property
    def status(self) -> Status:
        """if not Solved, q_cmd is the command of the previous tick"""

    @property
    def q_cmd(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """commanded joint positions (n_a) [rad or m]"""

    @property
    def held(self) -> bool:
        """
        True: the measurement is not newer than the previous one, and nothing was computed
        """

    @property
    def taken(self) -> list[ContactForce]:
        """contacts that were used, with their forces after the low-pass"""

    @property
    def left_out(self) -> int:
        """number of contacts that were left out because of max_contacts"""

    @property
    def damping(self) -> float:
        """damping w of (5.24)"""

    @property
    def q_next(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')] | None:
        """predicted equilibrium (n_a)"""

    @property
    def lambda_(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')] | None:
        """predicted forces [N] (contacts)"""

    @property
    def slack(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')] | None:
        """excess of the predicted forces over their bounds [N] (contacts)"""

    @property
    def pull(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')] | None:
        """
        amount by which a predicted force is below 0 at a contact that cannot pull [N] (contacts)
        """

    @property
    def torque_slack(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')] | None:
        """excess of the joint spring torques over `torque` [N m] (n_a)"""

    @property
    def limit_slack(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')] | None:
        """amount by which q_cmd is outside the joint limits [rad or m] (n_a)"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class ContactController:
    """
    Controller that tracks a reference with a stiffness-controlled robot and keeps contact forces within bounds (docs/theory/control.md).

    Call configure() once and update() in every tick, as in a controller of ros2_control.

      model: Model with a robot whose joints have a stiffness.
      law: Law.ContactAware, or a baseline.
      cost: TrackingCost.Command (5.24) or TrackingCost.Equilibrium (5.22).
      lambda_max: bound on the force of every contact that has no bound of its own [N], > 0.
      force_threshold: contacts with a smaller force are ignored [N], >= 0, below lambda_max. None: 5 N, or a third of lambda_max if that is
        less.
      force_time_constant: time constant of the low-pass on contact forces [s], >= 0.
      release_time: when a contact is lost, its bound remains and grows by lambda_max in this time [s], > 0, until the reference asks for no more.
      max_contacts: largest number of contacts; if there are more, the controller uses those with the largest forces.
      revolute_speed, prismatic_speed: largest speed of a command [rad/s], [m/s], > 0.
      posture_time_constant: time constant with which the robot approaches the preferred posture while it tracks a tool [s], >= 0.
      torque: bounds on the torques of the joint springs (n_a) [N m], > 0. None: no bound.
      tool_length: length by which tool positions are divided when they are added to angles [m], > 0.
      damping: ForceDampingOptions().
      unilateral: True: a contact that the reference does not leave cannot pull.
      contact_compliance: compliance of a contact as a share of the arm's compliance at that point, > 0.
      least_lever: a contact with a shorter lever to the joint axes has the compliance of this lever [m], > 0.
      posture_weight: weight of |q_cmd - q_ref|^2 while a tool is tracked, > 0.
      epsilon: weight of |q_cmd - q_ref|^2 beside the equilibrium cost (5.22), > 0.
      force_priority: priority of force bounds, above unilateral_priority.
      unilateral_priority: priority of contacts that cannot pull, above tracking, > 0.

    Raises InvalidInput, which names the argument, also for a robot without stiffness.

        >>> model = st.load_control_scenario("box_in_the_way").model
        >>> controller = st.ContactController(model, lambda_max=15.0)
        >>> controller.configure(np.zeros(model.n_a))
        >>> command = controller.update(st.ControllerState(time=0.0, q=np.zeros(model.n_a), q_ref=np.full(model.n_a, 1e-4)), 0.005)
        >>> command.status, command.q_cmd.shape
        (Status.Solved, (7,))
    """

    def __init__(self, model: Model, *, law: Law = Law.ContactAware, cost: TrackingCost = TrackingCost.Command, lambda_max: float = 15.0, force_threshold: float | None = None, force_time_constant: float = 0.05, release_time: float = 0.5, max_contacts: int = 8, revolute_speed: float = 1.5, prismatic_speed: float = 0.25, torque: numpy.typing.ArrayLike | None = None, posture_time_constant: float = 0.5, tool_length: float = 0.5, damping: ForceDampingOptions = ..., unilateral: bool | numpy.bool_ = True, contact_compliance: float = 0.01, posture_weight: float = 0.001, epsilon: float = 0.001, least_lever: float = 0.01, force_priority: float = 1000000.0, unilateral_priority: float = 1000.0) -> None: ...

    @property
    def model(self) -> Model:
        """model of the robot"""

    @property
    def law(self) -> Law:
        """control law"""

    @property
    def lambda_max(self) -> float:
        """bound on contact forces [N]"""

    def configure(self, q: numpy.typing.ArrayLike) -> None:
        """
        Resets the controller. Its first command is q, the present joint positions (n_a) [rad or m]. Raises InvalidInput: wrong size, not finite.
        """

    def update(self, state: ControllerState, dt: float) -> ControllerCommand:
        """
        Computes the command of the next tick.

          state: ControllerState with the measurement and the reference.
          dt: time for which the command is in force [s], > 0.

        Returns a ControllerCommand. If the state is not newer than the previous one, nothing is computed and `held` is True. Raises InvalidInput:
        wrong sizes, numbers that are not finite, dt <= 0, or a link that does not belong to the robot.
        """

    def __reduce__(self) -> tuple: ...

class ContactSource(enum.Enum):
    """Source of the contacts that the controller receives."""

    Simulated = 0
    """true contacts of the simulation, as if a tactile skin measured them"""

    Estimated = 1
    """
    contacts that are estimated from joint torques, by a momentum observer and contact sensing
    """

class ControlScenario:
    """
    Scenario for control(): a robot whose reference path leads into obstacles that it does not know (scenarios/README.md).
    """

    @property
    def name(self) -> str:
        """name of the scenario"""

    @property
    def description(self) -> str:
        """one line about the scenario"""

    @property
    def file(self) -> pathlib.Path:
        """path of the scenario file"""

    @property
    def model(self) -> Model:
        """model of the scene"""

    @property
    def start(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """joint positions at the start (n_a) [rad or m]"""

    @property
    def tool(self) -> str | None:
        """
        link of the tool that is tracked, as robot/link; None: the joints are tracked
        """

    @property
    def X_BT(self) -> Pose:
        """pose of the tool in its link"""

    @property
    def duration(self) -> float:
        """length of the run [s]"""

    @property
    def period(self) -> float:
        """period of the controller [s]"""

    @property
    def contacts(self) -> ContactSource:
        """source of the contacts that the controller receives"""

    @property
    def delay(self) -> float:
        """age of the contacts when the controller receives them [s]"""

    @property
    def law(self) -> Law:
        """control law"""

    @property
    def lambda_max(self) -> float:
        """bound on contact forces [N]"""

    def calc_reference(self, time: float) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        Returns the reference at a time [s]: joint positions (n_a) [rad or m]; or for a tool (6)
        its displacement from its start pose in W [m] and the rotation vector [rad].
        """

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class ControlRunResult:
    """
    Result of control(). Forces are measured forces of single contacts; series have one row for each tick.
    """

    @property
    def status(self) -> Status:
        """see control()"""

    @property
    def message(self) -> str:
        """reason of a numerical failure"""

    @property
    def times(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """times of the ticks [s] (ticks)"""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """joint positions (ticks, n_a) [rad or m]"""

    @property
    def q_cmd(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """commands (ticks, n_a) [rad or m]"""

    @property
    def reference(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """reference of the joints (ticks, n_a) or of the tool (ticks, 6)"""

    @property
    def largest_force(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """largest force of one contact [N] (ticks)"""

    @property
    def speed(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """norm of the joint velocity [rad/s] (ticks)"""

    @property
    def error(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        tracking error: norm of q - q_ref [rad or m], or distance of the tool from its reference [m] (ticks)
        """

    @property
    def angle_error(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """angle error of the tool [rad] (ticks)"""

    @property
    def bounded(self) -> Annotated[NDArray[numpy.bool_], dict(shape=(None,), order='C')]:
        """
        True for each tick in which a predicted force is at its bound, since the reference asks for more (ticks)
        """

    @property
    def slack(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """largest excess of a predicted force over its bound [N] (ticks)"""

    @property
    def forces(self) -> list[list[PairForce]]:
        """
        for each tick, the forces on the robot from pairs of a robot and another body
        """

    @property
    def peak_force(self) -> float:
        """largest force [N]"""

    @property
    def settled_peak(self) -> float:
        """largest force without the first `settle` seconds of each contact [N]"""

    @property
    def settled_ticks(self) -> int:
        """number of ticks with a contact that is older than `settle`"""

    @property
    def bounded_ticks(self) -> int:
        """number of these ticks in which the force is at its bound"""

    @property
    def bound_error(self) -> float:
        """mean |f - lambda_max| over the bounded ticks [N]"""

    @property
    def bound_p95(self) -> float:
        """95th percentile of the force over the bounded ticks [N]"""

    @property
    def mean_force(self) -> float:
        """mean force over the settled ticks [N]"""

    @property
    def makes(self) -> int:
        """number of times that the robot as a whole made contact"""

    @property
    def rms_error_contact(self) -> float:
        """RMS of the tracking error in contact"""

    @property
    def rms_error_free(self) -> float:
        """RMS of the tracking error without contact"""

    @property
    def peak_speed(self) -> float:
        """largest norm of the joint velocity [rad/s]"""

    @property
    def peak_force_rate(self) -> float:
        """largest rate at which a settled force falls between two ticks [N/s]"""

    @property
    def peak_rise(self) -> float:
        """largest rise of a settled force between two ticks [N]"""

    @property
    def commanded_rise(self) -> float:
        """part of peak_rise that the change of the command explains [N]"""

    @property
    def above_ticks(self) -> int:
        """
        number of settled ticks in which a force exceeds its bound by more than a fifth
        """

    @property
    def slack_ticks(self) -> int:
        """number of ticks in which a bound was relaxed by more than a thousandth"""

    @property
    def unsolved_ticks(self) -> int:
        """number of ticks without a solution"""

    @property
    def tick_median_s(self) -> float:
        """median processor time of update() [s]"""

    @property
    def tick_p99_s(self) -> float:
        """99th percentile of this processor time [s]"""

    @property
    def sense_median_s(self) -> float:
        """median processor time of one contact estimate [s]; 0: no estimates"""

    @property
    def sense_p99_s(self) -> float:
        """99th percentile of this processor time [s]"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class ControlSample:
    """
    One tick of a ControlLoop: the state at the start of its period, and its command.
    """

    @property
    def time(self) -> float:
        """time at the start of the period [s]"""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """joint positions (n_a) [rad or m]"""

    @property
    def q_cmd(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """command (n_a) [rad or m]"""

    @property
    def forces(self) -> list[PairForce]:
        """
        forces on the robot from pairs of a robot and another body, and from push() (pair -1)
        """

    @property
    def largest_force(self) -> float:
        """largest force of one contact [N]"""

    @property
    def error(self) -> float:
        """
        tracking error: norm of q - q_ref [rad or m], or distance of the tool from its reference [m]
        """

    @property
    def bounded(self) -> bool:
        """
        True: a predicted force is at its bound, since the reference asks for more
        """

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class ControlLoop:
    """
    Simulates the arm of a control scenario tick by tick, as control() does in one call. Use it to interact with the arm while it runs.

    After the last knot of the reference the arm stays there. Only one thread may use a loop at a time.

        >>> loop = st.ControlLoop(st.load_control_scenario("box_in_the_way"))
        >>> loop.push("arm/link_4", [0, 10, 0], [0, 0, 0])
        >>> samples = [loop.tick() for _ in range(10)]
        >>> round(samples[-1].time, 3), samples[-1].largest_force
        (0.045, 10.0)
    """

    def __init__(self, scenario: ControlScenario) -> None: ...

    def tick(self) -> ControlSample:
        """
        Simulates one period: the controller receives the contacts, and its command is held. Returns a ControlSample. Raises InvalidInput: the simulation failed.
        """

    def push(self, link: str, force_W: numpy.typing.ArrayLike, p_LP: numpy.typing.ArrayLike) -> None:
        """
        Applies a constant force to a link from the next tick on. It replaces the force of the previous call; a zero force ends it.

          link: as robot/link.
          force_W: force in W [N] (3).
          p_LP: point of application in the frame of the link [m] (3).
        """

    @property
    def time(self) -> float:
        """time of the next tick [s]"""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """configuration (n_q)"""

    def __reduce__(self) -> tuple: ...

@overload
def load_control_scenario(scenario: str | str | os.PathLike) -> ControlScenario:
    """
    Loads a scenario for control(): the name of a built-in one, or a file. Raises InvalidInput: "FILE:LINE: field: got …".

        >>> st.load_control_scenario("box_in_the_way").lambda_max
        15.0
    """

@overload
def load_control_scenario(scenario: dict, *, base: str | os.PathLike | None = None) -> ControlScenario:
    """
    Makes a scenario from a dict with the keys of a file. base: folder to which its paths are relative; None: the working folder. Raises InvalidInput: "field: got …".
    """

@overload
def control(scenario: ControlScenario, *, law: Law | None = None, lambda_max: float | None = None, friction_scale: float | None = None, contacts: ContactSource | None = None, delay: float | None = None, period: float | None = None, seed: int | None = None, settle: float = 0.3, timeout_s: float | None = None) -> ControlRunResult:
    """
    Simulates a contact-aware controller: the robot tracks a reference that leads into obstacles, and keeps contact forces within bounds.

    The second-order simulation contains impedance control of the joints and the ContactController above it.

      scenario: ControlScenario, or its name or file.
      law: control law.
      lambda_max: bound on contact forces [N], > 0.
      friction_scale: factor of every coefficient of friction of the simulation, >= 0.
      contacts: source of the contacts that the controller receives.
      delay: age of these contacts, rounded to whole ticks [s], >= 0.
      period: time between two commands [s], > 0.
      seed: of the noise of joint torques.
      settle: time after the start of a contact from which its force counts as steady [s], >= 0.
      timeout_s: largest wall time [s], > 0. None: no limit.

    For the arguments from law to seed, None keeps the value of the scenario.

    Returns a ControlRunResult. Its status is Solved; MaxIterations: the time was used up; or NumericalFailure: `message` gives the reason.
    Raises InvalidInput.

        >>> run = st.control("box_in_the_way")
        >>> run.status, run.q.shape == (len(run.times), 7)
        (Status.Solved, True)
    """

@overload
def control(scenario: str | str | os.PathLike, *, law: Law | None = None, lambda_max: float | None = None, friction_scale: float | None = None, contacts: ContactSource | None = None, delay: float | None = None, period: float | None = None, seed: int | None = None, settle: float = 0.3, timeout_s: float | None = None) -> ControlRunResult:
    """
    The same for load_control_scenario(scenario): give the name or file of a scenario.
    """

class TouchScenario:
    """
    Scenario for touch() and guarded_moves(): an arm with torque sensors among obstacles that it does not know (scenarios/README.md).
    """

    @property
    def name(self) -> str:
        """name of the scenario"""

    @property
    def description(self) -> str:
        """one line about the scenario"""

    @property
    def file(self) -> pathlib.Path:
        """path of the scenario file"""

    @property
    def model(self) -> Model:
        """model that the arm knows"""

    @property
    def start(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """joint positions at the start (n_a) [rad or m]"""

    @property
    def goal(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """joint positions at the goal (n_a) [rad or m]"""

    @property
    def tolerance(self) -> float:
        """
        largest joint error at the goal; revolute joints [rad], prismatic joints in lengths of the robots
        """

    @property
    def speed(self) -> float:
        """largest speed of any point of the arm [m/s]"""

    @property
    def max_touches(self) -> int:
        """number of touches after which the arm gives up"""

    @property
    def lambda_max(self) -> float:
        """bound on contact forces [N]"""

    def make_world(self, seed: int = 0) -> Model:
        """
        Returns the true model, in which the unknown bodies are at their places for this seed. Raises InvalidInput: the start touches something.
        """

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class TouchOutcome(enum.Enum):
    """How a run of touch() ended."""

    Reached = 0
    """the arm is at the goal"""

    NoRoute = 1
    """
    there is no path to the goal among the known obstacles; the arm holds its position
    """

    TooManyTouches = 2
    """max_touches is used up; the arm holds its position"""

    Missed = 3
    """
    the arm is at the end of its path but not at the goal, and feels no contact
    """

class Touch:
    """Contact that the arm felt long enough to locate it."""

    @property
    def time(self) -> float:
        """time at which the contact was located [s]"""

    @property
    def link(self) -> str:
        """link in contact, as robot/link"""

    @property
    def p_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """contact point in W, as estimated from joint torques [m] (3)"""

    @property
    def n_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """unit normal in W, out of the obstacle (3)"""

    @property
    def spread(self) -> float:
        """standard deviation of the estimated points [m]"""

    @property
    def force(self) -> float:
        """mean of the estimated forces [N]"""

    @property
    def radius(self) -> float:
        """
        radius of the ball that represents the obstacle in the map from then on (G.2) [m]
        """

    @property
    def error(self) -> float | None:
        """
        distance from the nearest true contact in the simulation [m]; None: there was no contact
        """

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class TouchRoute:
    """Path to the goal among the obstacles that were known at that time."""

    @property
    def time(self) -> float:
        """time at which the path was found [s]"""

    @property
    def found(self) -> bool:
        """True: there is a path"""

    @property
    def postures(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """
        joint positions along the path, both ends included (postures, n_a) [rad or m]
        """

    @property
    def travel(self) -> float:
        """length of the path (G.1) [m]"""

    @property
    def wall_s(self) -> float:
        """wall time of the search [s]"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class TouchResult:
    """Result of touch()."""

    @property
    def status(self) -> Status:
        """see touch()"""

    @property
    def outcome(self) -> TouchOutcome:
        """how the run ended"""

    @property
    def reached(self) -> bool:
        """True: the arm reached its goal"""

    @property
    def reason(self) -> str:
        """why the goal was not reached, or the error of the simulation"""

    @property
    def touches(self) -> list[Touch]:
        """contacts that the arm located"""

    @property
    def routes(self) -> list[TouchRoute]:
        """paths: one before the first motion, then one after each touch"""

    @property
    def goal_error(self) -> float:
        """
        largest joint error at the end; revolute joints [rad], prismatic joints in lengths of the robots
        """

    @property
    def run(self) -> ControlRunResult:
        """samples and forces of the whole run"""

    @property
    def world(self) -> Model:
        """model that was simulated"""

    @property
    def map(self) -> Model:
        """
        model that the arm knows at the end: the scene, with a ball touch_1, touch_2, … at each located contact
        """

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

@overload
def load_touch_scenario(scenario: str | str | os.PathLike) -> TouchScenario:
    """
    Loads a scenario for touch() or guarded_moves(): the name of a built-in one, or a file. Raises InvalidInput: "FILE:LINE: field: got …".

        >>> scenario = st.load_touch_scenario("reach_past_pillar")
        >>> scenario.goal.shape == scenario.start.shape, scenario.lambda_max
        (True, 15.0)
    """

@overload
def load_touch_scenario(scenario: dict, *, base: str | os.PathLike | None = None) -> TouchScenario:
    """
    Makes a scenario from a dict with the keys of a file. base: folder to which its paths are relative; None: the working folder. Raises InvalidInput: "field: got …".
    """

@overload
def touch(scenario: TouchScenario, *, seed: int | None = None, settle: float = 0.3, timeout_s: float | None = None) -> TouchResult:
    """
    Simulates an arm that moves to a goal among unknown obstacles. It bounds contact forces, locates each obstacle that it touches from its
    joint torques, and plans around it.

      scenario: TouchScenario of load_touch_scenario() that has a goal, or its name or file.
      seed: of the torque noise, of the places of the unknown obstacles and of the paths. None: the seed of the scenario.
      settle: time after the start of a contact from which its force counts as steady [s], >= 0.
      timeout_s: largest wall time [s], > 0. None: no limit.

    Returns a TouchResult. Its status is Solved if the simulation came to its end; `outcome` tells whether the arm reached its goal. Otherwise
    it is MaxIterations: the time was used up; or NumericalFailure: see `reason`. Raises InvalidInput.

        >>> run = st.touch("reach_past_pillar", seed=0)
        >>> run.outcome, len(run.touches) > 0, run.run.q.shape == (len(run.run.times), 7)
        (TouchOutcome.Reached, True, True)
    """

@overload
def touch(scenario: str | str | os.PathLike, *, seed: int | None = None, settle: float = 0.3, timeout_s: float | None = None) -> TouchResult:
    """
    The same for load_touch_scenario(scenario): give the name or file of a scenario.
    """

class MoveOutcome(enum.Enum):
    """How a guarded move ended."""

    Arrived = 0
    """the tool reached the end of the path"""

    Felt = 1
    """
    the arm felt the expected contact, and presses with the force of the move
    """

    Lost = 2
    """the arm lost the contact that it pressed on: an edge"""

    NotFelt = 3
    """the tool reached the end of the path without the expected contact"""

    WrongLink = 4
    """the arm felt a contact on a link that the move does not name"""

    StillThere = 5
    """
    the tool reached the end of the path without losing the contact that it pressed on
    """

class FeltContact:
    """
    Contact that ended a move, as estimated from joint torques. Times are times of the run.
    """

    @property
    def link(self) -> str:
        """link in contact, as robot/link"""

    @property
    def probability(self) -> float:
        """probability that the contact is on this link"""

    @property
    def p_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """contact point in W [m] (3)"""

    @property
    def direction_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """unit direction of the force on the arm in W (3)"""

    @property
    def force(self) -> float:
        """contact force [N]"""

    @property
    def begin(self) -> float:
        """time at which the contact began [s]"""

    @property
    def alarm(self) -> float:
        """time at which the contact was detected and the arm stopped [s]"""

    @property
    def time(self) -> float:
        """
        time at which the contact was located, while the arm pressed with the force of the move [s]
        """

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class GuardedMoveResult:
    """
    Result of one guarded move, with the true contact forces of the simulation.
    """

    @property
    def name(self) -> str:
        """name of the move"""

    @property
    def outcome(self) -> MoveOutcome:
        """how the move ended"""

    @property
    def reason(self) -> str:
        """explanation if the outcome is not the expected one"""

    @property
    def begin(self) -> float:
        """time at which the move began [s]"""

    @property
    def end(self) -> float:
        """time at which the move ended [s]"""

    @property
    def travelled(self) -> float:
        """measured distance that the tool moved along its direction [m]"""

    @property
    def felt(self) -> list[FeltContact]:
        """contacts that were felt: one, or one for each side of a hand"""

    @property
    def corrected(self) -> str:
        """
        name of the fixed body whose place was corrected in the model; empty: none
        """

    @property
    def correction(self) -> float | None:
        """
        distance by which this body was moved along the direction of the move [m]; None: no correction
        """

    @property
    def correction_error(self) -> float | None:
        """error of the corrected place: its position minus the true position [m]"""

    @property
    def contact(self) -> float:
        """
        time of the first contact in the simulation; the end of the move if there was none [s]
        """

    @property
    def peak(self) -> float:
        """largest contact force [N]"""

    @property
    def late_peak(self) -> float:
        """largest contact force later than 0.1 s after the first contact [N]"""

    @property
    def last_force(self) -> float:
        """mean contact force over the last 0.1 s [N]"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class GuardedResult:
    """Result of guarded_moves()."""

    @property
    def status(self) -> Status:
        """see guarded_moves()"""

    @property
    def reached(self) -> bool:
        """True: all moves ended as expected"""

    @property
    def reason(self) -> str:
        """why a move did not end as expected, or the error of the simulation"""

    @property
    def moves(self) -> list[GuardedMoveResult]:
        """results of the moves that were begun"""

    @property
    def places(self) -> dict[str, Pose]:
        """
        corrected poses of the fixed bodies that the arm felt: {name: pose in W}
        """

    @property
    def friction(self) -> JointFriction | None:
        """
        joint friction that was identified by a motion before the moves; None: not asked for
        """

    @property
    def run(self) -> ControlRunResult:
        """samples and forces of the whole run"""

    @property
    def world(self) -> Model:
        """model that was simulated"""

    @property
    def model(self) -> Model:
        """model that the arm knows at the end, with corrected places"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

@overload
def guarded_moves(scenario: TouchScenario, *, seed: int | None = None, settle: float = 0.3, timeout_s: float | None = None) -> GuardedResult:
    """
    Simulates guarded moves: the arm moves in a straight line until it arrives or feels a contact in its joint torques (docs/guarded_moves.md).

    Use guarded moves to find a table, a wall or an edge whose place in the model is wrong. The moves of a scenario are carried out one after
    the other.

      scenario: TouchScenario of load_touch_scenario() that has moves, or its name or file.
      seed: of the torque noise and of the true places of misplaced bodies. None: the seed of the scenario.
      settle: time after the start of a contact from which its force counts as steady [s], >= 0.
      timeout_s: largest wall time [s], > 0. None: no limit.

    Returns a GuardedResult. Its status is Solved if the simulation came to its end; `reached` tells whether all moves ended as expected.
    Otherwise it is MaxIterations: the time was used up; or NumericalFailure: see `reason`. Raises InvalidInput.

        >>> done = st.guarded_moves("lower_until_touch", seed=1)
        >>> done.reached, done.moves[0].outcome, done.moves[0].felt[0].link, sorted(done.places)
        (True, MoveOutcome.Felt, 'arm/link_7', ['table'])
    """

@overload
def guarded_moves(scenario: str | str | os.PathLike, *, seed: int | None = None, settle: float = 0.3, timeout_s: float | None = None) -> GuardedResult:
    """
    The same for load_touch_scenario(scenario): give the name or file of a scenario.
    """

class Sampling(enum.Enum):
    """Distribution of sample points on the surface of a link."""

    Uniform = 0
    """independent points, uniform by area"""

    Stratified = 1
    """one point in each of equal areas"""

    BlueNoise = 2
    """the points farthest apart, chosen from five times as many"""

class Normals(enum.Enum):
    """Kind of surface normals."""

    Flat = 0
    """normal of the triangle"""

    Smooth = 1
    """interpolated from vertex normals, except at sharp edges"""

class SurfaceOptions:
    """
    Options for the surface of a link on which contacts are possible.

      segments: number of triangles around a sphere, a cylinder or a capsule, >= 3.
      rays: number of rays from each point whose visibility is tested. 0: hidden faces are kept.
      postures: number of robot postures in which a face may be visible, >= 1.
      crease: edges with a larger angle stay sharp with smooth normals [rad].
    """

    def __init__(self, *, segments: int = 32, rays: int = 32, postures: int = 4, crease: float = 0.8) -> None: ...

    @property
    def segments(self) -> int:
        """triangles around a round shape"""

    @property
    def rays(self) -> int:
        """rays of the visibility test"""

    @property
    def postures(self) -> int:
        """postures of the visibility test"""

    @property
    def crease(self) -> float:
        """angle of a sharp edge [rad]"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class GaussNewton:
    """
    Levenberg-Marquardt over contact point and force together. Step lengths are shares of the link's size.
    """

    def __init__(self, *, max_steps: int = 20, tol_step: float = 1e-06, damping: float = 1e-06, max_step: float = 0.2) -> None: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class SteepestDescent:
    """Steepest descent on the surface: algorithm 4 of the thesis (RSGD)."""

    def __init__(self, *, max_steps: int = 50, tol_gradient: float = 1e-05, armijo: float = 0.4, backtrack: float = 0.5, max_backtracks: int = 10, max_step: float = 0.1) -> None: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class RejectionSampling:
    """Rejection sampling: the accepted samples, without descent (4.9)."""

    def __init__(self) -> None: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Detectability(enum.Enum):
    """
    Whether a contact on a link causes a torque in the last joint before the link (4.7).
    """

    Undetectable = 0
    """no force of the friction cone causes a torque"""

    Partial = 1
    """some forces of the cone cause a torque"""

    Full = 2
    """every force of the cone except 0 causes a torque"""

class DetectabilityMap:
    """Detectability of contacts at the sample points of a link."""

    @property
    def kinds(self) -> list[Detectability]:
        """detectability at each sample"""

    @property
    def eta(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        share of the unit forces whose torque is at most epsilon, in [0, 1] (4.8) (samples)
        """

    @property
    def full(self) -> int:
        """number of fully detectable samples"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Verdict(enum.Enum):
    """Whether the joint torques show a contact."""

    BelowThreshold = 0
    """no contact, or a contact that these torques do not show"""

    Explained = 1
    """at least one candidate explains the torques within noise and tolerance"""

    Unexplained = 2
    """
    no single contact on the sensed links explains the torques: several contacts, another link, or a wrong friction
    """

class SensedLink:
    """Link on which a Sensor locates contacts."""

    @property
    def name(self) -> str:
        """name of the link, as robot/link"""

    @property
    def p_L(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """sample points in the frame of the link [m] (samples, 3)"""

    @property
    def n_L(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """outward unit normals at the sample points (samples, 3)"""

    @property
    def spacing(self) -> float:
        """square root of the area per sample [m]"""

    @property
    def joints(self) -> int:
        """
        number of joints that move the link; below 3, contact forces are not unique, and below 5, contact points are not unique
        """

    @property
    def area(self) -> float:
        """area of its surface [m^2]"""

    @property
    def size(self) -> float:
        """diagonal of its bounding box [m]"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Candidate:
    """
    Possible contact: a cluster of points that explain the torques equally well, described by its best point.
    """

    @property
    def link(self) -> str:
        """link in contact, as robot/link"""

    @property
    def p_L(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """contact point in the frame of the link [m] (3)"""

    @property
    def n_L(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """outward unit normal in the frame of the link (3)"""

    @property
    def f_L(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """force on the robot in the frame of the link [N] (3)"""

    @property
    def p_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """contact point in W [m] (3)"""

    @property
    def n_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """outward unit normal in W (3)"""

    @property
    def f_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """force on the robot in W [N] (3)"""

    @property
    def residual(self) -> float:
        """residual l (4.5) [(N m)^2]"""

    @property
    def explains(self) -> bool:
        """True: the contact explains the torques within noise and tolerance"""

    @property
    def objective(self) -> float:
        """
        min l + (noise/F)^2 |f|^2 at the best point [(N m)^2]; divided by noise^2 it is -2 ln of a posterior, up to a constant
        """

    @property
    def probability(self) -> float:
        """
        probability of the points of its link that are nearest to this candidate; 0 without posterior=True
        """

    @property
    def rank(self) -> int:
        """rank of J_C; below 3 the force is not unique"""

    @property
    def extent(self) -> float:
        """
        size of the cluster: largest distance of an equally good point from the best point [m]
        """

    @property
    def force_spread(self) -> float:
        """largest difference between the forces of these points and f_W [N]"""

    @property
    def points(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """p_L of the points of the cluster, ordered by residual [m] (points, 3)"""

    @property
    def residuals(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """residuals l of these points [(N m)^2] (points)"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Discrimination:
    """Small motion of the robot that distinguishes candidates (4.13)."""

    @property
    def status(self) -> Status:
        """
        Solved; or Infeasible: proof that no motion distinguishes the candidates
        """

    @property
    def dq(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """motion of the joints (n_a) [rad or m]"""

    @property
    def pull(self) -> list[int]:
        """
        for each candidate, 1: the motion pulls away from the contact; 0: it pushes into the contact
        """

    @property
    def objective(self) -> int:
        """
        difference between the number of candidates that it pulls away from and half of all; the smallest possible value
        """

    @property
    def nodes(self) -> int:
        """number of linear programs that were solved"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Posterior:
    """
    Probabilities of where the robot is touched: nowhere, or at one contact on a link.

    The prior probability of a contact is touch_prior. The prior of the contact point is uniform over the sensed surface. The prior of the force
    is a normal distribution, cut to the friction cone, with the standard deviation plausible_force. If plausible_force is not given, the
    standard deviation is unknown: 4 N, the force that the weakest joint holds, or their geometric mean.
    """

    @property
    def nothing(self) -> float:
        """probability that nothing touches the robot"""

    @property
    def links(self) -> dict[str, float]:
        """
        probability of a contact on each link, the largest first; together with `nothing` they sum to 1
        """

    @property
    def credible(self) -> list[str]:
        """
        smallest set of links with 95 % of the probability of a contact, the most likely link first
        """

    def points(self, link: str) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """
        Returns the points of a link with notable probability, the most likely first, in the frame of the link [m] (places, 3).
        """

    def probabilities(self, link: str) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        Returns the probabilities of the points of a link that points() returns (places).
        """

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class SenseResult:
    """Contacts that explain the joint torques of one measurement."""

    @property
    def verdict(self) -> Verdict:
        """whether a contact explains the torques"""

    @property
    def candidates(self) -> list[Candidate]:
        """
        candidates that explain the torques, ordered by objective; then the others, ordered by residual
        """

    @property
    def explained(self) -> float:
        """largest residual l that counts as explained [(N m)^2]"""

    @property
    def posterior(self) -> Posterior | None:
        """Posterior, or None without posterior=True"""

    @property
    def largest(self) -> float:
        """torque that is largest relative to its noise, minus rest [N m; N]"""

    @property
    def largest_joint(self) -> int:
        """index of the joint with this torque"""

    @property
    def threshold(self) -> float:
        """
        torque of this joint from which the search for contacts begins [N m; N]
        """

    @property
    def noise(self) -> float:
        """
        noise of each torque in the coordinates of the residuals, so that residual/noise^2 has no unit [N m]
        """

    @property
    def friction(self) -> float:
        """
        friction coefficient of the search; larger than the given one if that explained nothing
        """

    @property
    def samples(self) -> int:
        """number of samples"""

    @property
    def accepted(self) -> int:
        """number of samples with a small enough residual"""

    @property
    def descents(self) -> int:
        """number of descents"""

    @property
    def converged(self) -> int:
        """number of descents that converged"""

    def calc_distance(self, link: str, p_L: numpy.typing.ArrayLike) -> float:
        """
        Returns the distance of a known contact from the nearest point that explains the torques [m]; inf if no such point is on that link.

          link: link of the known contact, as "robot/link".
          p_L: known contact point in the frame of the link [m] (3).
        """

    def discriminate(self, q: numpy.typing.ArrayLike, *, all: bool | numpy.bool_ = False, joint_step: float = 0.05, travel: float | None = None, least: float = 0.1, sideways: float = 0.5) -> Discrimination:
        """
        Finds a small motion that distinguishes the candidates (4.13).

        The motion pulls away from about half of the candidates and pushes into the others. The change of the torques then refutes one half.

          q: configuration of the measurement (n_q), or joint positions alone (n_a).
          all: True: distinguish all candidates. False: only the candidates that explain the torques.
          joint_step: largest change of a joint [rad or m], > 0.
          travel: largest motion of a contact point [m], > 0. None: a tenth of joint_step times the longest reach.
          least: smallest motion along the normal at a contact, as a share of travel, in (0, 1).
          sideways: largest sliding motion at a contact, as a share of travel.

        Returns a Discrimination. Raises InvalidInput: options out of range, no candidate.
        """

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Payload:
    """Payload on a link that the robot's own model does not contain."""

    @property
    def mass(self) -> float:
        """
        mass [kg]; negative: the robot's model has too much mass, or the sign of the torques is -1
        """

    @property
    def mass_deviation(self) -> float:
        """standard deviation of the mass [kg]"""

    @property
    def centre_L(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """centre of mass in the frame of the link [m] (3)"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Hysteresis:
    """Error of the rest torques that remains for a while after a touch."""

    @property
    def share(self) -> float:
        """
        standard deviation of the error right after a touch, as a share of the largest torque of the joint during the touch
        """

    @property
    def freedom(self) -> float:
        """degrees of freedom of this estimate; 0: no rows were touched"""

    @property
    def settle(self) -> float:
        """time after a touch until the error has vanished [s]"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class TorqueNoise:
    """
    Noise of joint torques, and how well it is known. Use it as sense(noise=n.covariance, freedom=n.freedom).
    """

    @property
    def covariance(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')]:
        """covariance of the torques (n_a, n_a) [(N m)^2]"""

    @property
    def freedom(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """degrees of freedom of the noise estimate of each joint (n_a)"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Calibration:
    """
    Result of calibrate(): offset, noise and drift of the external joint torques, and the payload.
    """

    @property
    def rest(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        torque offset: the measured torques without contact, from the last record (n_a) [N m; N]
        """

    @property
    def noise(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')]:
        """covariance of a measured torque minus rest (n_a, n_a) [(N m)^2]"""

    @property
    def within(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')]:
        """
        covariance of a single row about the mean of a long record (n_a, n_a) [(N m)^2]
        """

    @property
    def noise_between(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')] | None:
        """
        noise if rest comes from another record of the same posture (n_a, n_a) [(N m)^2]; None: no posture has two records
        """

    @property
    def deviation(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """standard deviation of each measured torque minus rest (n_a) [N m; N]"""

    @property
    def drift(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')] | None:
        """
        drift of the offset as a random walk (n_a, 1) [N m/s^0.5]; None: there are no times that differ
        """

    @property
    def freedom(self) -> int:
        """
        degrees of freedom of the noise: number of rows minus number of records
        """

    @property
    def hysteresis(self) -> Hysteresis:
        """Hysteresis: error that remains after a touch, if rows were touched"""

    @property
    def payload(self) -> Payload | None:
        """Payload that was found, or None"""

    @property
    def rows(self) -> int:
        """number of rows"""

    @property
    def records(self) -> int:
        """number of records"""

    @property
    def postures(self) -> int:
        """number of postures"""

    @property
    def touched(self) -> list[int]:
        """
        indices of rows that were left out, since something seems to touch the robot
        """

    @property
    def notes(self) -> list[str]:
        """remarks, one sentence each"""

    def calc_rest(self, q: numpy.typing.ArrayLike) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        Returns the torque offset at a posture, payload included (n_a) [N m; N]. q: configuration (n_q), or joint positions alone (n_a).
        """

    def calc_noise(self, *, touch: numpy.typing.ArrayLike | None = None, seconds: float = 0.0, rest_rows: int = 1) -> TorqueNoise:
        """
        Returns the TorqueNoise of a measured torque minus the torque offset.

          touch: largest torque of each joint during the last touch (n_a) [N m; N]. None: there was no touch.
          seconds: time since that touch [s], >= 0.
          rest_rows: number of rows whose mean is the offset, >= 1.
        """

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def calibrate(model: Model, q: numpy.typing.ArrayLike, tau: numpy.typing.ArrayLike, *, t: numpy.typing.ArrayLike | None = None, records: Sequence[int] | None = None, touched: Sequence[bool | numpy.bool_] | None = None, payload: str | None = None, same_posture: float = 0.05, settle: float = 1.0, unmeasured: Sequence[int | str] = []) -> Calibration:
    """
    Estimates offset, noise and drift of a robot's external joint torques from measurements at rest, and an unknown payload.

    Call it before Sensor.sense(): its arguments rest, noise and freedom take the results.

      model: Model with the robot.
      q, tau: measured joint positions and torques (rows, n_a) [rad or m], [N m; N]. Each row is one measurement without contact.
      t: times of the rows [s] (rows), or None.
      records: number of the record that each row belongs to (rows). None: all rows are one record.
      touched: True for each row in which something touches the robot (rows), or None. These rows, and rows up to `settle` seconds later, do
        not count as rest. They show the error that a touch leaves (Hysteresis).
      payload: link that may carry a payload, as "robot/link". This needs rest in three postures or more. None: no payload.
      same_posture: largest difference of joint positions within one posture [rad or m].
      settle: time after a touch until the torques are at rest again [s].
      unmeasured: joints without a torque sensor, by index or name. Their noise is returned as 1, and their rest as 0.

    Returns a Calibration. Raises InvalidInput: wrong sizes, no record with two rows, a torque that never changes, or many touched rows.
    """

class SignCheck:
    """Result of check_sign(): the sign convention of the measured torques."""

    @property
    def sign(self) -> int:
        """
        1: torques of the motors on the links; -1: the opposite sign; 0: these are not total torques of this model
        """

    @property
    def factor(self) -> float:
        """
        measured torques as a multiple of the torques that hold the robot against gravity
        """

    @property
    def message(self) -> str:
        """explanation, or advice"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def check_sign(model: Model, q: numpy.typing.ArrayLike, tau: numpy.typing.ArrayLike) -> SignCheck:
    """
    Determines the sign convention of measured total joint torques, by comparison with gravity.

      q, tau: joint positions and total torques at rest (rows, n_a).

    Returns a SignCheck.
    """

def calc_holding_torques(model: Model, q: numpy.typing.ArrayLike) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
    """
    Returns the motor torques that hold the robots against gravity (n_a) [N m; N]. q: configuration (n_q), or joint positions alone (n_a).
    """

class JointFriction:
    """
    Friction of each joint, coulomb tanh(qd/stiction_speed) + viscous qd, and the offset of its torque sensor.
    """

    @property
    def coulomb(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """Coulomb friction (n_a) [N m; N]"""

    @property
    def viscous(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """viscous friction (n_a) [N m s/rad; N s/m]"""

    @property
    def offset(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """offset of the torque sensor (n_a) [N m; N]"""

    @property
    def stiction_speed(self) -> float:
        """speed below which the sign of friction is uncertain [rad/s or m/s]"""

    @property
    def left(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        standard deviation of the residual torques of the fit, noise included (n_a) [N m; N]
        """

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def observe(model: Model, t: numpy.typing.ArrayLike, q: numpy.typing.ArrayLike, qd: numpy.typing.ArrayLike, tau: numpy.typing.ArrayLike, *, time_constant: float = 0.02, friction: JointFriction | None = None) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
    """
    Estimates external torques from motion and motor torques with a momentum observer, which needs no accelerations.

    Its result is the argument tau of Sensor.sense().

      model: Model with the robot.
      t: times, increasing [s] (time).
      q, qd: joint positions [rad or m] and velocities [rad/s or m/s] (time, n_a).
      tau: torques of the motors on the links [N m; N] (time, n_a), as torque sensors at the joints measure them. The model has no rotors:
        if these are torques of the motors themselves, the torques that accelerate their rotors (`armature` of an MJCF) look external.
      time_constant: lag of the estimate [s], > 0.
      friction: JointFriction of identify_friction(). None: no friction.

    Returns the external torques [N m; N] (time, n_a). Raises InvalidInput: wrong sizes, numbers that are not finite, times that do not
    increase, a robot without masses.
    """

def identify_friction(model: Model, t: numpy.typing.ArrayLike, q: numpy.typing.ArrayLike, qd: numpy.typing.ArrayLike, tau: numpy.typing.ArrayLike, *, time_constant: float = 0.02, stiction_speed: float = 0.01) -> JointFriction:
    """
    Identifies the friction of each joint from a motion without contact, in which every joint moves in both directions.

      model, t, q, qd, tau, time_constant: as in observe().
      stiction_speed: speed below which the sign of friction is uncertain [rad/s or m/s], > 0.

    Returns a JointFriction. Raises InvalidInput: as observe(), or a joint that does not move in both directions.
    """

class TouchOnset:
    """
    Detects when a touch begins, and averages the torques since then.

    Without contact, the detector tracks the slow offset of the torques. A change test sums up the differences from this offset. When a touch
    begins, the offset is held, and the mean of the torques becomes more accurate with every row: use it as
    sense(q, onset.mean, rest=onset.rest, noise=onset.noise). Only one thread may use a detector.

      rest: torques without contact (n) [N m; N].
      noise: standard deviations of one row (n), or their covariance (n, n), as Calibration.within.
      drift: drift of the offset as a random walk (n) [N m/s^0.5]. None: no drift.
      hysteresis, settle: error that a touch leaves, as in Calibration.hysteresis. For `settle` seconds after a touch [s], the offset has an
        error of this share of the torques of the touch.
      false_alarms: share of rows without contact at which a false alarm begins, in (0, 0.1).
      shift: change of the torques that is to be detected soonest, in standard deviations of the noise, > 0.
      rest_rows: number of rows whose mean is `rest`.
      quiet: number of rows within the noise that end a touch, >= 1.

    Raises InvalidInput, which names the argument.
    """

    def __init__(self, rest: numpy.typing.ArrayLike, noise: numpy.typing.ArrayLike | numpy.typing.ArrayLike, *, drift: numpy.typing.ArrayLike | None = None, hysteresis: float = 0.0, settle: float = 1.0, false_alarms: float = 1.388888888888889e-06, shift: float = 2.0, rest_rows: int = 1, quiet: int = 5) -> None: ...

    def update(self, tau: numpy.typing.ArrayLike, dt: float) -> bool:
        """
        Processes one row of torques (n) [N m; N], measured dt [s] after the previous row. Returns True while something touches.
        """

    @property
    def touches(self) -> bool:
        """True: something touches"""

    @property
    def rows(self) -> int:
        """number of rows since the touch began"""

    @property
    def rest(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """offset of the torques before the touch (n) [N m; N]"""

    @property
    def mean(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """mean of the torques since the touch began (n) [N m; N]"""

    @property
    def noise(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')]:
        """covariance of mean - rest (n, n) [(N m)^2]"""

    @property
    def sum(self) -> float:
        """sum of the change test"""

    @property
    def bound(self) -> float:
        """value of `sum` from which a touch counts as detected"""

    def __reduce__(self) -> tuple: ...

class Sensor:
    """
    Locates contacts on the links of a robot from joint torques.

    A sensor holds sample points on the surface of each link. Make it once and call sense() for every measurement. It is immutable, and threads
    may share it.

      model: Model with at least one robot.
      links: names of the links to sense, as "robot/link"; * matches any characters. Empty: all links that a joint moves and that have geometry.
      samples: number of sample points on each link, >= 1.
      sampling: distribution of the sample points.
      normals: kind of surface normals.
      seed: of the sample points, and of the postures in the visibility test of the surface.
      surface: SurfaceOptions.

    Raises InvalidInput: a pattern matches no link, or a link is not moved by a joint or has no surface.

        >>> model = st.load_model({"robots": [{"name": "arm", "urdf": "package://example-robot-data/robots/ur_description/urdf/ur5_robot.urdf"}]})
        >>> sensor = st.Sensor(model, links=["arm/forearm_link"], samples=200)
        >>> q, link = np.array([0.3, -1.2, 1.6, -2.0, -1.6, 0.4]), sensor.links[0]
        >>> tau = st.calc_contact_torque(model, q, link.name, link.p_L[50], -20 * link.n_L[50])  # a push of 20 N
        >>> result = sensor.sense(q, tau)
        >>> result.verdict, result.calc_distance(link.name, link.p_L[50]) < 0.02
        (Verdict.Explained, True)
    """

    def __init__(self, model: Model, *, links: Sequence[str] = [], samples: int = 500, sampling: Sampling = Sampling.Stratified, normals: Normals = Normals.Flat, seed: int = 0, surface: SurfaceOptions = ...) -> None: ...

    @property
    def model(self) -> Model:
        """model of the robot"""

    @property
    def links(self) -> list[SensedLink]:
        """sensed links, in the order of the model"""

    @property
    def notes(self) -> list[str]:
        """
        remarks, one sentence each: faces that were left out, and links with too few joints to locate a contact
        """

    def calc_residuals(self, q: numpy.typing.ArrayLike, tau: numpy.typing.ArrayLike, link: str, p_L: numpy.typing.ArrayLike, n_L: numpy.typing.ArrayLike, *, friction: float = 1.0, rays: int = 4) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        Computes the residual l(p) = min over f in the cone of |J_C^T f - tau|^2 at given points (4.5).

          q: configuration (n_q), or joint positions alone (n_a).
          tau: external torques (n_a) [N m; N].
          link: name of the link, as "robot/link".
          p_L, n_L: points and outward normals in the frame of the link (points, 3) [m].
          friction, rays: friction cone, as in sense().

        Returns the residuals [(N m)^2] (points).
        """

    def calc_undetectability(self, link: str, p_L: numpy.typing.ArrayLike, n_L: numpy.typing.ArrayLike, *, friction: float = 1.0, epsilon: float) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        Computes the undetectability eta at given points (4.8): the share of unit forces of the exact cone whose torque is small.

          link: name of the link, as "robot/link".
          p_L, n_L: points and outward normals in the frame of the link (points, 3) [m].
          friction: friction coefficient of the cone.
          epsilon: a torque of at most this per unit of force is small [N m/N], > 0.

        Returns eta (points).
        """

    def calc_detectability(self, link: str, *, friction: float = 1.0, rays: int = 4, epsilon: float) -> DetectabilityMap:
        """
        Computes whether contacts at the samples of a link cause a torque in the last joint before the link (4.7), (4.8).

          link: name of the link, as "robot/link".
          friction, rays: friction cone, as in sense().
          epsilon: a torque of at most this per unit of force is small [N m/N], > 0.

        Returns a DetectabilityMap.
        """

    def sense(self, q: numpy.typing.ArrayLike, tau: numpy.typing.ArrayLike, last: SenseResult | None = None, *, friction: float = 1.0, rays: int = 4, noise: float | numpy.typing.ArrayLike | numpy.typing.ArrayLike = 0.1, threshold: float | None = None, accept: float | None = None, accept_share: float = 0.05, tolerance: float = 0.01, method: RejectionSampling | SteepestDescent | GaussNewton = ..., merge: float = 3.0, thin: float = 2.0, plausible_force: float | None = None, friction_error: float = 0.0, rest: Calibration | numpy.typing.ArrayLike | None = None, sign: int = 1, unmeasured: Sequence[int | str] = [], posterior: bool | numpy.bool_ = False, touch_prior: float = 0.5, freedom: float | numpy.typing.ArrayLike | None = None) -> SenseResult:
        """
        Finds all single contacts on the sensed links that explain the joint torques of one measurement.

          q: configuration (n_q), or joint positions alone (n_a) [rad or m]; objects are then at their placed frames.
          tau: external torques (n_a), in the order of u: the measured torques minus the torques of gravity and motion [N m; N].
          last: SenseResult of the previous cycle. The search also starts from its candidates. None: no previous result.

        Returns a SenseResult with the candidates.

        Options:
          friction: friction coefficient of the cone of possible contact forces (4.2).
          rays: number of rays of this cone, in [3, 64]. 0: the exact cone.
          noise: standard deviation of every torque [N m], > 0; or one for each joint (n_a), or the covariance (n_a, n_a), as Calibration.noise.
          rest: measured torques without contact (n_a), or a Calibration. None: 0.
          sign: -1 if the robot reports the torques that it exerts on its surroundings, as libfranka does; otherwise 1.
          unmeasured: joints without a torque sensor, by index or name. Their torques count as unknown, not as 0.
          threshold: the search for contacts begins if max |tau| is at least this [N m], > 0. None: 4 times the noise of the joint, or more if the
            noise is known from few rows.
          accept: largest residual l of an accepted sample [(N m)^2]. None: accept_share |tau|^2, or the residual that noise may cause if that is
            more.
          tolerance: share of |tau| that a contact may leave unexplained if there is no noise.
          method: GaussNewton(), SteepestDescent() (algorithm 4) or RejectionSampling().
          merge: points closer than this many sample spacings form one candidate.
          thin: Gauss-Newton skips starts within this many sample spacings of an earlier start or result, >= 0.
          plausible_force: plausible contact force F [N], > 0. Candidates that explain the torques are ordered by l + (noise/F)^2 |f|^2. None: the
            force that the weakest joint holds at its full reach.
          friction_error: share by which the true friction may be larger, in [0, 1). It is used if no contact explains the torques.
          posterior: True: also compute SenseResult.posterior, and order the candidates that explain the torques by probability.
          touch_prior: prior probability of a contact, in (0, 1).
          freedom: degrees of freedom of the noise estimate, one number or one for each joint (n_a), > 0, as Calibration.freedom. None: the noise is
            known exactly.

        Raises InvalidInput, which names the argument: wrong sizes, numbers that are not finite, options out of range.
        """

    def sense_series(self, q: numpy.typing.ArrayLike, tau: numpy.typing.ArrayLike, *, friction: float = 1.0, rays: int = 4, noise: float | numpy.typing.ArrayLike | numpy.typing.ArrayLike = 0.1, threshold: float | None = None, accept: float | None = None, accept_share: float = 0.05, tolerance: float = 0.01, method: RejectionSampling | SteepestDescent | GaussNewton = ..., merge: float = 3.0, thin: float = 2.0, plausible_force: float | None = None, friction_error: float = 0.0, rest: Calibration | numpy.typing.ArrayLike | None = None, sign: int = 1, unmeasured: Sequence[int | str] = [], posterior: bool | numpy.bool_ = False, touch_prior: float = 0.5, freedom: float | numpy.typing.ArrayLike | None = None) -> list[SenseResult]:
        """
        Calls sense() for a series of measurements. Each search also starts from the candidates of the previous measurement.

          q: configurations (time, n_q), or joint positions alone (time, n_a).
          tau: external torques (time, n_a) [N m; N].

        Returns a list with one SenseResult for each measurement.

        Options:
          friction: friction coefficient of the cone of possible contact forces (4.2).
          rays: number of rays of this cone, in [3, 64]. 0: the exact cone.
          noise: standard deviation of every torque [N m], > 0; or one for each joint (n_a), or the covariance (n_a, n_a), as Calibration.noise.
          rest: measured torques without contact (n_a), or a Calibration. None: 0.
          sign: -1 if the robot reports the torques that it exerts on its surroundings, as libfranka does; otherwise 1.
          unmeasured: joints without a torque sensor, by index or name. Their torques count as unknown, not as 0.
          threshold: the search for contacts begins if max |tau| is at least this [N m], > 0. None: 4 times the noise of the joint, or more if the
            noise is known from few rows.
          accept: largest residual l of an accepted sample [(N m)^2]. None: accept_share |tau|^2, or the residual that noise may cause if that is
            more.
          tolerance: share of |tau| that a contact may leave unexplained if there is no noise.
          method: GaussNewton(), SteepestDescent() (algorithm 4) or RejectionSampling().
          merge: points closer than this many sample spacings form one candidate.
          thin: Gauss-Newton skips starts within this many sample spacings of an earlier start or result, >= 0.
          plausible_force: plausible contact force F [N], > 0. Candidates that explain the torques are ordered by l + (noise/F)^2 |f|^2. None: the
            force that the weakest joint holds at its full reach.
          friction_error: share by which the true friction may be larger, in [0, 1). It is used if no contact explains the torques.
          posterior: True: also compute SenseResult.posterior, and order the candidates that explain the torques by probability.
          touch_prior: prior probability of a contact, in (0, 1).
          freedom: degrees of freedom of the noise estimate, one number or one for each joint (n_a), > 0, as Calibration.freedom. None: the noise is
            known exactly.

        Raises InvalidInput, which names the argument: wrong sizes, numbers that are not finite, options out of range.
        """

    def sense_touch(self, q: numpy.typing.ArrayLike, tau: numpy.typing.ArrayLike, correlation: float = 0.0, *, friction: float = 1.0, rays: int = 4, noise: float | numpy.typing.ArrayLike | numpy.typing.ArrayLike = 0.1, threshold: float | None = None, accept: float | None = None, accept_share: float = 0.05, tolerance: float = 0.01, method: RejectionSampling | SteepestDescent | GaussNewton = ..., merge: float = 3.0, thin: float = 2.0, plausible_force: float | None = None, friction_error: float = 0.0, rest: Calibration | numpy.typing.ArrayLike | None = None, sign: int = 1, unmeasured: Sequence[int | str] = [], posterior: bool | numpy.bool_ = False, touch_prior: float = 0.5, freedom: float | numpy.typing.ArrayLike | None = None) -> SenseResult:
        """
        Locates one contact from several measurements: the same point on the same link, with a different force in each measurement.

          q: configurations (moments, n_q), or joint positions alone (moments, n_a).
          tau: external torques (moments, n_a) [N m; N].
          correlation: correlation of the errors of the measurements, in [0, 1]: m measurements count as m/(1 + (m - 1) correlation). An error of
            `rest`, for example, is common to all measurements.

        Returns a SenseResult. Its candidates come from the measurement whose torques are largest relative to their noise. It always has
        probabilities.

        Options:
          friction: friction coefficient of the cone of possible contact forces (4.2).
          rays: number of rays of this cone, in [3, 64]. 0: the exact cone.
          noise: standard deviation of every torque [N m], > 0; or one for each joint (n_a), or the covariance (n_a, n_a), as Calibration.noise.
          rest: measured torques without contact (n_a), or a Calibration. None: 0.
          sign: -1 if the robot reports the torques that it exerts on its surroundings, as libfranka does; otherwise 1.
          unmeasured: joints without a torque sensor, by index or name. Their torques count as unknown, not as 0.
          threshold: the search for contacts begins if max |tau| is at least this [N m], > 0. None: 4 times the noise of the joint, or more if the
            noise is known from few rows.
          accept: largest residual l of an accepted sample [(N m)^2]. None: accept_share |tau|^2, or the residual that noise may cause if that is
            more.
          tolerance: share of |tau| that a contact may leave unexplained if there is no noise.
          method: GaussNewton(), SteepestDescent() (algorithm 4) or RejectionSampling().
          merge: points closer than this many sample spacings form one candidate.
          thin: Gauss-Newton skips starts within this many sample spacings of an earlier start or result, >= 0.
          plausible_force: plausible contact force F [N], > 0. Candidates that explain the torques are ordered by l + (noise/F)^2 |f|^2. None: the
            force that the weakest joint holds at its full reach.
          friction_error: share by which the true friction may be larger, in [0, 1). It is used if no contact explains the torques.
          posterior: True: also compute SenseResult.posterior, and order the candidates that explain the torques by probability.
          touch_prior: prior probability of a contact, in (0, 1).
          freedom: degrees of freedom of the noise estimate, one number or one for each joint (n_a), > 0, as Calibration.freedom. None: the noise is
            known exactly.

        Raises InvalidInput, which names the argument: wrong sizes, numbers that are not finite, options out of range.
        """

    def sense_contacts(self, q: numpy.typing.ArrayLike, tau: numpy.typing.ArrayLike, base: BaseWrench | None = None, last: ContactSets | None = None, *, max_contacts: int = 2, friction: float = 1.0, rays: int = 4, noise: float | numpy.typing.ArrayLike | numpy.typing.ArrayLike = 0.1, threshold: float | None = None, tolerance: float = 0.01, starts: int = 24, descents: int = 6, rest: Calibration | numpy.typing.ArrayLike | None = None, sign: int = 1, unmeasured: Sequence[int | str] = []) -> ContactSets:
        """
        Finds one to three simultaneous contacts that explain the torques of one measurement, with as few contacts as possible.

        Each contact has 5 unknown numbers. If there are fewer torques than unknowns, the contacts are not unique: see ContactSet.freedom.

          q: configuration (n_q), or joint positions alone (n_a) [rad or m].
          tau: external torques (n_a) [N m; N].
          base: BaseWrench of a sensor under the base, or None.
          last: ContactSets of the previous measurement, or None. If one of its sets, improved by descent, explains these torques, and fewer
            contacts do not, the search ends there.
          max_contacts: largest number of contacts, in [1, 3].
          starts: number of first contacts that are tried on each link, >= 1.
          descents: number of descents for each combination of links, >= 1.
          friction, rays, noise, threshold, tolerance, rest, sign, unmeasured: as in sense(); rays in [3, 64].

        Returns ContactSets. Raises InvalidInput, which names the argument.
        """

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

    def __copy__(self) -> Self: ...

    def __deepcopy__(self, memo: object, /) -> Self: ...

class BaseWrench:
    """
    Measurement of a force and moment sensor under the base of a robot.

      force_W: sum of the contact forces in W [N] (3).
      moment_W: sum of their moments about the origin of W [N m] (3).
      force_noise, moment_noise: standard deviation of each component [N], [N m], > 0.
    """

    def __init__(self, force_W: numpy.typing.ArrayLike, moment_W: numpy.typing.ArrayLike, *, force_noise: float = 1.0, moment_noise: float = 0.1) -> None: ...

    @property
    def force_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """sum of the contact forces in W [N] (3)"""

    @property
    def moment_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """sum of the moments about the origin of W [N m] (3)"""

    @property
    def force_noise(self) -> float:
        """standard deviation of each force component [N]"""

    @property
    def moment_noise(self) -> float:
        """standard deviation of each moment component [N m]"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def calc_base_wrench(p_W: numpy.typing.ArrayLike, f_W: numpy.typing.ArrayLike) -> BaseWrench:
    """
    Returns the BaseWrench of a single contact force f_W [N] (3) at the point p_W [m] (3).
    """

class SetContact:
    """One contact of a ContactSet."""

    @property
    def link(self) -> str:
        """link in contact, as robot/link"""

    @property
    def p_L(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """contact point in the frame of the link [m] (3)"""

    @property
    def n_L(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """outward unit normal in the frame of the link (3)"""

    @property
    def f_L(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """force on the robot in the frame of the link [N] (3)"""

    @property
    def deviation(self) -> float:
        """
        standard deviation of the point [m]; the size of the link if the torques do not determine the point
        """

    @property
    def is_unique(self) -> bool:
        """
        True: no change of points and forces that keeps all torques moves this point
        """

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class ContactSet:
    """Simultaneous contacts that together explain the torques."""

    @property
    def contacts(self) -> list[SetContact]:
        """contacts, ordered by link"""

    @property
    def residual(self) -> float:
        """squared torques that the contacts leave unexplained (Y.9) [(N m)^2]"""

    @property
    def freedom(self) -> int:
        """
        dimension of the nearby points and forces with the same torques; 0: the solution is isolated
        """

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class ContactSets:
    """Sets of simultaneous contacts that explain one measurement."""

    @property
    def verdict(self) -> Verdict:
        """whether contacts explain the torques"""

    @property
    def count(self) -> int:
        """
        number of contacts in each set: the smallest number that explains the torques
        """

    @property
    def ambiguous(self) -> bool:
        """
        True: several combinations of links explain the torques, or points and forces can change together without a change of the torques
        """

    @property
    def sets(self) -> list[ContactSet]:
        """
        sets that explain the torques, ordered by combination of links; if no set does, the best one
        """

    @property
    def best(self) -> list[ContactSet]:
        """the best set of each combination of links, the best combination first"""

    @property
    def explained(self) -> float:
        """largest residual that counts as explained [(N m)^2]"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def calc_contact_torque(model: Model, q: numpy.typing.ArrayLike, link: str, p_L: numpy.typing.ArrayLike, f_L: numpy.typing.ArrayLike) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
    """
    Computes the joint torques that a contact force on a link causes (Y.1).

      model: Model with the robot.
      q: configuration (n_q), or joint positions alone (n_a).
      link: name of the link, as "robot/link".
      p_L: contact point in the frame of the link [m] (3).
      f_L: force on the robot in the frame of the link [N] (3).

    Returns the torques (n_a) [N m; N].
    """

class KnownContact:
    """Contact from which the torques of a scenario were computed."""

    @property
    def link(self) -> str:
        """link in contact, as robot/link"""

    @property
    def p_L(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """contact point in the frame of the link [m] (3)"""

    @property
    def f_L(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """force on the robot in the frame of the link [N] (3)"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class SensingScenario:
    """
    Scenario for sense(): a robot and its measured joint torques (tasks/schema/sensing.schema.json).
    """

    @property
    def name(self) -> str:
        """name of the scenario"""

    @property
    def description(self) -> str:
        """one line about the scenario"""

    @property
    def file(self) -> pathlib.Path:
        """path of the scenario file"""

    @property
    def sensor(self) -> Sensor:
        """sensor of the robot"""

    @property
    def times(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """times of the measurements [s] (time)"""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """joint positions [rad or m] (time, n_a)"""

    @property
    def tau(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """torques as measured [N m; N] (time, n_a)"""

    @property
    def notes(self) -> list[str]:
        """
        remarks on the data file, one sentence each: columns that were not read, or that need an explanation
        """

    @property
    def pushed(self) -> list[list[int]]:
        """
        for a simulated robot, the indices into `contacts` of the pushes that act at each time (time); otherwise empty
        """

    @property
    def contact(self) -> KnownContact | None:
        """
        contact of the file, if it gives a single contact instead of torques; otherwise None
        """

    @property
    def contacts(self) -> list[KnownContact]:
        """contacts of the file, if it gives contacts instead of torques"""

    @property
    def noise(self) -> float | Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')]:
        """
        standard deviation of each torque [N m], or the covariance of all (n_a, n_a)
        """

    @property
    def rest(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        torques without contact, which are subtracted from `tau` (n_a) [N m; N]
        """

    @property
    def sign(self) -> float:
        """
        -1: `tau` are torques of the robot on its surroundings; otherwise 1. External torques are sign (tau - rest)
        """

    def calc_residual_shares(self, q: numpy.typing.ArrayLike, tau: numpy.typing.ArrayLike, friction: float) -> list[Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]]:
        """
        Computes which share of the torques the best single force at a sample leaves unexplained, with the options of the scenario.

          q: configuration (n_q), or joint positions alone (n_a) [rad or m].
          tau: torques as in `tau` of the scenario (n_a) [N m; N].
          friction: friction coefficient.

        Returns sqrt(l)/|tau| with the residual l of (4.5) at the samples of each link of the sensor, in [0, 1]; 1 where the torques are 0. Torques
        are relative to their noise if it differs between joints. Raises InvalidInput: wrong sizes, numbers that are not finite.
        """

    def sense(self, q: numpy.typing.ArrayLike, tau: numpy.typing.ArrayLike, last: SenseResult | None = None) -> SenseResult:
        """
        Finds the single contacts that explain one measurement, as Sensor.sense() does, with the options of the scenario.

          q: configuration (n_q), or joint positions alone (n_a) [rad or m].
          tau: torques as in `tau` of the scenario (n_a) [N m; N].
          last: SenseResult of the previous measurement, or None.

        Returns a SenseResult. Raises InvalidInput: wrong sizes, numbers that are not finite.
        """

    @property
    def max_contacts(self) -> int:
        """largest number of simultaneous contacts"""

    @property
    def base_wrench(self) -> BaseWrench | None:
        """
        measured force and moment under the base, or None; for a simulated robot only the noise of the sensor
        """

    @property
    def base_wrenches(self) -> list[BaseWrench]:
        """measured forces and moments under the base (time); empty: none"""

    def sense_contacts(self, q: numpy.typing.ArrayLike, tau: numpy.typing.ArrayLike, base: BaseWrench | None = None, last: ContactSets | None = None) -> ContactSets:
        """
        Finds simultaneous contacts that explain one measurement, as Sensor.sense_contacts() does, with the options of the scenario.

          q: configuration (n_q), or joint positions alone (n_a) [rad or m].
          tau: torques as in `tau` of the scenario (n_a) [N m; N].
          base: BaseWrench, or None.
          last: ContactSets of the previous measurement, or None.

        Returns ContactSets with at most max_contacts contacts. Raises InvalidInput: wrong sizes, numbers that are not finite.
        """

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

@overload
def load_sensing_scenario(scenario: str | str | os.PathLike) -> SensingScenario:
    """
    Loads a scenario for sense(): the name of a built-in one, or a file. Raises InvalidInput: "FILE:LINE: field: got …".

        >>> scenario = st.load_sensing_scenario("ur5_forearm")
        >>> scenario.tau.shape, scenario.contact.link
        ((1, 6), 'arm/forearm_link')
    """

@overload
def load_sensing_scenario(scenario: dict, *, base: str | os.PathLike | None = None) -> SensingScenario:
    """
    Makes a scenario from a dict with the keys of a file. base: folder to which its paths are relative; None: the working folder. Raises InvalidInput: "field: got …".
    """

@overload
def sense(scenario: SensingScenario) -> list[SenseResult]:
    """
    Locates contacts on a robot from its joint torques, for every measurement of a scenario.

    For your own robot, make a Sensor and call its method sense().

      scenario: SensingScenario, or its name or file. Its options are used.

    Returns a list with one SenseResult for each measurement. Each search also starts from the candidates of the previous measurement.

        >>> [result.verdict for result in st.sense("ur5_forearm")]
        [Verdict.Explained]
    """

@overload
def sense(scenario: str | str | os.PathLike) -> list[SenseResult]:
    """
    The same for load_sensing_scenario(scenario): give the name or file of a scenario.
    """

class _SharedSensor:
    def __reduce__(self) -> tuple: ...

    def __copy__(self) -> Self: ...

    def __deepcopy__(self, memo: object, /) -> Self: ...

def _make_shared_sensor(model: Model, options: tuple) -> _SharedSensor: ...
