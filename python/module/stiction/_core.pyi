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
    """of the library, as MAJOR.MINOR.PATCH"""

class InvalidInput(ValueError):
    pass

class Status(enum.Enum):
    """
    Outcome of a numerical procedure; mistakes of the caller are InvalidInput.
    """

    Solved = 0
    """the stated tolerance holds"""

    MaxIterations = 1
    """
    stopped at the iteration, node or time budget; the best result so far is returned
    """

    Infeasible = 2
    """proved by a certificate"""

    NumericalFailure = 3
    """arithmetic broke down; results are not to be used"""

    Cancelled = 4
    """the caller asked to stop; the best result so far is returned"""

class Pose:
    """Rigid transform X_AB: a point p_B in B is at R p_B + p in A."""

    def __init__(self, R: numpy.typing.ArrayLike, p: numpy.typing.ArrayLike) -> None:
        """
        R: a rotation (3, 3); p [m] (3)

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
        """of R, in the order w, x, y, z with w not negative (4)"""

    def __matmul__(self, arg: Pose, /) -> Pose: ...

    def inverse(self) -> Pose:
        """X_BA of X_AB"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class BodyKind(enum.Enum):
    """What moves a body."""

    Fixed = 0

    Object = 1

    Robot = 2

class DofKind(enum.Enum):
    """How a coordinate moves."""

    Prismatic = 0

    Revolute = 1

class Body:
    """A rigid body: fixed, of an object, or a link of a robot."""

    @property
    def name(self) -> str: ...

    @property
    def kind(self) -> BodyKind: ...

    @property
    def dofs(self) -> list[int]:
        """velocity indices that move it"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class RobotLink:
    """A link of a robot, and what it hangs on."""

    @property
    def name(self) -> str:
        """of its body, as robot/link"""

    @property
    def parent(self) -> str | None:
        """of the body that it hangs on; None: the link stands in the world"""

    @property
    def moves(self) -> bool:
        """a joint moves it relative to its parent"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Geometry:
    """A shape on a body."""

    @property
    def name(self) -> str: ...

    @property
    def body(self) -> int: ...

    @property
    def X_BG(self) -> Pose: ...

    @property
    def shape(self) -> dict[str, object]:
        """
        its `type` and the numbers of that type, as in a plan file (docs/plan_file.md) [m]; arrays for those of a mesh
        """

    @property
    def friction(self) -> float: ...

    @property
    def max_force(self) -> float:
        """
        Largest normal force that it bears from one other geometry [N], infinite where there is no limit
        """

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Pair:
    """Two geometries that may touch, as indices into Model.geometries."""

    @property
    def geometry_a(self) -> int: ...

    @property
    def geometry_b(self) -> int: ...

    @property
    def friction(self) -> float: ...

    @property
    def torsional(self) -> float:
        """
        Largest moment about the normal, beside the normal force [m]; 0 where contacts do not resist turning; in simulation only
        """

    @property
    def rolling(self) -> float:
        """The same about the tangents [m]"""

    @property
    def max_distance(self) -> float:
        """[m]"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Dof:
    """A coordinate: of an object, or a joint of a robot."""

    @property
    def name(self) -> str: ...

    @property
    def kind(self) -> DofKind: ...

    @property
    def lower(self) -> float:
        """[m or rad]"""

    @property
    def upper(self) -> float:
        """[m or rad]"""

    @property
    def stiffness(self) -> float:
        """K_a [N/m or N m/rad], 0 for objects"""

    @property
    def effort(self) -> float:
        """
        Largest force or torque of the motor [N or N m], infinite where there is no limit
        """

    @property
    def friction(self) -> float:
        """
        Dry friction of a hinge, slider or robot joint [N m or N]; steps know that of objects
        """

    @property
    def damping(self) -> float:
        """
        Viscous friction of a hinge, slider or robot joint [N m s/rad or N s/m], in simulation only
        """

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class ObjectInfo:
    """Where the coordinates of an object stand in q and v."""

    @property
    def name(self) -> str: ...

    @property
    def body(self) -> int: ...

    @property
    def v_begin(self) -> int: ...

    @property
    def n_v(self) -> int: ...

    @property
    def q_begin(self) -> int: ...

    @property
    def n_q(self) -> int: ...

    @property
    def parent(self) -> int:
        """index of the object that it hangs on, or -1"""

    @property
    def mass(self) -> float:
        """[kg]"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Kinematics:
    """Poses of all bodies and axes of all coordinates at one configuration."""

    @property
    def X_WB(self) -> list[Pose]: ...

    @property
    def axis_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3, None), order='F')]:
        """unit axes (3, n_v)"""

    @property
    def origin_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3, None), order='F')]:
        """a point on each axis [m] (3, n_v)"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Scene:
    """What there is, as a scene file says."""

    @property
    def name(self) -> str: ...

    @property
    def gravity(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """[m/s^2], acts on objects only"""

    @property
    def contact_distance(self) -> float:
        """[m]"""

    @property
    def robot_urdfs(self) -> dict[str, str]:
        """
        robot -> its URDF as the file has it now; without what is mounted on it, and without robots of an MJCF
        """

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

@overload
def load_scene(file: str | os.PathLike) -> Scene:
    """
    The scene of a file (YAML, also of a task). Raises InvalidInput: "FILE:LINE: field: got …".
    """

@overload
def load_scene(scene: dict, *, base: str | os.PathLike | None = None) -> Scene:
    """
    The scene of a dict, with the keys of a file. `urdf` and `mjcf` of a robot are paths, or the URDF or MJCF itself as a str. base: the folder that paths in it are relative to; None: the working folder. Raises InvalidInput: "field: got …, expected …".
    """

@overload
def load_model(file: str | os.PathLike) -> Model:
    """Model.make(load_scene(file))."""

@overload
def load_model(scene: dict, *, base: str | os.PathLike | None = None) -> Model:
    """
    Model.make(load_scene(scene, base=base)).

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
    Immutable kinematics, actuation, geometry and friction of a scene, shared by threads.
    """

    @staticmethod
    def make(scene: Scene) -> Model:
        """The model of a scene. Raises InvalidInput."""

    def __reduce__(self) -> tuple: ...

    @property
    def scene(self) -> Scene: ...

    @property
    def n_q(self) -> int: ...

    @property
    def n_v(self) -> int: ...

    @property
    def n_vu(self) -> int:
        """velocity coordinates of the objects"""

    @property
    def n_qu(self) -> int:
        """configuration numbers of the objects"""

    @property
    def n_a(self) -> int:
        """actuated joints, the length of u"""

    @property
    def stiffness(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """K_a (n_a) [N/m or N m/rad]"""

    @property
    def effort(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        Largest forces and torques of the motors (n_a) [N or N m], infinite where there is no limit
        """

    @property
    def speed_limit(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        How fast the joints may be as the URDF says (n_a) [m/s or rad/s], infinite where there is no limit
        """

    @property
    def lower(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """joint limits (n_a) [m or rad]"""

    @property
    def upper(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]: ...

    @property
    def reach(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """bound on the lever of each joint (n_a) [m]"""

    @property
    def joint_names(self) -> list[str]:
        """as robot/joint, in the order of u"""

    @property
    def object_names(self) -> list[str]: ...

    @property
    def bodies(self) -> list[Body]: ...

    @property
    def links(self) -> list[RobotLink]:
        """of all robots, parents first"""

    @property
    def geometries(self) -> list[Geometry]: ...

    @property
    def pairs(self) -> list[Pair]: ...

    @property
    def dofs(self) -> list[Dof]: ...

    @property
    def objects(self) -> list[ObjectInfo]: ...

    @property
    def notes(self) -> list[str]:
        """
        what was taken otherwise than the files say, or chosen where they say nothing
        """

    @property
    def planar_axis(self) -> int | None:
        """axis normal to the plane in which everything moves, or None"""

    def neutral(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        every object at its placed frame, every joint as near to 0 as its limits allow (n_q)
        """

    def joint_index(self, name: str) -> int:
        """of a joint in u. Raises InvalidInput: no such joint"""

    def object_index(self, name: str) -> int:
        """of an object in `objects`. Raises InvalidInput: no such object"""

    def retract(self, q: numpy.typing.ArrayLike, delta: numpy.typing.ArrayLike) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        q ⊕ δ: the only way to move (n_q)

            >>> model = st.load_task("allegro_ball").model
            >>> q = model.neutral()
            >>> delta = np.full(model.n_v, 0.1)
            >>> bool(np.allclose(model.local(q, model.retract(q, delta)), delta))
            True
        """

    def local(self, q0: numpy.typing.ArrayLike, q1: numpy.typing.ArrayLike) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """q1 ⊖ q0 (n_v)"""

    def object_pose(self, q: numpy.typing.ArrayLike, object: str) -> Pose:
        """X_WB of a named object"""

    def object_poses(self, q: numpy.typing.ArrayLike, object: str) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """
        X_WB of a named object at many configurations (N, n_q), as (N, 7): x y z [m], then the quaternion w x y z with w not negative
        """

    def calc_kinematics(self, q: numpy.typing.ArrayLike) -> Kinematics:
        """Poses and axes at q (n_q)."""

    def body_poses(self, q: numpy.typing.ArrayLike) -> dict[str, Pose]:
        """X_WB by name of the body"""

    def __repr__(self) -> str: ...

    def __copy__(self) -> Self: ...

    def __deepcopy__(self, memo: object, /) -> Self: ...

class Visual:
    """What is seen of a body."""

    @property
    def body(self) -> int: ...

    @property
    def X_BV(self) -> Pose: ...

    @property
    def shape(self) -> dict[str, object] | None:
        """as Geometry.shape; None: a mesh"""

    @property
    def mesh(self) -> int | None:
        """index into Visuals.meshes; None: a shape"""

    @property
    def color(self) -> Annotated[NDArray[numpy.float64], dict(shape=(4), order='C')]:
        """red, green, blue, opacity in [0, 1]"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Visuals:
    """Pictures of a scene, as its files show it."""

    @property
    def visuals(self) -> list[Visual]: ...

    @property
    def meshes(self) -> list[tuple[Annotated[NDArray[numpy.float32], dict(shape=(None, 3), order='C')], Annotated[NDArray[numpy.int32], dict(shape=(None, 3), order='C')]]]:
        """vertices (n, 3) [m] and triangles (m, 3) of each"""

    @property
    def notes(self) -> list[str]:
        """what is left out, one sentence each"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def read_visuals(model: Model) -> Visuals:
    """
    Pictures of links and objects as the files of the robots show them: <visual> elements of a URDF, visible geoms of an MJCF. What cannot be read is left out with a note. Bodies that no file shows have none: their geometries stand for them.
    """

class PlacedLinks:
    """Joints with which links have poses."""

    @property
    def status(self) -> Status:
        """
        Solved; MaxIterations: no posture inside the limits has the poses; NumericalFailure: those that have them overlap something
        """

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """the posture that was found, else the nearest to one (n_q)"""

    @property
    def position(self) -> float:
        """how far a link is from where it is to be there, at most [m]"""

    @property
    def angle(self) -> float:
        """the same of its orientation [rad]"""

    @property
    def pair(self) -> int:
        """index into Model.pairs of what overlaps most, or -1"""

    @property
    def depth(self) -> float:
        """by how much [m]"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def place_links(model: Model, q: numpy.typing.ArrayLike, poses: Mapping[str, Pose | numpy.typing.ArrayLike], *, postures: int = 96, overlap: bool = False) -> PlacedLinks:
    """
    Joints with which links have poses, nearest to those of q, inside their limits and without overlap. Objects stay.

      poses: by name of the link ("robot/link", or "link" where one robot has it) its Pose X_WB, or its position (3) alone.
      postures: that the search starts from; 1 starts from q alone, which is fast, and what a link wants that is dragged: no joint leaps.
      overlap: postures in which something overlaps are as good as others.

        >>> task = st.load_task("iiwa_bimanual_box")
        >>> hand = "left/link_7"
        >>> X = task.model.body_poses(task.q_start)[hand]
        >>> placed = st.place_links(task.model, task.q_start, {hand: st.Pose(X.R, X.p + [0, 0, 0.05])})
        >>> placed.status.name, bool(abs(task.model.body_poses(placed.q)[hand].p - X.p)[2] > 0.049)
        ('Solved', True)
    """

class ContactImpulse:
    """
    One contact of a step; the impulse acts on geometry a, its opposite on b.
    """

    @property
    def a(self) -> str:
        """name, as body/geometry"""

    @property
    def b(self) -> str: ...

    @property
    def pair(self) -> int:
        """index into Model.pairs"""

    @property
    def id(self) -> int:
        """stable over time"""

    @property
    def phi(self) -> float:
        """signed distance before the step [m]"""

    @property
    def p_WA(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """[m]"""

    @property
    def p_WB(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """[m]"""

    @property
    def nhat_BA_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """unit normal from b to a"""

    @property
    def t1_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]: ...

    @property
    def t2_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]: ...

    @property
    def friction(self) -> float: ...

    @property
    def lambda_(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """impulse (n, t1, t2) [N s]"""

    @property
    def force(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """force (n, t1, t2) [N]"""

    @property
    def force_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """[N]"""

    @property
    def displacement(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """J_c δq in (n, t1, t2) [m]"""

    @property
    def gap(self) -> float:
        """slack of the row, φ + J_n δq - μ‖J_t δq‖ [m]"""

    @property
    def active(self) -> bool: ...

    @property
    def slide(self) -> float:
        """‖J_t δq‖ [m]"""

    @property
    def anitescu_gap(self) -> float:
        """φ + J_n δq [m]"""

    def calc_wrench(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """force on a and its moment about the world origin, in W [N, N m] (6)"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Residuals:
    """How far a solution is from the conditions of optimality."""

    @property
    def stationarity(self) -> float: ...

    @property
    def primal(self) -> float: ...

    @property
    def complementarity(self) -> float: ...

    @property
    def cone(self) -> float: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class StepResult:
    """What a step came to."""

    @property
    def status(self) -> Status: ...

    @property
    def q_next(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """(n_q)"""

    @property
    def delta(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """δq (n_v)"""

    @property
    def torque(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """of the springs (n_a), within Model.effort with effort_limits [N m, N]"""

    @property
    def joint_friction(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        of hinges and sliders on their coordinates (n_vu), empty where none has any [N m, N]
        """

    @property
    def saturated(self) -> Annotated[NDArray[numpy.bool_], dict(shape=(None,), order='C')]:
        """joints whose motor gives all it has (n_a)"""

    @property
    def contacts(self) -> list[ContactImpulse]: ...

    @property
    def phi(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """signed distances before the step [m] (n_c)"""

    @property
    def gap(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """[m] (n_c)"""

    @property
    def active(self) -> Annotated[NDArray[numpy.bool_], dict(shape=(None,), order='C')]:
        """(n_c)"""

    @property
    def lambda_(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')]:
        """impulses [N s] (n_c, 3)"""

    @property
    def A(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')] | None:
        """D_qnext_q (n_v, n_v), None unless asked for"""

    @property
    def B(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')] | None:
        """D_qnext_u (n_v, n_a), None unless asked for"""

    @property
    def D_lambda_q(self) -> list[Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')]] | None:
        """per contact (3, n_v)"""

    @property
    def D_lambda_u(self) -> list[Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')]] | None:
        """per contact (3, n_a)"""

    @property
    def epsilon(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """regularisation used per object"""

    @property
    def residuals(self) -> Residuals: ...

    @property
    def iterations(self) -> int: ...

    @property
    def h(self) -> float:
        """[s]"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class LocalModel:
    """q_next(q ⊕ δq, u + δu) ≈ c ⊕ (A δq + B δu)."""

    @property
    def status(self) -> Status: ...

    @property
    def c(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]: ...

    @property
    def A(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')] | None:
        """None unless asked for"""

    @property
    def B(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')]: ...

    @property
    def failed(self) -> int:
        """samples whose step had no solution"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Knot:
    """State after one sub-step."""

    @property
    def u(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]: ...

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]: ...

    @property
    def contacts(self) -> list[ContactImpulse]:
        """the active ones"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class RolloutResult:
    """Sub-steps of one motion of the command."""

    @property
    def status(self) -> Status: ...

    @property
    def knots(self) -> list[Knot]: ...

    @property
    def steps(self) -> int: ...

    @property
    def max_slide(self) -> float:
        """[m]"""

    @property
    def min_phi(self) -> float:
        """[m]"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Exact:
    """The contact dynamics themselves (2.6)."""

    def __init__(self) -> None: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Analytic:
    """
    Smoothed by a log barrier of weight kappa [1/J], > 0 (2.27); contacts between robots and joint limits by factors of it.
    """

    def __init__(self, *, kappa: float = 100.0, self_sharpness: float = 10.0, limit_sharpness: float = 10.0) -> None: ...

    @property
    def kappa(self) -> float: ...

    @property
    def self_sharpness(self) -> float: ...

    @property
    def limit_sharpness(self) -> float: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class RandomizedFirstOrder:
    """Averages of exact steps and their derivatives (2.22)."""

    def __init__(self, *, std_q: numpy.typing.ArrayLike, std_u: numpy.typing.ArrayLike, samples: int = 100, seed: int = 0) -> None: ...

    @property
    def std_q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]: ...

    @property
    def std_u(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]: ...

    @property
    def samples(self) -> int: ...

    @property
    def seed(self) -> int: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class RandomizedZerothOrder:
    """Least-squares fit to exact steps (2.23)."""

    def __init__(self, *, std_q: numpy.typing.ArrayLike, std_u: numpy.typing.ArrayLike, samples: int = 100, seed: int = 0) -> None: ...

    @property
    def std_q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]: ...

    @property
    def std_u(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]: ...

    @property
    def samples(self) -> int: ...

    @property
    def seed(self) -> int: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class ByRule:
    """
    Regularisation of the objects in units of the springs, > 0 (docs/theory/step.md).
    """

    def __init__(self, *, ratio: float = 0.1) -> None: ...

    @property
    def ratio(self) -> float: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class FixedEpsilon:
    """Regularisation of the objects, 1 for their true mass, > 0 (2.6c)."""

    def __init__(self, *, epsilon: float = 1.0) -> None: ...

    @property
    def epsilon(self) -> float: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class SecondOrderCone:
    """Friction of spatial models; planar ones have two rays, which is exact."""

    def __init__(self) -> None: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class PolyhedralCone:
    """A pyramid of rays inside the friction cone, in [3, 64]."""

    def __init__(self, *, rays: int = 4) -> None: ...

    @property
    def rays(self) -> int: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class FrictionLaw(enum.Enum):
    """What a sliding contact does."""

    Anitescu = 0
    """it opens by mu |J_t dq| (2.3.4)"""

    Coulomb = 1
    """
    it stays closed (S.14), in exact steps of spatial models with second-order cones
    """

class StepWorkspace:
    """Scratch and warm starts of steps; for one thread at a time."""

    def __init__(self, model: Model) -> None: ...

    def forget(self) -> None:
        """drops warm starts, so that the next step depends on its input alone"""

    def __reduce__(self) -> tuple: ...

def step(model: Model, q: numpy.typing.ArrayLike, u: numpy.typing.ArrayLike, *, tau_ext: numpy.typing.ArrayLike | None = None, damping: numpy.typing.ArrayLike | None = None, with_A: bool | numpy.bool_ = False, with_B: bool | numpy.bool_ = False, with_force_derivatives: bool | numpy.bool_ = False, warm_start: bool | numpy.bool_ = True, workspace: StepWorkspace | None = None, h: float = 0.1, smoothing: Exact | Analytic = ..., regularisation: ByRule | FixedEpsilon = ..., friction_cone: SecondOrderCone | PolyhedralCone = ..., friction_law: FrictionLaw = FrictionLaw.Anitescu, friction_scale: float = 1.0, contact_margin: float = 0.0, joint_limits: bool | numpy.bool_ = True, effort_limits: bool | numpy.bool_ = False, tol_complementarity: float = 1e-10, kappa: float | None = None, epsilon: float | None = None) -> StepResult:
    """
    One quasi-static step: the configuration in which the robots' springs, commanded to u, and the contacts are in balance (2.6).

      q: configuration (n_q): objects first, quaternions of length 1.
      u: commanded joint positions (n_a) [m or rad].
      tau_ext: generalised forces besides gravity (n_v) [N, N m]; None: 0.
      damping: viscous force -damping dq/h per coordinate (n_v) [N s/m, N m s/rad], >= 0; None: 0.
      with_A, with_B, with_force_derivatives: the derivatives StepResult.A, .B and .D_lambda_q, .D_lambda_u.
      warm_start: from the step before in the workspace.
      workspace: scratch, of one thread at a time; None: one for this call.

    status: Solved; MaxIterations; Infeasible (overlap that no motion within reach undoes); NumericalFailure.

        >>> task = st.load_task("planar_pushing")
        >>> result = st.step(task.model, task.q_start, [0.0, 0.1], h=0.1, smoothing=st.Analytic(kappa=100), with_B=True)
        >>> result.status, result.q_next.shape, result.B.shape
        (Status.Solved, (5,), (5, 2))

    Arguments of the step:
      h: time step [s], > 0.
      smoothing: Exact() (2.6), or Analytic(kappa=...) [1/J] (2.27).
      regularisation: of the objects: ByRule(ratio=...) (docs/theory/step.md), or FixedEpsilon(epsilon=...), 1 for their true mass.
      friction_cone: SecondOrderCone(), or PolyhedralCone(rays=...).
      friction_law: of exact steps: Anitescu, sliding contacts open by mu |J_t dq|; Coulomb, they stay closed (S.14).
      friction_scale: factor of every coefficient of friction, >= 0.
      contact_margin: added to the contact distance of the scene [m], >= 0.
      joint_limits: limits of the joints are constraints.
      effort_limits: the joints push with Model.effort at most (S.15); off, springs have no limit.
      tol_complementarity: worst |v lambda| of a contact [J s], in [1e-11, 1e-2].
      kappa, epsilon: deprecated, for smoothing=Analytic(kappa=...) and regularisation=FixedEpsilon(epsilon=...).

    Raises InvalidInput by the name of the argument.
    """

def calc_local_model(model: Model, q: numpy.typing.ArrayLike, u: numpy.typing.ArrayLike, *, scheme: Exact | Analytic | RandomizedFirstOrder | RandomizedZerothOrder | None = None, tau_ext: numpy.typing.ArrayLike | None = None, damping: numpy.typing.ArrayLike | None = None, with_A: bool | numpy.bool_ = False, threads: int = 1, h: float = 0.1, smoothing: Exact | Analytic = ..., regularisation: ByRule | FixedEpsilon = ..., friction_cone: SecondOrderCone | PolyhedralCone = ..., friction_law: FrictionLaw = FrictionLaw.Anitescu, friction_scale: float = 1.0, contact_margin: float = 0.0, joint_limits: bool | numpy.bool_ = True, effort_limits: bool | numpy.bool_ = False, tol_complementarity: float = 1e-10, kappa: float | None = None, epsilon: float | None = None) -> LocalModel:
    """
    Local model q_next(q + dq, u + du) ~ c + (A dq + B du) around q (n_q) and u (n_a) [m or rad], in tangent coordinates (2.4.1).

      scheme: Exact, Analytic, RandomizedFirstOrder or RandomizedZerothOrder; None: smoothing.
      tau_ext, damping: as in step() (n_v).
      with_A: LocalModel.A as well as B.
      threads: of randomised schemes; the result does not depend on it.

    status: Solved; that of the step that failed. Samples that fail are left out and counted.

        >>> task = st.load_task("planar_pushing")
        >>> local = st.calc_local_model(task.model, task.q_start, task.q_start[3:], scheme=st.Analytic(kappa=100), with_A=True)
        >>> local.A.shape, local.B.shape, local.failed
        ((5, 5), (5, 2), 0)

    Arguments of the step:
      h: time step [s], > 0.
      smoothing: Exact() (2.6), or Analytic(kappa=...) [1/J] (2.27).
      regularisation: of the objects: ByRule(ratio=...) (docs/theory/step.md), or FixedEpsilon(epsilon=...), 1 for their true mass.
      friction_cone: SecondOrderCone(), or PolyhedralCone(rays=...).
      friction_law: of exact steps: Anitescu, sliding contacts open by mu |J_t dq|; Coulomb, they stay closed (S.14).
      friction_scale: factor of every coefficient of friction, >= 0.
      contact_margin: added to the contact distance of the scene [m], >= 0.
      joint_limits: limits of the joints are constraints.
      effort_limits: the joints push with Model.effort at most (S.15); off, springs have no limit.
      tol_complementarity: worst |v lambda| of a contact [J s], in [1e-11, 1e-2].
      kappa, epsilon: deprecated, for smoothing=Analytic(kappa=...) and regularisation=FixedEpsilon(epsilon=...).

    Raises InvalidInput by the name of the argument.
    """

def rollout(model: Model, q: numpy.typing.ArrayLike, u_start: numpy.typing.ArrayLike, u_end: numpy.typing.ArrayLike, *, joint_angle: float = 0.03, joint_travel: float = 0.01, slide: float = 0.001, max_substeps: int = 400, workspace: StepWorkspace | None = None, h: float = 0.1, smoothing: Exact | Analytic = ..., regularisation: ByRule | FixedEpsilon = ..., friction_cone: SecondOrderCone | PolyhedralCone = ..., friction_law: FrictionLaw = FrictionLaw.Anitescu, friction_scale: float = 1.0, contact_margin: float = 0.0, joint_limits: bool | numpy.bool_ = True, effort_limits: bool | numpy.bool_ = False, tol_complementarity: float = 1e-10, kappa: float | None = None, epsilon: float | None = None) -> RolloutResult:
    """
    Moves the command from u_start to u_end (n_a) [m or rad] in exact sub-steps from q (n_q).

      joint_angle [rad], joint_travel [m]: no joint is commanded farther than this in a sub-step.
      slide: no contact slides farther than this in a sub-step, where max_substeps allows it [m].
      max_substeps: at most so many.
      workspace: scratch, of one thread at a time; None: one for this call.

    status: Solved; that of the sub-step that failed, and the knots before it.

        >>> task = st.load_task("planar_pushing")
        >>> path = st.rollout(task.model, task.q_start, [0.0, 0.0], [0.0, 0.1], joint_travel=0.01)
        >>> path.status, len(path.knots)
        (Status.Solved, 10)

    Arguments of the step:
      h: time step [s], > 0.
      smoothing: Exact() (2.6), or Analytic(kappa=...) [1/J] (2.27).
      regularisation: of the objects: ByRule(ratio=...) (docs/theory/step.md), or FixedEpsilon(epsilon=...), 1 for their true mass.
      friction_cone: SecondOrderCone(), or PolyhedralCone(rays=...).
      friction_law: of exact steps: Anitescu, sliding contacts open by mu |J_t dq|; Coulomb, they stay closed (S.14).
      friction_scale: factor of every coefficient of friction, >= 0.
      contact_margin: added to the contact distance of the scene [m], >= 0.
      joint_limits: limits of the joints are constraints.
      effort_limits: the joints push with Model.effort at most (S.15); off, springs have no limit.
      tol_complementarity: worst |v lambda| of a contact [J s], in [1e-11, 1e-2].
      kappa, epsilon: deprecated, for smoothing=Analytic(kappa=...) and regularisation=FixedEpsilon(epsilon=...).

    Raises InvalidInput by the name of the argument.
    """

class BatchWorkspace:
    """
    Threads and their scratch for many small batches; for one thread of the caller at a time.
    """

    def __init__(self, model: Model, threads: int = 0) -> None:
        """
        threads: 0 for all cores. Raises InvalidInput.

            >>> model = st.load_task("planar_pushing").model
            >>> work = st.BatchWorkspace(model, threads=1)
            >>> q = model.neutral()[None]
            >>> [st.step_batch(model, q, q[:, 3:], workspace=work).failed for _ in range(2)]
            [0, 0]
        """

    def __reduce__(self) -> tuple: ...

class StepBatch:
    """Steps from N pairs of configuration and command, the pair first."""

    @property
    def status(self) -> list[Status]:
        """(N)"""

    @property
    def solved(self) -> Annotated[NDArray[numpy.bool_], dict(shape=(None,), order='C')]:
        """(N); where it is False, q_next is q and A and B are 0"""

    @property
    def failed(self) -> int:
        """steps that are not Solved"""

    @property
    def q_next(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """(N, n_q)"""

    @property
    def torque(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """of the springs (N, n_a) [N m, N]"""

    @property
    def A(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None, None), writable=False)] | None:
        """D_qnext_q (N, n_v, n_v), None unless asked for; not to be written to"""

    @property
    def B(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None, None), writable=False)] | None:
        """D_qnext_u (N, n_v, n_a), None unless asked for; not to be written to"""

    @property
    def wall_s(self) -> float:
        """that the steps took in the library, without copies of arrays [s]"""

    def __len__(self) -> int: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def step_batch(model: Model, q: numpy.typing.ArrayLike, u: numpy.typing.ArrayLike, *, tau_ext: numpy.typing.ArrayLike | None = None, with_A: bool | numpy.bool_ = False, with_B: bool | numpy.bool_ = False, threads: int = 0, workspace: BatchWorkspace | None = None, h: float = 0.1, smoothing: Exact | Analytic = ..., regularisation: ByRule | FixedEpsilon = ..., friction_cone: SecondOrderCone | PolyhedralCone = ..., friction_law: FrictionLaw = FrictionLaw.Anitescu, friction_scale: float = 1.0, contact_margin: float = 0.0, joint_limits: bool | numpy.bool_ = True, effort_limits: bool | numpy.bool_ = False, tol_complementarity: float = 1e-10, kappa: float | None = None, epsilon: float | None = None) -> StepBatch:
    """
    step() from N pairs of configuration and command on all cores, with their local models where A or B is asked for (docs/theory/local_models.md).

      q: configurations (N, n_q).
      u: commands (N, n_a) [m or rad].
      tau_ext: external generalised forces besides gravity (N, n_v) [N, N m], or None.
      with_A, with_B: the derivatives StepBatch.A and .B.
      threads: 0 for all cores; the result does not depend on it, bit for bit: every step is solved cold.
      workspace: BatchWorkspace of the model, for many small batches; None: one for this call.

        >>> task = st.load_task("planar_pushing")
        >>> q = np.tile(task.q_start, (1000, 1))
        >>> batch = st.step_batch(task.model, q, q[:, 3:] + np.linspace(0, 0.2, 1000)[:, None], smoothing=st.Analytic(kappa=100), with_B=True)
        >>> batch.q_next.shape, batch.B.shape, batch.failed
        ((1000, 5), (1000, 5, 2), 0)

    Arguments of the step:
      h: time step [s], > 0.
      smoothing: Exact() (2.6), or Analytic(kappa=...) [1/J] (2.27).
      regularisation: of the objects: ByRule(ratio=...) (docs/theory/step.md), or FixedEpsilon(epsilon=...), 1 for their true mass.
      friction_cone: SecondOrderCone(), or PolyhedralCone(rays=...).
      friction_law: of exact steps: Anitescu, sliding contacts open by mu |J_t dq|; Coulomb, they stay closed (S.14).
      friction_scale: factor of every coefficient of friction, >= 0.
      contact_margin: added to the contact distance of the scene [m], >= 0.
      joint_limits: limits of the joints are constraints.
      effort_limits: the joints push with Model.effort at most (S.15); off, springs have no limit.
      tol_complementarity: worst |v lambda| of a contact [J s], in [1e-11, 1e-2].
      kappa, epsilon: deprecated, for smoothing=Analytic(kappa=...) and regularisation=FixedEpsilon(epsilon=...).

    Raises InvalidInput by the name of the argument.
    """

def calc_weights_aside(model: Model, q: numpy.typing.ArrayLike, angle: float, draw: int) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
    """
    What objects that move freely feel besides gravity when it comes from `angle` aside, at many configurations: tau_ext of step_batch().

      q: (N, n_q). angle: [rad], in [0, pi/2). draw: the side, in [0, 3]; each is a quarter turn from the one before.

    Returns (N, n_v) [N, N m]; 0 without gravity and for objects on joints, which something carries.

        >>> task = st.load_task("allegro_ball")
        >>> st.calc_weights_aside(task.model, task.q_start[None], 0.1, 0)[0, :3].round(4)
        array([0.    , 0.0502, 0.    ])
    """

class RolloutBatch:
    """N trajectories of T steps each."""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None, None), writable=False)]:
        """(N, T + 1, n_q), the start first; not to be written to"""

    @property
    def status(self) -> list[Status]:
        """(N); that of the first step that is not Solved"""

    @property
    def steps(self) -> list[int]:
        """(N) that were solved; a trajectory stays where a step failed"""

    @property
    def failed(self) -> int:
        """trajectories that are not Solved"""

    @property
    def wall_s(self) -> float:
        """that the steps took in the library, without copies of arrays [s]"""

    def __len__(self) -> int: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def rollout_batch(model: Model, q_start: numpy.typing.ArrayLike, u: numpy.typing.ArrayLike, *, threads: int = 0, workspace: BatchWorkspace | None = None, h: float = 0.1, smoothing: Exact | Analytic = ..., regularisation: ByRule | FixedEpsilon = ..., friction_cone: SecondOrderCone | PolyhedralCone = ..., friction_law: FrictionLaw = FrictionLaw.Anitescu, friction_scale: float = 1.0, contact_margin: float = 0.0, joint_limits: bool | numpy.bool_ = True, effort_limits: bool | numpy.bool_ = False, tol_complementarity: float = 1e-10, kappa: float | None = None, epsilon: float | None = None) -> RolloutBatch:
    """
    N trajectories q[t + 1] = step(q[t], u[t]) on all cores.

      q_start: (N, n_q).
      u: commands (N, T, n_a) [m or rad].
      threads: 0 for all cores; the result does not depend on it, bit for bit: every step is solved cold.
      workspace: BatchWorkspace of the model, for many small batches; None: one for this call.

        >>> task = st.load_task("planar_pushing")
        >>> q = np.tile(task.q_start, (100, 1))
        >>> u = q[:, None, 3:] + np.linspace(0, 0.2, 8)[None, :, None]
        >>> rolled = st.rollout_batch(task.model, q, u)
        >>> rolled.q.shape, rolled.failed
        ((100, 9, 5), 0)

    Arguments of the step:
      h: time step [s], > 0.
      smoothing: Exact() (2.6), or Analytic(kappa=...) [1/J] (2.27).
      regularisation: of the objects: ByRule(ratio=...) (docs/theory/step.md), or FixedEpsilon(epsilon=...), 1 for their true mass.
      friction_cone: SecondOrderCone(), or PolyhedralCone(rays=...).
      friction_law: of exact steps: Anitescu, sliding contacts open by mu |J_t dq|; Coulomb, they stay closed (S.14).
      friction_scale: factor of every coefficient of friction, >= 0.
      contact_margin: added to the contact distance of the scene [m], >= 0.
      joint_limits: limits of the joints are constraints.
      effort_limits: the joints push with Model.effort at most (S.15); off, springs have no limit.
      tol_complementarity: worst |v lambda| of a contact [J s], in [1e-11, 1e-2].
      kappa, epsilon: deprecated, for smoothing=Analytic(kappa=...) and regularisation=FixedEpsilon(epsilon=...).

    Raises InvalidInput by the name of the argument.
    """

def pull_back_rollout(model: Model, rolled: RolloutBatch, u: numpy.typing.ArrayLike, D_L_q: numpy.typing.ArrayLike, *, threads: int = 0, workspace: BatchWorkspace | None = None, h: float = 0.1, smoothing: Exact | Analytic = ..., regularisation: ByRule | FixedEpsilon = ..., friction_cone: SecondOrderCone | PolyhedralCone = ..., friction_law: FrictionLaw = FrictionLaw.Anitescu, friction_scale: float = 1.0, contact_margin: float = 0.0, joint_limits: bool | numpy.bool_ = True, effort_limits: bool | numpy.bool_ = False, tol_complementarity: float = 1e-10, kappa: float | None = None, epsilon: float | None = None) -> tuple[Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')], Annotated[NDArray[numpy.float64], dict(shape=(None, None, None), writable=False)]]:
    """
    Derivatives of a scalar L of the trajectories of rollout_batch() by starts and commands, from those by the configurations: the adjoint of the steps (S.25).

      rolled: of rollout_batch(), for the same u.
      D_L_q: dL/dq (N, T + 1, n_q).
      Arguments of the step: those of the rollout, or smoother ones; an exact step has the derivative 0 where nothing touches.

    Returns dL/dq_start (N, n_q) and dL/du (N, T, n_a). The derivative by a quaternion is the one along the sphere of unit quaternions.

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
      regularisation: of the objects: ByRule(ratio=...) (docs/theory/step.md), or FixedEpsilon(epsilon=...), 1 for their true mass.
      friction_cone: SecondOrderCone(), or PolyhedralCone(rays=...).
      friction_law: of exact steps: Anitescu, sliding contacts open by mu |J_t dq|; Coulomb, they stay closed (S.14).
      friction_scale: factor of every coefficient of friction, >= 0.
      contact_margin: added to the contact distance of the scene [m], >= 0.
      joint_limits: limits of the joints are constraints.
      effort_limits: the joints push with Model.effort at most (S.15); off, springs have no limit.
      tol_complementarity: worst |v lambda| of a contact [J s], in [1e-11, 1e-2].
      kappa, epsilon: deprecated, for smoothing=Analytic(kappa=...) and regularisation=FixedEpsilon(epsilon=...).

    Raises InvalidInput by the name of the argument.
    """

class PairForce:
    """Force of one pair, its contact points together."""

    @property
    def pair(self) -> int:
        """index into Model.pairs"""

    @property
    def normal(self) -> float:
        """[N]"""

    @property
    def tangential(self) -> float:
        """[N]"""

    @property
    def force_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """on A [N]"""

    @property
    def friction_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """[N]"""

    @property
    def p_WC(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """mean of the points, weighted by their normal forces [m]"""

    @property
    def depth(self) -> float:
        """deepest penetration [m]"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class SimulationResult:
    """Samples of a second-order simulation."""

    @property
    def status(self) -> Status: ...

    @property
    def message(self) -> str: ...

    @property
    def times(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """[s] (samples)"""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """(samples, n_q)"""

    @property
    def v(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """(samples, n_v) [m/s, rad/s]"""

    @property
    def torque(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """
        (samples, n_a) of each motor the largest since the sample before [N m or N]
        """

    @property
    def forces(self) -> list[list[PairForce]]:
        """per sample, by pair index; only pairs that touch"""

    @property
    def max_depth(self) -> float:
        """[m]"""

    @property
    def steps(self) -> int: ...

    @property
    def wall_s(self) -> float: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Plant:
    """
    A model as MuJoCo simulates it; docs/theory/simulation.md says what follows from each argument.

      timestep: [s], > 0.
      damping_ratio: of a joint spring with the inertia that its joint moves, >= 0.
      armature: inertia of every motor as its joint sees it [kg or kg m^2], >= 0; raised where a spring would turn faster than
        spring_resolution [rad] in a timestep.
      time_constant: of contacts in the normal direction [s]; friction_time_constant: in which slip dies out [s].
      impedance: in (0, 0.9999]; 1 would be rigid. friction_stiffening: of friction against the normal direction, >= 1.
      noslip_iterations: sweeps that remove the rest of the creep.
      friction_scale: factor of every coefficient of friction, >= 0.
      ground_softness: factor of both time constants for objects on fixed geometry, >= 1.
      velocity_reference: damping acts on the difference of commanded and real velocity; else on the real one.
      effort_limits: motors give Model.effort at most.
      joint_friction: robot joints have the friction and damping of their files; objects always have theirs.

    Raises InvalidInput by the name of the argument.
    """

    def __init__(self, model: Model, *, timestep: float = 0.0002, damping_ratio: float = 1.0, armature: float = 0.0, spring_resolution: float = 1.0, time_constant: float = 0.002, friction_time_constant: float = 0.02, impedance: float = 0.95, friction_stiffening: float = 100.0, noslip_iterations: int = 0, friction_scale: float = 1.0, ground_softness: float = 2.5, velocity_reference: bool | numpy.bool_ = False, effort_limits: bool | numpy.bool_ = False, joint_friction: bool | numpy.bool_ = False) -> None: ...

    @property
    def timestep(self) -> float:
        """[s]"""

    @property
    def damping(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """of the joint springs (n_a) [N s/m or N m s/rad]"""

    @property
    def armature(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """(n_a) [kg or kg m^2]"""

    def __reduce__(self) -> tuple: ...

def simulate(plant: Plant, q0: numpy.typing.ArrayLike, times: numpy.typing.ArrayLike, u: numpy.typing.ArrayLike, *, v0: numpy.typing.ArrayLike | None = None, record_interval: float = 0.01, timeout_s: float | None = None) -> SimulationResult:
    """
    Second-order simulation, from q0 to the last knot.

      q0: configuration (n_q).
      times: of the knots, increasing from 0 (knots) [s].
      u: commanded joint positions, linear between knots (knots, n_a) [m or rad].
      v0: velocity in tangent coordinates (n_v) [m/s, rad/s]; None: at rest.
      record_interval: of the samples [s], > 0.
      timeout_s: [s] > 0; None: as long as it takes.

    status: Solved; MaxIterations (time used up); NumericalFailure (`message`). Raises InvalidInput.

        >>> task = st.load_task("planar_pushing")
        >>> run = st.simulate(st.Plant(task.model), task.q_start, [0.0, 0.5], [[0, 0], [0, 0.1]], record_interval=0.05)
        >>> run.status, run.q.shape
        (Status.Solved, (11, 5))
    """

class DrivenPlant:
    """
    A plant that is driven tick by tick: joint commands go to an impedance controller, its torques to the joints (C.7). Belongs to
    one thread at a time.

      plant: Plant(model, damping_ratio=0): the damping is the controller's.
      damping_ratio: with the inertia that a joint moves at the moment, >= 0.
      velocity_cutoff, gain_cutoff: of the low-passes on joint velocities and on the damping [Hz], > 0.
      period: between two torques, in whole timesteps of the plant [s], > 0.

    Raises InvalidInput by the name of the argument.

        >>> task = st.load_task("planar_pushing")
        >>> plant = st.DrivenPlant(st.Plant(task.model, damping_ratio=0))
        >>> plant.reset(task.q_start)
        >>> plant.advance([0.0, 0.02], 0.1), round(plant.time, 3)
        (Status.Solved, 0.1)
    """

    def __init__(self, plant: Plant, *, damping_ratio: float = 1.0, velocity_cutoff: float = 400.0, gain_cutoff: float = 1.0, period: float = 0.0002) -> None: ...

    def reset(self, q: numpy.typing.ArrayLike) -> None:
        """At rest in q (n_q) at time 0, without a push."""

    def set_push(self, body: str, p_BP: numpy.typing.ArrayLike, force_W: numpy.typing.ArrayLike) -> None:
        """
        A constant force [N] (3) on a point fixed in a body [m] (3), from now on; zero ends it.
        """

    def advance(self, command: numpy.typing.ArrayLike, duration: float) -> Status:
        """
        Holds the command (n_a) [rad or m] for a time [s], > 0, rounded to periods of the impedance controller, at least one.

        Returns Solved, or NumericalFailure: `message` says what; only reset() goes on from there.
        """

    @property
    def time(self) -> float:
        """[s]"""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """(n_q)"""

    @property
    def v(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """(n_v) [m/s, rad/s]"""

    @property
    def torque(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """of the joints (n_a) [N m or N]"""

    @property
    def external(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        torques of contacts, joint stops and the push, what Sensor.sense takes (n_a) [N m or N]
        """

    @property
    def damping(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """of the impedance controller (n_a) [N m s/rad or N s/m]"""

    @property
    def forces(self) -> list[PairForce]:
        """by pair index; only pairs that touch"""

    @property
    def message(self) -> str: ...

    def __reduce__(self) -> tuple: ...

class PlannerOptions:
    """
    Options of the planner. Each has the name and the value that it has in the section `planner` of a task file (tasks/schema/task.schema.json); dir() lists them.
    """

    def __init__(self, model: Model, **values: object) -> None:
        """
        Defaults, and what differs from them. Raises InvalidInput: unknown names, values that cannot be.
        """

    def replace(self, **changes: object) -> PlannerOptions:
        """
        These options with others; each one is replaced as a whole, None stands for its default. Raises InvalidInput.

            >>> options = st.load_task("planar_pushing").options
            >>> options.replace(goal_bias=0.25).goal_bias
            0.25
        """

    def to_dict(self) -> dict[str, object]:
        """every option by its name"""

    def __getattr__(self, name: str, /) -> Any: ...

    def __dir__(self) -> list[str]: ...

    def __eq__(self, other: object, /) -> bool: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def planner_schema() -> dict[str, object]:
    """
    JSON schema of the section `planner` of a task file: every option with what it is, its unit and its range.

        >>> "goal_bias" in st.planner_schema()["properties"]
        True
    """

class Goal:
    """Where an object is to be, and how near is near enough."""

    @property
    def object(self) -> int:
        """index of the object"""

    @property
    def X_WG(self) -> Pose: ...

    @property
    def open(self) -> list[bool]:
        """
        of the objects' coordinates, in the order of their velocities (n_vu), which may have any value; empty: none
        """

    @property
    def tol_position(self) -> float:
        """[m]"""

    @property
    def tol_angle(self) -> float:
        """[rad]"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class GoalError:
    """How far an object is from its goal."""

    @property
    def position(self) -> float:
        """[m]"""

    @property
    def angle(self) -> float:
        """[rad]"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Task:
    """A scene, a start, a goal and how to plan."""

    def __init__(self, task: dict, *, base: str | os.PathLike | None = None) -> None:
        """
        A task made in memory: a dict with the keys of a task file (tasks/schema/task.schema.json). Arrays, poses, paths and robots as text may stand in it. base: the folder that paths in it are relative to; None: the working folder. Raises InvalidInput: "field: got …, expected …".

            >>> folder = st.load_task("planar_pushing").file.parent
            >>> task = st.Task({"base": "planar_pushing.yaml", "name": "wide", "tolerance": {"position": 0.05, "angle": 0.2}}, base=folder)
            >>> task.name, task.goal.tol_position
            ('wide', 0.05)
        """

    @property
    def name(self) -> str: ...

    @property
    def description(self) -> str: ...

    @property
    def file(self) -> pathlib.Path:
        """of a task made in memory the folder that its paths are relative to"""

    @property
    def text(self) -> str:
        """of a task made in memory, as in a file; else empty"""

    @property
    def model(self) -> Model: ...

    @property
    def q_start(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """(n_q)"""

    @property
    def q_goal(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        of the objects at the goal; of a goal region what is nearest to the start (n_qu)
        """

    @property
    def goal(self) -> Goal: ...

    @property
    def goal_objects(self) -> list[int]:
        """
        indices of the objects that the goal names, ascending; without those that another of them hangs on
        """

    @property
    def options(self) -> PlannerOptions:
        """of its section `planner`"""

    @property
    def scene_sha256(self) -> str: ...

    def with_(self, *, start: numpy.typing.ArrayLike | None = None, goal: numpy.typing.ArrayLike | None = None, options: PlannerOptions | dict | None = None) -> Task:
        """
        The task with another start (n_q), goal (as in set_goal) or options (PlannerOptions, or a dict of those that differ); this one stays as it is. Raises InvalidInput.

            >>> task = st.load_task("planar_pushing")
            >>> other = task.with_(goal=[0.6, 0.1, 0.0], options={"goal_bias": 0.3})
            >>> other.q_goal, other.options.goal_bias
            (array([0.6, 0.1, 0. ]), 0.3)
        """

    def goal_errors(self, q: numpy.typing.ArrayLike) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """
        How far the object is from the goal, or from the nearest pose of the goal region, at many configurations (N, n_q): position [m] and angle [rad], (N, 2).
        """

    def as_plan(self) -> Plan:
        """
        A plan that stays at the start, to be shown, exported or compared: MaxIterations, unless the start is at the goal.
        """

    def follow(self, u: numpy.typing.ArrayLike, *, u_start: numpy.typing.ArrayLike | None = None) -> Plan:
        """
        The motion that commands (N, n_a) [m or rad] make from the start, with the dynamics of the planner, as a plan of one push. Solved where it ends at the goal, MaxIterations where not; else the status of the step that has no solution, where the plan ends. Raises InvalidInput.

            >>> task = st.load_task("planar_pushing")
            >>> plan = task.follow([[0.0, 0.0], [0.0, 0.1]])
            >>> plan.status, plan.u[-1]
            (Status.MaxIterations, array([0. , 0.1]))
        """

    def set_goal(self, values: Sequence[float | None] | numpy.typing.ArrayLike) -> None:
        """
        x y z [m] roll pitch yaw [rad] of a free object, the coordinates of any other; of several objects one after the other. None: any value. Raises InvalidInput.
        """

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def list_tasks() -> list[str]:
    """
    Names of the built-in tasks.

        >>> "allegro_cube" in st.list_tasks()
        True
    """

def _import_scene(file: str | os.PathLike, *, out: str | os.PathLike | None = None, object: str = '') -> Task:
    """Of scenes.py: an MJCF or URDF file."""

def _parse_task(text: str, base: str | os.PathLike | None = None) -> Task:
    """Of scenes.py: the text of a task file."""

def list_keyframes(file: str | os.PathLike) -> list[str]:
    """
    Names of the keyframes of an MJCF file, as a start of a task takes them. Raises InvalidInput.

        >>> with open("keyed.xml", "w") as file:
        ...     _ = file.write("<mujoco><worldbody><body><joint name='j' type='slide'/><geom size='.1'/></body></worldbody>"
        ...                    "<keyframe><key name='home' qpos='.5'/></keyframe></mujoco>")
        >>> st.list_keyframes("keyed.xml")
        ['home']
    """

def load_task(name_or_file: str | str | os.PathLike) -> Task:
    """
    A built-in task by its name, or a file: a str that ends in .yaml or .yml or has a '/', or any os.PathLike. Raises InvalidInput: "FILE:LINE: field: got …, expected …".

        >>> task = st.load_task("allegro_cube")
        >>> task.model.n_a, task.model.object_names
        (16, ['cube'])
    """

class SegmentKind(enum.Enum):
    """What a piece of a plan does."""

    Settle = 0
    """from the given start to rest on the constraints (first segment only)"""

    Contact = 1
    """the robot pushes"""

    Regrasp = 2
    """the robot moves to new contacts while the object rests"""

class Progress:
    """What on_progress is told."""

    @property
    def iteration(self) -> int: ...

    @property
    def fraction(self) -> float:
        """of the budget used, in [0, 1]"""

    @property
    def best(self) -> float:
        """distance to the goal so far; smaller is better"""

    @property
    def size(self) -> int: ...

    @property
    def elapsed_s(self) -> float: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Growth:
    """Nodes that a tree gained since it was last told of."""

    @property
    def tree(self) -> int:
        """
        of the run, from 0: trees grow side by side, and one that stalls makes room for the next
        """

    @property
    def first(self) -> int:
        """number of the first of these nodes in their tree"""

    @property
    def parents(self) -> list[int]:
        """numbers of nodes in the tree, -1 of the root (nodes)"""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """(nodes, n_q) [m, rad]"""

    @property
    def u(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """commands at q (nodes, n_a) [m or rad]"""

    @property
    def best(self) -> int:
        """node of the tree that is nearest the goal"""

    @property
    def best_ratio(self) -> float:
        """how far that one is, in tolerances"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class TreeNode:
    """A node of the search tree."""

    @property
    def parent(self) -> int:
        """-1 of the root"""

    @property
    def edge(self) -> SegmentKind:
        """that leads to it"""

    @property
    def iteration(self) -> int:
        """extensions up to the end of its round"""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """(n_q)"""

    @property
    def c_u(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """smoothed next configuration of the objects"""

    @property
    def B_u(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')]:
        """their rows of B"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class RefusedMoves:
    """
    Moves to new contacts from one node of a tree, of which some were refused.
    """

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """of the node (n_q)"""

    @property
    def counts(self) -> dict[str, int]:
        """as in PlanResult.regrasps"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class PlanContact:
    """
    An active contact of a knot of a plan; rounded to 1e-6 where the plan was read from a file.
    """

    @property
    def a(self) -> str:
        """name of the geometry, as body/geometry"""

    @property
    def b(self) -> str: ...

    @property
    def point(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """in W, on the surface of b before the sub-step [m] (3)"""

    @property
    def normal(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """unit, from b to a (3)"""

    @property
    def force(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """in W, on a; its opposite acts on b [N] (3)"""

    @property
    def friction(self) -> float:
        """coefficient of the pair"""

    @property
    def gap(self) -> float:
        """signed distance before the sub-step [m]"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Trajectory:
    """
    Commands over time, linear between knots, and the configurations that the plan predicts.
    """

    @property
    def times(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """of the knots, the first one 0 [s] (knots)"""

    @property
    def u(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """(knots, n_a) [m or rad]"""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """(knots, n_q)"""

    @property
    def segments(self) -> Annotated[NDArray[numpy.int32], dict(shape=(None,), order='C')]:
        """of the plan, that led to the knot (knots)"""

    @property
    def knots(self) -> Annotated[NDArray[numpy.int32], dict(shape=(None,), order='C')]:
        """
        rows of Plan.q: the knot of the plan whose sub-step ends here or is under way (knots)
        """

    @property
    def speed(self) -> float:
        """times the full timing of make_trajectory()"""

    @property
    def duration(self) -> float:
        """[s]"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

OPEN_LOOP_SPEED: float = 0.1

def make_trajectory(plan: Plan, *, speed: float = 0.1, pause: float = 0.0) -> Trajectory:
    """
    Times of the commands of a plan, at the speeds that follow from the object of its goal and from the motors (E.8), (E.13), and ahead of it by what the damping of objects on joints takes (E.17).

    speed: times that full timing, > 0; above 1 only pushes are faster. Without feedback most plans hold at the default of 0.1, and few at 1. No command is faster than the `velocity` of the URDF, at any speed. pause: commands rest this long between pieces [s], >= 0. Raises InvalidInput.

        >>> plan = st.plan(st.load_task("planar_pushing"), seed=0).plan
        >>> trajectory = st.make_trajectory(plan, speed=0.5)
        >>> trajectory.u.shape == (len(trajectory.times), 2), float(trajectory.times[0]), trajectory.speed
        (True, 0.0, 0.5)
    """

class Segment:
    """A piece of a plan: knots one sub-step apart."""

    @property
    def kind(self) -> SegmentKind: ...

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """(knots, n_q)"""

    @property
    def u(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """(knots, n_a)"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Plan:
    """
    Commands and predicted configurations from the start to (near) the goal, with the task. Can be pickled; a sequence of segments.

        >>> plan = st.plan(st.load_task("planar_pushing"), seed=0).plan
        >>> plan.q.shape == (len(plan.u), 5), len(plan) == len(plan.segments)
        (True, True)
        >>> first = plan[:1]
        >>> first.q.shape == (1 + len(plan[0].q), 5)
        True
    """

    @property
    def task(self) -> Task: ...

    @property
    def options(self) -> PlannerOptions:
        """that it was made with"""

    @property
    def status(self) -> Status:
        """Solved: it reaches the goal"""

    @property
    def seed(self) -> int: ...

    @property
    def error(self) -> GoalError:
        """of the object at the last knot"""

    @property
    def h(self) -> float:
        """time step of a knot [s]"""

    @property
    def segments(self) -> list[Segment]: ...

    def __len__(self) -> int: ...

    def __iter__(self) -> Iterator[Segment]: ...

    @overload
    def __getitem__(self, index: int) -> Segment:
        """One of the segments. Raises IndexError."""

    @overload
    def __getitem__(self, segments: slice) -> Plan:
        """
        Neighbouring segments as a plan, which starts where the one before them ends. Solved where it ends at the goal. Raises InvalidInput: no segment
        """

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """configurations, the start first (knots + 1, n_q)"""

    @property
    def u(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """commands (knots + 1, n_a) [m or rad]"""

    def write(self, file: str | os.PathLike) -> None:
        """
        Writes the plan file that the program reads (docs/plan_file.md). Raises InvalidInput.
        """

    @property
    def contacts(self) -> list[list[PlanContact]]:
        """
        active in the sub-step that led to each row of q; none at the start (knots + 1)
        """

    def export(self, file: str | os.PathLike, *, format: str | None = None, trajectory: Trajectory | None = None) -> list[pathlib.Path]:
        """
        Writes the motion over time for other programs (docs/exports.md): joints, commands, velocities, torques, poses of objects, contacts.

        format: csv, npz, json, mcap or lerobot (a folder); None: what the name of the file ends in. trajectory: of make_trajectory(); None: at its default speed. Returns the files. Raises InvalidInput; MissingExtra: mcap needs `pip install stiction[mcap]`.

            >>> plan = st.plan(st.load_task("planar_pushing"), seed=0).plan
            >>> [file.name for file in plan.export("motion.csv")]
            ['motion.csv', 'motion.contacts.csv']
            >>> with np.load(plan.export("motion.npz")[0]) as motion:
            ...     motion["q"].shape == (len(motion["time"]), 2)
            True
        """

    def to_text(self, folder: str | os.PathLike | None = None) -> str:
        """
        The text of the file as it would stand in the folder; None: the working folder.
        """

    def __getstate__(self) -> tuple[str, str]: ...

    def __setstate__(self, arg: tuple[str, str], /) -> None: ...

    def __repr__(self) -> str: ...

def read_plan(file: str | os.PathLike) -> Plan:
    """
    A plan from its file, or the folder of a plan.json, with the task it was made for. Raises InvalidInput: "FILE: field: got …, expected …", also where the scene of the task is another one by now.

        >>> plan = st.plan(st.load_task("planar_pushing"), seed=0).plan
        >>> plan.write("plan.json")
        >>> bool((st.read_plan("plan.json").q == plan.q).all())
        True
    """

def parse_plan(text: str, folder: str | os.PathLike | None = None) -> Plan:
    """
    A plan from the text of its file. folder: in which the text stands, None: the working folder. Raises InvalidInput.

        >>> plan = st.plan(st.load_task("planar_pushing"), seed=0).plan
        >>> st.parse_plan(plan.to_text()).seed
        0
    """

class RefineResult:
    """What came of a refinement."""

    @property
    def status(self) -> Status: ...

    @property
    def plan(self) -> Plan:
        """the refined plan, or the given one"""

    @property
    def variant(self) -> str:
        """shortened, reconnected or unchanged"""

    @property
    def pushes(self) -> tuple[int, int]:
        """before and after"""

    @property
    def regrasps(self) -> tuple[int, int]:
        """before and after"""

    @property
    def least_clearance(self) -> float:
        """of the regrasps that were planned anew [m]; 0 without any"""

    @property
    def rest_planned_anew(self) -> int:
        """searches for what small steps left of the plan"""

    @property
    def steps(self) -> int: ...

    @property
    def failed_steps(self) -> int: ...

    @property
    def wall_s(self) -> float: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def refine(plan: Plan, *, options: PlannerOptions | dict | None = None, threads: int | None = None, timeout_s: float = 20.0, on_progress: Callable[[Progress], bool | None] | None = None) -> RefineResult:
    """
    Makes a plan shorter and its regrasps wider (docs/theory/refinement.md).

    plan: one that is Solved. options: PlannerOptions, or a dict of those that differ; None: those that the plan was made with. threads: 0 for all cores; the result does not depend on them. timeout_s: [s] > 0.

    status: Solved; MaxIterations (time used up) and Cancelled: refined at its own steps, or the given plan; NumericalFailure: the given plan does not reach its goal. Raises InvalidInput.

        >>> plan = st.plan(st.load_task("planar_pushing"), seed=0).plan
        >>> refined = st.refine(plan)
        >>> refined.status, st.check_plan(refined.plan).pass_
        (Status.Solved, True)
    """

class CheckItem:
    """One figure of a check."""

    @property
    def name(self) -> str: ...

    @property
    def value(self) -> float:
        """in `unit`"""

    @property
    def limit(self) -> float | None:
        """the largest good value; None: reported, not judged"""

    @property
    def unit(self) -> str: ...

    @property
    def pass_(self) -> bool: ...

    @property
    def where(self) -> str:
        """what and where the worst was"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class CheckReport:
    """What came of a check."""

    @property
    def pass_(self) -> bool:
        """the verdict"""

    @property
    def status(self) -> Status:
        """Solved: all checks were made"""

    @property
    def items(self) -> list[CheckItem]: ...

    def at(self, name: str) -> CheckItem:
        """one item by its name. Raises InvalidInput: no such item"""

    @property
    def knots(self) -> int: ...

    @property
    def steps(self) -> int: ...

    @property
    def threshold_N(self) -> float:
        """contacts with less force than this are not looked at [N]"""

    @property
    def wall_s(self) -> float: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def check_plan(plan: Plan) -> CheckReport:
    """
    Simulates a plan anew with the exact dynamics at half the sub-step, and compares every number in it with what comes out and with its task. The check shares nothing with the planner.

        >>> report = st.check_plan(st.plan(st.load_task("planar_pushing"), seed=0).plan)
        >>> report.pass_, report.at("goal_position").unit
        (True, 'm')
    """

class PlanResult:
    """What came of a search."""

    @property
    def plan(self) -> Plan:
        """the best path found, also where it is not Solved"""

    @property
    def status(self) -> Status: ...

    @property
    def reason(self) -> str:
        """
        why not Solved, where there is more to say than that the budget was used up
        """

    @property
    def options(self) -> PlannerOptions:
        """that the plan was made with"""

    @property
    def seed(self) -> int: ...

    @property
    def cost(self) -> float:
        """of the plan: time of its commands and a price for each regrasp [s]"""

    @property
    def start_penetration(self) -> float:
        """deepest of the given start [m], >= 0"""

    @property
    def iterations(self) -> int:
        """extensions of the tree"""

    @property
    def linearisations(self) -> int: ...

    @property
    def nodes(self) -> int: ...

    @property
    def steps(self) -> int: ...

    @property
    def failed_steps(self) -> int: ...

    @property
    def profile(self) -> dict[str, tuple[float, int]]:
        """
        activity -> (processor time [s], calls); all 0 with the options `thesis`
        """

    @property
    def regrasps(self) -> dict[str, int]:
        """
        how many moves to new contacts were tried and accepted, and what refused the others
        """

    @property
    def refused(self) -> list[RefusedMoves]:
        """
        where moves to new contacts were refused until there was a plan, by nodes of the trees; none with the option `thesis`
        """

    @property
    def wall_s(self) -> float: ...

    @property
    def tree(self) -> list[TreeNode]:
        """its nodes, the root first, of a search with the option `thesis`"""

    @property
    def tree_errors(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """distances of the nodes in `tree` from the goal [m], [rad] (nodes, 2)"""

    def packing_ratio(self, threshold: float = 3.0, samples: int = 1000, seed: int = 0) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        (3.9) after each node in `tree`, by the boxes and γ of the task (nodes)
        """

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def plan(task: Task, *, q_start: numpy.typing.ArrayLike | None = None, u_start: numpy.typing.ArrayLike | None = None, options: PlannerOptions | dict | None = None, seed: int | None = None, threads: int | None = None, timeout_s: float = 20.0, on_progress: Callable[[Progress], bool | None] | None = None, on_growth: Callable[[Growth], None] | None = None) -> PlanResult:
    """
    Plans a path of the object to the goal (Algorithms 2 and 3).

    q_start, u_start: where things are and what the joints are commanded to, as they were measured (n_q), (n_a): springs keep their strain, overlaps are moved apart; None: the start of the task, joints commanded where they are. options: PlannerOptions, or a dict of those that differ from the task's; None: the task's. seed, threads (0: all cores): None: those of the options; the plan does not depend on threads. timeout_s: [s] > 0. on_progress: called with Progress; Ctrl-C and an error in it stop the search, so does False, which keeps the best path so far (Cancelled). on_growth: called with Growth, the nodes that a tree gained; the plan is the same with it.

    status: Solved; MaxIterations (time or budget used up, or `reason`); Cancelled; NumericalFailure (the objects do not come to rest at the start). Raises InvalidInput.

        >>> task = st.load_task("planar_pushing")
        >>> result = st.plan(task, seed=0)
        >>> result.status, st.check_plan(result.plan).pass_
        (Status.Solved, True)
        >>> st.plan(task, seed=0, on_progress=lambda progress: False).status
        Status.Cancelled
    """

class CostTerms:
    """Parts of the cost (T.1) of a trajectory."""

    @property
    def objects(self) -> float:
        """tracking of the objects before the end"""

    @property
    def objects_final(self) -> float:
        """and at the end"""

    @property
    def robots(self) -> float: ...

    @property
    def robots_final(self) -> float: ...

    @property
    def input(self) -> float:
        """changes of the command"""

    @property
    def total(self) -> float: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class IterationLog:
    """What an iteration came to."""

    @property
    def cost(self) -> CostTerms:
        """of the trajectory after this iteration"""

    @property
    def best(self) -> float:
        """lowest total so far"""

    @property
    def length(self) -> float:
        """of the accepted step; 0: none was"""

    @property
    def sharpness(self) -> float:
        """kappa [1/J], or the standard deviation of u"""

    @property
    def qp_iterations(self) -> int: ...

    @property
    def failed_models(self) -> int: ...

    @property
    def elapsed_s(self) -> float: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class OptimizeResult:
    """The best trajectory of an optimisation."""

    @property
    def status(self) -> Status: ...

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """configurations of the best trajectory (T + 1, n_q)"""

    @property
    def u(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """commands (T, n_a)"""

    @property
    def cost(self) -> CostTerms: ...

    @property
    def history(self) -> list[IterationLog]:
        """the guess first"""

    @property
    def steps(self) -> int: ...

    @property
    def linearisations(self) -> int: ...

    @property
    def wall_s(self) -> float: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def optimize(task: Task, *, scheme: str | None = None, solver: str | None = None, iterations: int | None = None, forces: bool | numpy.bool_ = False, seed: int | None = None, timeout_s: float = 60.0, threads: int = 0, on_progress: Callable[[Progress], bool | None] | None = None, section: dict | None = None, reference: numpy.typing.ArrayLike | None = None, u_guess: numpy.typing.ArrayLike | None = None, u_before: numpy.typing.ArrayLike | None = None) -> OptimizeResult:
    """
    Optimises a trajectory by the section `optimize` of the task (iMPC, Alg. 1).

      scheme: exact, analytic, randomized-first or randomized-zeroth; solver: sweep or receding; iterations: at most; None: as the task says.
      forces: with the contact trust region.
      seed: of the randomised schemes.
      timeout_s: [s] > 0.
      threads: 0 for all cores; the result does not depend on it.
      on_progress: called with Progress; Ctrl-C and an error in it stop the run.
      section: in place of the section `optimize` of the task, a dict with its keys.
      reference: configurations to follow, the start first (T + 1, n_q), with the dynamics of the planner; None: the goal all the time. u_guess: commands to begin with (T, n_a); None:
        those of the start all the time. u_before: the command before the first one (n_a); None: the joints of the start.

    status: Solved; MaxIterations (time used up) and Cancelled: the best trajectory so far. Raises InvalidInput.

        >>> result = st.optimize(st.load_task("impc_planar_pushing"), iterations=2)
        >>> result.status, len(result.q) == len(result.u) + 1
        (Status.Solved, True)
    """

class Finding:
    """Something in a task that is hardly what was meant."""

    @property
    def kind(self) -> str: ...

    @property
    def message(self) -> str:
        """field or body, what was found, what was likely meant"""

    @property
    def where(self) -> str:
        """start or goal, where it is a matter of one of them; else empty"""

    @property
    def names(self) -> list[str]:
        """geometries (body/geometry) or the object that it is about"""

    @property
    def p_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')] | None:
        """of an overlap or a gap, halfway between the nearest points [m] (3)"""

    @property
    def amount(self) -> float | None:
        """depth of an overlap, width of a gap, or what is missing to reach [m]"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def lint(task: Task) -> list[Finding]:
    """
    Looks at a task without planning it: overlaps, objects that nothing supports, goals that nothing reaches, units that look wrong.

        >>> st.lint(st.load_task("planar_pushing"))
        []
    """

class SolveRun:
    """One run of a plan in the second-order simulation."""

    @property
    def friction(self) -> float:
        """factor of every coefficient of friction"""

    @property
    def status(self) -> Status: ...

    @property
    def reached(self) -> bool:
        """the goal, within its tolerances"""

    @property
    def dropped(self) -> bool:
        """an object fell"""

    @property
    def lost(self) -> bool:
        """the object left the plan behind"""

    @property
    def duration_s(self) -> float:
        """simulated [s]"""

    @property
    def error(self) -> GoalError:
        """of the object at the end"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class SolveTry:
    """What became of one seed."""

    @property
    def seed(self) -> int: ...

    @property
    def status(self) -> Status:
        """of the search"""

    @property
    def reason(self) -> str: ...

    @property
    def plan(self) -> Plan:
        """the refined plan where there is one"""

    @property
    def accepted(self) -> bool:
        """by check_plan()"""

    @property
    def runs(self) -> list[SolveRun]:
        """the first alone where it misses the goal, else one per friction"""

    @property
    def holds(self) -> bool:
        """every run reached the goal"""

    @property
    def plan_s(self) -> float: ...

    @property
    def refine_s(self) -> float: ...

    @property
    def simulate_s(self) -> float: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class SolveResult:
    """What became of all seeds."""

    @property
    def status(self) -> Status: ...

    @property
    def best(self) -> SolveTry:
        """the first that holds, else the best one"""

    @property
    def tries(self) -> list[SolveTry]:
        """in the order of their seeds"""

    @property
    def wall_s(self) -> float: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def solve(task: Task, *, options: PlannerOptions | dict | None = None, seed: int | None = None, tries: int = 20, friction: Sequence[float] = [1.0], speed: float = 0.1, threads: int = 0, timeout_s: float = 120.0, on_progress: Callable[[Progress], bool | None] | None = None) -> SolveResult:
    """
    Plans, refines, checks and simulates seeds until one reaches its goal in the second-order simulation.

      options: of the planner: PlannerOptions, or a dict of those that differ from the task's; None: the task's.
      seed: of the first try, the next ones count up; None: that of the options. tries: at most, >= 1.
      friction: the goal has to be reached with every coefficient of friction times each of these, >= 0.
      speed: of the runs, times the full timing that follows from the object and the motors (E.13), > 0; above 1 only pushes are faster.
      threads: 0 for all cores; the result does not depend on it. timeout_s: of all tries [s], > 0.
      on_progress: called with Progress; Ctrl-C and an error in it stop the run.

    status: Solved: best.holds; MaxIterations: no try holds, or time used up; Cancelled. Raises InvalidInput.

        >>> found = st.solve(st.load_task("planar_pushing"), seed=0, tries=1, speed=20.0)
        >>> [(one.seed, one.status) for one in found.tries]
        [(0, Status.Solved)]
    """

class PieceError:
    """
    Planned against simulated pose of the object over one piece (3.10)-(3.12).
    """

    @property
    def mean_position(self) -> float:
        """[m]"""

    @property
    def mean_angle(self) -> float:
        """[rad]"""

    @property
    def start_position(self) -> float:
        """[m]"""

    @property
    def start_angle(self) -> float:
        """[rad]"""

    @property
    def end_position(self) -> float:
        """[m]"""

    @property
    def end_angle(self) -> float:
        """[rad]"""

    @property
    def length_position(self) -> float:
        """of the planned path [m]"""

    @property
    def length_angle(self) -> float:
        """of the planned path [rad]"""

    @property
    def normalised_position(self) -> float | None:
        """
        None where the plan moves the object by less than a thousandth of its length
        """

    @property
    def normalised_angle(self) -> float | None: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class PieceReport:
    """A push or a regrasp of a run beside its plan."""

    @property
    def kind(self) -> SegmentKind:
        """Contact or Regrasp"""

    @property
    def first_segment(self) -> int: ...

    @property
    def last_segment(self) -> int: ...

    @property
    def begin_s(self) -> float: ...

    @property
    def end_s(self) -> float: ...

    @property
    def in_plan(self) -> PieceError | None:
        """
        with what earlier pieces left behind; None where the whole run ended before
        """

    @property
    def alone(self) -> PieceError | None:
        """started from the planned state; None for regrasps"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class TransferResult:
    """A plan run open loop, beside what it predicts."""

    @property
    def status(self) -> Status: ...

    @property
    def message(self) -> str: ...

    @property
    def pieces(self) -> list[PieceReport]: ...

    @property
    def error(self) -> GoalError:
        """of the object at the end"""

    @property
    def reached(self) -> bool: ...

    @property
    def dropped(self) -> int | None:
        """index of the first object that fell, or None"""

    @property
    def dropped_s(self) -> float:
        """and when [s]"""

    @property
    def max_depth(self) -> float:
        """deepest penetration [m]"""

    @property
    def duration_s(self) -> float:
        """simulated [s]"""

    @property
    def times(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """[s] (samples)"""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """simulated (samples, n_q)"""

    @property
    def q_plan(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """planned (samples, n_q)"""

    @property
    def piece(self) -> list[int]:
        """index into pieces (samples)"""

    @property
    def wall_s(self) -> float: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class SpeedLimits:
    """
    Speeds of commands that are the same for any object and robot (E.1), (E.8), (E.9).
    """

    def __init__(self, *, revolute: float = 0.1, prismatic: float = 0.0125, regrasp_factor: float = 4.0, load_time: float = 0.5, pause: float = 4.0) -> None:
        """
        revolute [rad/s] and prismatic [m/s] while pushing, regrasps regrasp_factor times as fast, all > 0; springs take up the weight of the lightest object in load_time [s] and commands rest for pause [s] between pieces, both >= 0. Raises InvalidInput.
        """

    @property
    def revolute(self) -> float:
        """[rad/s]"""

    @property
    def prismatic(self) -> float:
        """[m/s]"""

    @property
    def regrasp_factor(self) -> float: ...

    @property
    def load_time(self) -> float:
        """[s]"""

    @property
    def pause(self) -> float:
        """[s]"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def transfer(plan: Plan, *, speed: float = 0.1, pause: float = 0.0, uniform: SpeedLimits | None = None, substeps: int | None = None, rest_time: float = 0.05, friction_scale: float = 1.0, mass_scale: float = 1.0, start_error: numpy.typing.ArrayLike | None = None, velocity_reference: bool | numpy.bool_ = True, hold: float = 4.0, whole: bool | numpy.bool_ = True, alone: bool | numpy.bool_ = True, threads: int = 0, timeout_s: float | None = None) -> TransferResult:
    """
    Runs a plan open loop in the second-order simulation and compares it with what the plan predicts (3.10)-(3.12).

      speed: times the full timing that follows from the object and the motors (E.13), > 0; above 1 only pushes are faster. Without feedback most plans hold at
        the default of 0.1, and few at 1.
      pause: commands rest this long between pieces [s], >= 0.
      uniform: in place of speed and pause, limits that are the same for any object and robot, and commands as the plan has them (E.1).
      substeps: every contact edge is predicted anew in so many steps first; None: as the plan does.
      rest_time: in which objects on joints come to rest [s].
      friction_scale, mass_scale: factors of every coefficient of friction, >= 0, and of the mass of every object, > 0.
      start_error: by what the objects are off their start in their tangent (n_vu) [m, rad]; overlaps are moved apart. None: not at all.
      velocity_reference: damping of the joint springs acts on the difference to the commanded velocity; else on the velocity, so that
        joints lag behind their commands, as in the thesis.
      hold: the last command is held so long before the goal is judged [s].
      whole: run the whole plan. alone: run every push by itself from its planned start.
      threads: for those; 0 for all cores; the result does not depend on it.
      timeout_s: [s] > 0; None: as long as it takes.

    status: Solved: run to the end, whatever came out; MaxIterations (time used up); NumericalFailure (`message`). Raises InvalidInput.

        >>> plan = st.plan(st.load_task("planar_pushing"), seed=0).plan
        >>> run = st.transfer(plan, speed=20.0, pause=0.2, hold=0.2, alone=False)
        >>> run.status, run.q.shape == (len(run.times), 5)
        (Status.Solved, True)
    """

class ErrorSets:
    """Sets in which the errors of a model lie (docs/theory/tube.md)."""

    def __init__(self, *, position: float = 0.002, angle: float = 0.03490658503988659, friction: float = 0.3, mass: float = 0.3, contact: float = 0.005) -> None:
        """
        position [m] and angle [rad]: of objects at the start, >= 0. friction, mass: shares by which every coefficient of friction and the mass of every object are off at most, in [0, 1). contact: of the gap of a contact, in lengths of the object of the goal, >= 0. Raises InvalidInput.
        """

    @property
    def position(self) -> float:
        """[m]"""

    @property
    def angle(self) -> float:
        """[rad]"""

    @property
    def friction(self) -> float: ...

    @property
    def mass(self) -> float: ...

    @property
    def contact(self) -> float:
        """in lengths of the object"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class WorldError:
    """One world in sets of errors."""

    @property
    def start(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """of the objects in their tangent (n_vu) [m, rad]"""

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
    A random world in the sets around the start of a plan: another one for each index, the same ones for a seed.

        >>> plan = st.plan(st.load_task("planar_pushing"), seed=0).plan
        >>> world = st.draw_world(plan, st.ErrorSets(friction=0.0), index=3)
        >>> world.friction, len(world.start), bool(0.7 <= world.mass <= 1.3)
        (1.0, 3, True)
    """

class TubeRest:
    """Where the object is at the end of a push or a regrasp."""

    @property
    def kind(self) -> SegmentKind:
        """Contact or Regrasp"""

    @property
    def last_segment(self) -> int:
        """of the plan, which ends here"""

    @property
    def centre(self) -> Pose:
        """pose that the bound is around"""

    @property
    def offset(self) -> GoalError:
        """of the centre from where the plan has the object"""

    @property
    def position(self) -> float:
        """the object is within this of the centre [m]"""

    @property
    def angle(self) -> float:
        """
        and turned from it by this at most [rad]; infinite where a scenario was lost
        """

    @property
    def scenarios(self) -> list[Pose]:
        """poses in the bundle, that of the known world first"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class TubeResult:
    """A bound of where the object of a plan is at every rest."""

    @property
    def status(self) -> Status: ...

    @property
    def rests(self) -> list[TubeRest]:
        """ends of pushes and regrasps, in their order"""

    @property
    def goal(self) -> GoalError:
        """bound of the distance from the goal at the end"""

    @property
    def calibrated(self) -> bool:
        """
        runs in the simulation stay inside as often as the factors promise: in planar scenes alone
        """

    @property
    def inside(self) -> bool:
        """the bound is within the tolerances of the goal, and calibrated"""

    @property
    def lost(self) -> int:
        """scenarios in which a step had no solution"""

    @property
    def steps(self) -> int: ...

    @property
    def wall_s(self) -> float: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def calc_tube(plan: Plan, errors: ErrorSets = ..., *, factors: tuple[float, float] = (1.0, 1.0), scenarios: int = 16, seed: int = 0, threads: int = 1, timeout_s: float | None = None) -> TubeResult:
    """
    A bound of where the object of a plan is at every rest when the plan is carried out without feedback (docs/theory/tube.md).

      errors: sets that contain what differs from the model.
      factors: by which the tube is wider than the bundle in position and angle, > 0; the default was calibrated on runs in MuJoCo.
      scenarios: worlds that are drawn from the sets, beside the known one, >= 1. seed: of these.
      threads: 0 for all cores; the result does not depend on it. timeout_s: [s] > 0; None: as long as it takes.

    status: Solved; MaxIterations (time used up; no rests). Raises InvalidInput.

        >>> plan = st.refine(st.plan(st.load_task("iiwa_bimanual_planar"), seed=0).plan).plan
        >>> tube = st.calc_tube(plan)
        >>> tube.status, tube.inside, len(tube.rests[0].scenarios)
        (Status.Solved, True, 17)
    """

class RunEnd(enum.Enum):
    """Why a run ended."""

    Reached = 0
    """the goal held"""

    Dropped = 1
    """an object fell"""

    NoPlan = 2
    """the planner found none, or refused the start"""

    Replans = 3
    """used up"""

    TimeUp = 4
    """`duration` is over"""

    Deadline = 5
    """`timeout_s` is over"""

    Cancelled = 6

    Silent = 7
    """the plant does not answer"""

    Unfelt = 8
    """guarded moves before the run did not end as they should"""

class RunState(enum.Enum):
    """What a run does at a moment."""

    Hold = 0
    """commands rest: something settles, or the goal has to hold"""

    Push = 1
    """the robot pushes"""

    Regrasp = 2
    """the robot moves to new contacts"""

    Replan = 3
    """commands rest while the planner works"""

class RunSample:
    """What is seen and decided at one look of a run."""

    @property
    def time(self) -> float:
        """since the start of the run [s]"""

    @property
    def state(self) -> RunState: ...

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """measured (n_q)"""

    @property
    def q_plan(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """as planned for this moment; where nothing is planned as measured (n_q)"""

    @property
    def u(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """commands (n_a) [rad or m]"""

    @property
    def piece(self) -> int:
        """index into RunResult.pieces; -1 before the first"""

    @property
    def plans(self) -> int:
        """so far"""

    @property
    def goal_share(self) -> float:
        """how far the object is from the goal, in its tolerances"""

    @property
    def goal(self) -> int:
        """which one of goals in a row"""

    @property
    def torque(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        of the motors, of each the largest since the sample before (n_a) [N m or N]; empty of a plant of one's own
        """

    @property
    def forces(self) -> list[PairForce]:
        """by pair; empty of a plant of one's own"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class RunPlan:
    """One call of the planner."""

    @property
    def time(self) -> float:
        """of the run, when it was asked [s]"""

    @property
    def wall_s(self) -> float:
        """that it took"""

    @property
    def processor_s(self) -> float:
        """... of all cores of the process [s]"""

    @property
    def clock_s(self) -> float:
        """... and of the clock of the plant [s]"""

    @property
    def status(self) -> Status: ...

    @property
    def cause(self) -> str:
        """why it was asked"""

    @property
    def joined(self) -> bool:
        """the plan before was gone on with, and nothing was searched"""

    @property
    def reason(self) -> str:
        """what the planner said, where it found nothing"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class RunGoal:
    """One goal of a run."""

    @property
    def reached(self) -> bool: ...

    @property
    def begin_s(self) -> float:
        """since the start of the run, when it was the next one to be reached"""

    @property
    def end_s(self) -> float:
        """... when it had been held for as long as asked, or the run ended"""

    @property
    def replans(self) -> int:
        """plans after the first one for it"""

    @property
    def error(self) -> GoalError:
        """at its end, as measured"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class RunPiece:
    """What was carried out of a piece of a plan."""

    @property
    def kind(self) -> SegmentKind:
        """Contact or Regrasp"""

    @property
    def plan(self) -> int:
        """index into RunResult.plans; -1: the given one, or none was needed yet"""

    @property
    def begin_s(self) -> float: ...

    @property
    def end_s(self) -> float: ...

    @property
    def off(self) -> float:
        """
        how far the object was off its path at the end, in tolerances of the goal
        """

    @property
    def given_up(self) -> bool:
        """it was too far off"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Measurement:
    """What a plant says of itself."""

    def __init__(self, time: float, q: numpy.typing.ArrayLike, u: numpy.typing.ArrayLike, object_time: float | None = None) -> None:
        """object_time: None: `time`."""

    @property
    def time(self) -> float:
        """of the plant's clock, when the joints were measured [s]"""

    @property
    def object_time(self) -> float:
        """... and when the objects were where q has them [s]"""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """objects as last seen, joints as measured (n_q)"""

    @property
    def u(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """commands in force (n_a) [rad or m]"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class SimulatedPlant:
    """
    MuJoCo as a plant, at rest in the start of a task, in which what overlaps is moved apart: what stands behind run() where no other does.
    """

    def __init__(self, task: Task) -> None: ...

    def read(self) -> Measurement | None:
        """A Measurement; None: the simulation broke down."""

    def command(self, u: numpy.typing.ArrayLike, period: float) -> bool:
        """Commands go straight to u (n_a) within period [s]. False: not taken."""

    def push(self, body: str, force_W: numpy.typing.ArrayLike, p_BP: numpy.typing.ArrayLike | None = None) -> None:
        """
        A force [N] (3) on a body from now on, in place of the one before; zero ends it.

          p_BP: its point in the frame of the body [m] (3); None: the centre of mass of an object.

            >>> task = st.load_task("planar_pushing")
            >>> plant = st.SimulatedPlant(task)
            >>> plant.push("box", [0, 5, 0])
            >>> plant.command(plant.read().u, 0.1), bool(plant.read().q[0] > task.q_start[0])
            (True, True)
        """

    def __reduce__(self) -> tuple: ...

class RunResult:
    """What came of bringing an object to its goal in closed loop."""

    @property
    def status(self) -> Status:
        """Solved: reached"""

    @property
    def end(self) -> RunEnd:
        """why the run ended"""

    @property
    def message(self) -> str:
        """the same in words, where the goal was not reached"""

    @property
    def reached(self) -> bool:
        """all goals"""

    @property
    def goals(self) -> list[RunGoal]:
        """those that were begun, in a row"""

    @property
    def goals_reached(self) -> int: ...

    @property
    def error(self) -> GoalError:
        """of the object at the end, as measured"""

    @property
    def true_error(self) -> GoalError:
        """... and as it is; of a plant of one's own as measured"""

    @property
    def touch(self) -> GuardedResult:
        """what became of the moves of touch_first; None: there were none"""

    @property
    def duration_s(self) -> float:
        """by the clock of the plant [s]"""

    @property
    def planning_s(self) -> float:
        """wall time of all plans"""

    @property
    def wall_s(self) -> float: ...

    @property
    def plans(self) -> list[RunPlan]: ...

    @property
    def pieces(self) -> list[RunPiece]: ...

    @property
    def replans(self) -> int:
        """plans that something on the way called for"""

    @property
    def pushes(self) -> int: ...

    @property
    def regrasps(self) -> int: ...

    @property
    def dropped(self) -> int | None:
        """index of the object that fell, or None"""

    @property
    def max_depth(self) -> float:
        """deepest penetration [m]; NaN of a plant of one's own"""

    @property
    def start_overlap(self) -> float:
        """
        deepest overlap of a start that was moved apart before the plant began [m]; 0: it is as it was given
        """

    @property
    def start_moved(self) -> float:
        """by how much an object was moved then, at most [m or rad]"""

    @property
    def largest_effort(self) -> float:
        """share of a motor's effort, at most 1; NaN of a plant of one's own"""

    @property
    def largest_press(self) -> float | None:
        """
        largest normal force of one pair on a free object, as a multiple of its weight; None: no such object, or a plant of one's own
        """

    @property
    def slip_speeds(self) -> list[float]:
        """
        per piece, how much faster than planned a free object was until the next piece began [m/s]; empty for a plant of one's own
        """

    @property
    def times(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """[s] (looks)"""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """measured (looks, n_q)"""

    @property
    def q_plan(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """planned (looks, n_q)"""

    @property
    def u(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """commands (looks, n_a) [rad or m]"""

    @property
    def piece(self) -> list[int]:
        """index into pieces (looks); -1 before the first"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def run(target: Task | Plan, *, goals: str | str | os.PathLike | Sequence | None = None, hold: float = 1.0, plant: object | None = None, options: PlannerOptions | dict | None = None, seed: int | None = None, speed: float = 1.0, replans: int = 60, duration: float = 600.0, friction_scale: float = 1.0, mass_scale: float = 1.0, pose_noise: tuple[float, float] = (0.0, 0.0), pose_delay: float = 0.0, pushes: Sequence[tuple[float, float, numpy.typing.ArrayLike]] = (), threads: int = 0, timeout_s: float = 300.0, plan_timeout_s: float = 20.0, plan_processor_s: float | None = None, planning_rate: float = 1.0, plan_step_time_s: float | None = None, active_hold: bool = False, join: bool = True, finger_gait: bool = True, touch_first: str | str | os.PathLike | TouchScenario | None = None, on_progress: Callable[[Progress], bool | None] | None = None, on_sample: Callable[[RunSample], None] | None = None) -> RunResult:
    """
    Brings the object of a task to its goal in MuJoCo: carries plans out at real speed and plans anew where they fail (E.13)-(E.15).

      target: a Task, or a Plan to begin with.
      goals: in place of that of the task, reached one after another while the clock goes on: a list, or the name of a file with one (.yaml).
        Each is numbers as of Task.set_goal, or a dict as `goal` of a task. Each is held before the next one begins, and one that is not
        reached ends the run; `duration` and `timeout_s` are those of all. None: that of the task.
      hold: a goal counts once the object was within its tolerances for so long [s], >= 0; 0: as soon as it is seen there, on its way as well.
      plant: what carries commands out: an object with read(), which gives a Measurement or None where the robot does not answer, and
        command(u, period), which moves the commands straight to u within period [s], returns when that is over, and may give False where
        they are not taken. A plant whose clock goes on by itself has an attribute real_time that is True: it is commanded while the planner works.
        An error in them ends the run and is raised. None: MuJoCo, to which the factors, noise and pushes apply.
      options: of the planner: PlannerOptions, or a dict of those that differ from the target's; None: the target's.
      seed: of the plans and of the noise; None: that of the options.
      speed: times that which follows from object and motors, > 0; above 1 of pushes alone.
      replans: after the first plan of a goal, at most, >= 0. duration: by the clock of the plant, at most [s], > 0.
      friction_scale, mass_scale: factors of every coefficient of friction and of the mass of every object in the simulation.
      pose_noise: standard deviations of measured object poses [m], [rad]. pose_delay: they are seen so late [s].
      pushes: forces on the object from outside: (begin [s], duration [s], force in W [N] (3)).
      threads: of the planner, 0 for all cores; the result does not depend on it. timeout_s: of the run [s], > 0.
      plan_timeout_s: of one plan [s], > 0. plan_processor_s: ... or this much time of all cores of the process [s], > 0, which other work
        on the machine does not shorten; None: plan_timeout_s alone.
      planning_rate: seconds of one core that the planner works within a second of the plant's clock, which goes on meanwhile, >= 0; 0: it
        stands still. plan_step_time_s: each step that the planner computes is charged like this [s], > 0, so that a run is the same on every
        machine; None: the processor time that it took.
      active_hold: the fingers of a hand keep a free object where it is while nothing is carried out (E.21); False: commands rest.
      join: before the planner searches, the plan before is gone on with, where that leads to the goal.
      finger_gait: an object that would roll out of an open hand is turned to its goal by the fingers, one of which at a time goes back (E.23).
      touch_first: guarded moves that are carried out first, in the world in which the run goes on (docs/guarded_moves.md): a TouchScenario of
        this task, or the name or file of one with the key `task`. Fixed bodies are then planned for where the arm felt them, also if a
        Plan was given.
      on_progress: called with Progress (iteration: plans, size: pieces, best: tolerances from the goal); Ctrl-C and an error in it stop the
        run, and the robot holds. on_sample: called with RunSample at every look, 50 a second of the plant's clock; an error in it stops the run as well.

    status: Solved: reached; MaxIterations, Cancelled or NumericalFailure: `end` and `message` say what. Raises InvalidInput.

        >>> run = st.run(st.load_task("planar_pushing"), seed=0, duration=0.5)
        >>> run.end, run.reached
        (RunEnd.TimeUp, False)
    """

class Law(enum.Enum):
    """What computes the command of a tick."""

    ContactAware = 0
    """tracking with bounded forces (C.3)"""

    Unconstrained = 1
    """baseline: tracking alone, without forces and limits"""

    NullSpace = 2
    """
    baseline: stiffness-consistent null space with the force as an equality
    """

    ForceEquality = 3
    """
    baseline: the early published form, the force of one contact as an equality
    """

class TrackingCost(enum.Enum):
    """What of a command is compared with the reference."""

    Command = 0
    """the command (5.24): for contacts with friction"""

    Equilibrium = 1
    """the equilibrium that it leads to (5.22): for contacts without"""

class ForceDampingOptions:
    """
    How far forces that are not as predicted slow the command down (5.28), (5.29).

      largest: w_max [-], >= 0. force_scale: an error of this makes 1 - 1/e of it [N], > 0.
      forget_rate: alpha, in (0, 1]. Both are stated for ticks of `period` [s], > 0; other ticks slow down as much per second. printed: (5.29) as printed, an average of two ticks; else a low-pass.
    """

    def __init__(self, *, largest: float = 5.0, force_scale: float = 5.0, forget_rate: float = 0.2, period: float = 0.005, printed: bool | numpy.bool_ = False) -> None: ...

    @property
    def largest(self) -> float: ...

    @property
    def force_scale(self) -> float: ...

    @property
    def forget_rate(self) -> float: ...

    @property
    def period(self) -> float:
        """[s]"""

    @property
    def printed(self) -> bool: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class ContactForce:
    """
    A force on the robot, measured or estimated.

      body: link that is touched, as robot/link.
      p_WC: where [m] (3). force_W: on the robot; its direction is the normal of (5.4) [N] (3).
      id: the same contact has the same number in the next tick, so that its force can be predicted.
      lambda_max: own bound [N], > 0; None: that of the controller.
    """

    def __init__(self, *, body: str, p_WC: numpy.typing.ArrayLike, force_W: numpy.typing.ArrayLike, id: int = 0, lambda_max: float | None = None) -> None: ...

    @property
    def body(self) -> str: ...

    @property
    def id(self) -> int: ...

    @property
    def p_WC(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """[m] (3)"""

    @property
    def force_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """on the robot [N] (3)"""

    @property
    def lambda_max(self) -> float | None:
        """[N], or None"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class ToolReference:
    """
    Where a point fixed in a link is to be.

      body: link, as robot/link. X_BT: the tool in it. X_WT: where it is to be in the world.
    """

    def __init__(self, *, body: str, X_BT: Pose, X_WT: Pose) -> None: ...

    @property
    def body(self) -> str: ...

    @property
    def X_BT(self) -> Pose: ...

    @property
    def X_WT(self) -> Pose: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class ControllerState:
    """
    What is measured and wanted in one tick.

      time: of the measurement [s].
      q: joint positions (n_a) [rad or m].
      q_ref: of the next tick (n_a); beside a tool: the posture that is preferred.
      contacts: forces on the robot. tool: where a tool is to be; None: joints are tracked.
    """

    def __init__(self, *, time: float, q: numpy.typing.ArrayLike, q_ref: numpy.typing.ArrayLike, contacts: Sequence[ContactForce] = [], tool: ToolReference | None = None) -> None: ...

    @property
    def time(self) -> float:
        """[s]"""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """(n_a)"""

    @property
    def q_ref(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """(n_a)"""

    @property
    def contacts(self) -> list[ContactForce]: ...

    @property
    def tool(self) -> ToolReference | None: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class ControllerCommand:
    """
    The command of a tick and what it rests on. Forces are those of `taken`; None unless the law is ContactAware.
    """

    @property
    def status(self) -> Status:
        """not Solved: q_cmd is that of the tick before"""

    @property
    def q_cmd(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """(n_a) [rad or m]"""

    @property
    def held(self) -> bool:
        """the measurement is not younger than the last one: nothing was computed"""

    @property
    def taken(self) -> list[ContactForce]:
        """contacts that count, with their forces after the low-pass"""

    @property
    def left_out(self) -> int:
        """contacts for which there was no room"""

    @property
    def damping(self) -> float:
        """w of (5.24)"""

    @property
    def q_next(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')] | None:
        """predicted equilibrium (n_a)"""

    @property
    def lambda_(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')] | None:
        """predicted forces [N] (contacts)"""

    @property
    def slack(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')] | None:
        """by which they exceed their bounds [N] (contacts)"""

    @property
    def pull(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')] | None:
        """by which they are below 0 where contacts do not pull [N] (contacts)"""

    @property
    def torque_slack(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')] | None:
        """by which joint springs exceed `torque` [N m] (n_a)"""

    @property
    def limit_slack(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')] | None:
        """by which q_cmd is outside the joint limits [rad or m] (n_a)"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class ContactController:
    """
    Commands of a stiffness-controlled robot with bounded contact forces, as ros2_control shapes one: configured once, then one
    update a tick. docs/theory/control.md

      model: with a robot whose joints have a stiffness.
      law: Law.ContactAware, or a baseline. cost: TrackingCost.Command (5.24) or Equilibrium (5.22).
      lambda_max: bound of every contact that brings none of its own [N], > 0.
      force_threshold: contacts with less force are left out [N], >= 0, below lambda_max; None: 5 N, or a third of lambda_max if that is less.
      force_time_constant: low-pass on the force of a contact [s], >= 0.
      release_time: in which the bound of a contact that is lost grows by lambda_max, until it holds nothing back [s], > 0.
      max_contacts: of more than these those with the largest forces are taken.
      revolute_speed [rad/s], prismatic_speed [m/s]: of commands, > 0.
      posture_time_constant: in which the posture beside a tool is got nearer [s], >= 0.
      torque: of the joint springs (n_a) [N m], > 0; None: not bounded.
      tool_length: a metre of the tool counts as 1/this radians [m], > 0.
      damping: ForceDampingOptions().
      unilateral: contacts that the reference does not leave do not pull.
      contact_compliance: softness of a contact as a share of the arm's own, > 0; least_lever: shortest lever by which it is judged [m], > 0.
      posture_weight: of |q_cmd - q_ref|^2 beside a tool; epsilon: of it beside the equilibrium (5.22), > 0.
      force_priority, unilateral_priority: of bounded forces before contacts that do not pull, and of these before tracking.

    Raises InvalidInput by the name of the argument; of a robot without stiffness.

        >>> model = st.load_control_scenario("box_in_the_way").model
        >>> controller = st.ContactController(model, lambda_max=15.0)
        >>> controller.configure(np.zeros(model.n_a))
        >>> command = controller.update(st.ControllerState(time=0.0, q=np.zeros(model.n_a), q_ref=np.full(model.n_a, 1e-4)), 0.005)
        >>> command.status, command.q_cmd.shape
        (Status.Solved, (7,))
    """

    def __init__(self, model: Model, *, law: Law = Law.ContactAware, cost: TrackingCost = TrackingCost.Command, lambda_max: float = 15.0, force_threshold: float | None = None, force_time_constant: float = 0.05, release_time: float = 0.5, max_contacts: int = 8, revolute_speed: float = 1.5, prismatic_speed: float = 0.25, torque: numpy.typing.ArrayLike | None = None, posture_time_constant: float = 0.5, tool_length: float = 0.5, damping: ForceDampingOptions = ..., unilateral: bool | numpy.bool_ = True, contact_compliance: float = 0.01, posture_weight: float = 0.001, epsilon: float = 0.001, least_lever: float = 0.01, force_priority: float = 1000000.0, unilateral_priority: float = 1000.0) -> None: ...

    @property
    def model(self) -> Model: ...

    @property
    def law(self) -> Law: ...

    @property
    def lambda_max(self) -> float:
        """[N]"""

    def configure(self, q: numpy.typing.ArrayLike) -> None:
        """
        Starts anew with the present joint positions (n_a) as command. Raises InvalidInput: size, not finite.
        """

    def update(self, state: ControllerState, dt: float) -> ControllerCommand:
        """
        The next command, from a ControllerState. dt: for which it holds [s], > 0.

        A state that is not younger than the last one changes nothing: `held`. Raises InvalidInput: sizes, numbers that are not finite, dt <= 0,
        a link that is not the robot's.
        """

    def __reduce__(self) -> tuple: ...

class ContactSource(enum.Enum):
    """What a controller is told of contacts."""

    Simulated = 0
    """those of the simulation, as if a skin measured them"""

    Estimated = 1
    """
    what joint torques show: a momentum observer, then candidates of sensing
    """

class ControlScenario:
    """
    A robot whose reference goes through things that it does not know, as a file says (scenarios/README.md).
    """

    @property
    def name(self) -> str: ...

    @property
    def description(self) -> str: ...

    @property
    def file(self) -> pathlib.Path: ...

    @property
    def model(self) -> Model: ...

    @property
    def start(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """joint positions (n_a)"""

    @property
    def tool(self) -> str | None:
        """link that is tracked, as robot/link; None: joints are"""

    @property
    def X_BT(self) -> Pose:
        """of the tool in its link"""

    @property
    def duration(self) -> float:
        """[s]"""

    @property
    def period(self) -> float:
        """of the controller [s]"""

    @property
    def contacts(self) -> ContactSource: ...

    @property
    def delay(self) -> float:
        """of what the controller is told of contacts [s]"""

    @property
    def law(self) -> Law: ...

    @property
    def lambda_max(self) -> float:
        """[N]"""

    def calc_reference(self, time: float) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        Joint positions (n_a), or displacement of the tool from its pose at the start in W [m] and its rotation vector [rad] (6).
        """

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class ControlRunResult:
    """
    Forces are those of single contacts, measured; series have a row a tick.
    """

    @property
    def status(self) -> Status: ...

    @property
    def message(self) -> str:
        """what the simulation said"""

    @property
    def times(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """[s] (ticks)"""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """joint positions (ticks, n_a) [rad or m]"""

    @property
    def q_cmd(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """commands (ticks, n_a) [rad or m]"""

    @property
    def reference(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """joints (ticks, n_a) or tool (ticks, 6)"""

    @property
    def largest_force(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """of one contact [N] (ticks)"""

    @property
    def speed(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """norm of the joint velocity [rad/s] (ticks)"""

    @property
    def error(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """norm of q - q_ref [rad], or distance of the tool [m] (ticks)"""

    @property
    def angle_error(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """of the tool [rad] (ticks)"""

    @property
    def bounded(self) -> Annotated[NDArray[numpy.bool_], dict(shape=(None,), order='C')]:
        """a force is predicted at its bound: the reference asks for more (ticks)"""

    @property
    def slack(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """by which a force is predicted above its bound [N] (ticks)"""

    @property
    def forces(self) -> list[list[PairForce]]:
        """on the robot, per tick, of pairs of a robot with something else"""

    @property
    def peak_force(self) -> float:
        """[N]"""

    @property
    def settled_peak(self) -> float:
        """without the first `settle` seconds of a contact [N]"""

    @property
    def settled_ticks(self) -> int:
        """in contact, settled"""

    @property
    def bounded_ticks(self) -> int:
        """of these with the force at its bound"""

    @property
    def bound_error(self) -> float:
        """mean |f - lambda_max| over them [N]"""

    @property
    def bound_p95(self) -> float:
        """95th percentile of f over them [N]"""

    @property
    def mean_force(self) -> float:
        """over the settled ticks [N]"""

    @property
    def makes(self) -> int:
        """contacts made, of the robot as a whole"""

    @property
    def rms_error_contact(self) -> float: ...

    @property
    def rms_error_free(self) -> float: ...

    @property
    def peak_speed(self) -> float:
        """[rad/s]"""

    @property
    def peak_force_rate(self) -> float:
        """largest fall of a force between two ticks, settled contacts [N/s]"""

    @property
    def peak_rise(self) -> float:
        """largest rise of a force between two ticks, settled contacts [N]"""

    @property
    def commanded_rise(self) -> float:
        """what the change of the command makes of it [N]"""

    @property
    def above_ticks(self) -> int:
        """settled ones in which a force is above its bound by more than a fifth"""

    @property
    def slack_ticks(self) -> int:
        """in which a bound was given up by more than a thousandth of itself"""

    @property
    def unsolved_ticks(self) -> int: ...

    @property
    def tick_median_s(self) -> float:
        """processor time of update() [s]"""

    @property
    def tick_p99_s(self) -> float: ...

    @property
    def sense_median_s(self) -> float:
        """processor time of an estimate of contacts [s]; 0: none were made"""

    @property
    def sense_p99_s(self) -> float: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class ControlSample:
    """
    One tick of a ControlLoop: the state from which its period started, and its command.
    """

    @property
    def time(self) -> float:
        """[s]"""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """joint positions (n_a) [rad or m]"""

    @property
    def q_cmd(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """command (n_a) [rad or m]"""

    @property
    def forces(self) -> list[PairForce]:
        """
        on the robot, of pairs of a robot with something else, and of hands (pair -1)
        """

    @property
    def largest_force(self) -> float:
        """of one contact [N]"""

    @property
    def error(self) -> float:
        """norm of q - q_ref [rad], or distance of the tool [m]"""

    @property
    def bounded(self) -> bool:
        """a force is predicted at its bound: the reference asks for more"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class ControlLoop:
    """
    The arm of a scenario in the second-order simulation, tick by tick, as control() has it; after the last knot of the reference
    it stays there. Belongs to one thread at a time.

        >>> loop = st.ControlLoop(st.load_control_scenario("box_in_the_way"))
        >>> loop.push("arm/link_4", [0, 10, 0], [0, 0, 0])
        >>> samples = [loop.tick() for _ in range(10)]
        >>> round(samples[-1].time, 3), samples[-1].largest_force
        (0.045, 10.0)
    """

    def __init__(self, scenario: ControlScenario) -> None: ...

    def tick(self) -> ControlSample:
        """
        Contacts are read, the controller is told of them, and its command is held for a period. Raises InvalidInput: the simulation stopped.
        """

    def push(self, link: str, force_W: numpy.typing.ArrayLike, p_LP: numpy.typing.ArrayLike) -> None:
        """
        A force [N] (3) on a point fixed in a link [m] (3), from the next tick on, in place of the one before; zero ends it.
        """

    @property
    def time(self) -> float:
        """of the next tick [s]"""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """(n_q)"""

    def __reduce__(self) -> tuple: ...

@overload
def load_control_scenario(scenario: str | str | os.PathLike) -> ControlScenario:
    """
    A scenario of control: the name of a built-in one, or a file. Raises InvalidInput: "FILE:LINE: field: got …".

        >>> st.load_control_scenario("box_in_the_way").lambda_max
        15.0
    """

@overload
def load_control_scenario(scenario: dict, *, base: str | os.PathLike | None = None) -> ControlScenario:
    """
    The same of a dict, with the keys of a file. base: the folder that paths in it are relative to; None: the working folder. Raises InvalidInput: "field: got …".
    """

@overload
def control(scenario: ControlScenario, *, law: Law | None = None, lambda_max: float | None = None, friction_scale: float | None = None, contacts: ContactSource | None = None, delay: float | None = None, period: float | None = None, seed: int | None = None, settle: float = 0.3, timeout_s: float | None = None) -> ControlRunResult:
    """
    Runs a scenario in the second-order simulation: impedance control of the joints, the contact controller above it.

      law, lambda_max [N]: instead of the scenario's. friction_scale: factor of every coefficient of friction of the simulation, >= 0.
      contacts: what the controller is told of contacts; delay: age of that, in whole ticks [s], >= 0; seed: of the noise of joint torques.
      period: between two commands [s], > 0.
      settle: forces are called steady this long after their contact was made [s], >= 0.
      timeout_s: [s] > 0; None: as long as it takes.

    All but the last two: None is as the scenario says. status: Solved; MaxIterations (time used up); NumericalFailure (`message`). Raises
    InvalidInput.

        >>> run = st.control("box_in_the_way")
        >>> run.status, run.q.shape == (len(run.times), 7)
        (Status.Solved, True)
    """

@overload
def control(scenario: str | str | os.PathLike, *, law: Law | None = None, lambda_max: float | None = None, friction_scale: float | None = None, contacts: ContactSource | None = None, delay: float | None = None, period: float | None = None, seed: int | None = None, settle: float = 0.3, timeout_s: float | None = None) -> ControlRunResult:
    """The same of load_control_scenario(scenario)."""

class TouchScenario:
    """
    An arm that goes to a posture among things that it does not know, as a file says (scenarios/README.md).
    """

    @property
    def name(self) -> str: ...

    @property
    def description(self) -> str: ...

    @property
    def file(self) -> pathlib.Path: ...

    @property
    def model(self) -> Model:
        """what the arm knows"""

    @property
    def start(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """joint positions (n_a) [rad or m]"""

    @property
    def goal(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """joint positions (n_a) [rad or m]"""

    @property
    def tolerance(self) -> float:
        """of the largest joint at the goal [rad; m in lengths of the robots]"""

    @property
    def speed(self) -> float:
        """of any point of the arm, at most [m/s]"""

    @property
    def max_touches(self) -> int:
        """after which the arm gives up"""

    @property
    def lambda_max(self) -> float:
        """[N]"""

    def make_world(self, seed: int = 0) -> Model:
        """
        The model with what is not known, where it is for this seed. Raises InvalidInput: the start touches something.
        """

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class TouchOutcome(enum.Enum):
    """How a touch run ended."""

    Reached = 0

    NoRoute = 1
    """the arm holds where it is"""

    TooManyTouches = 2
    """the same"""

    Missed = 3
    """at the end of its path the arm is not at the goal, and feels nothing"""

class Touch:
    """A contact that was felt long enough to be told of."""

    @property
    def time(self) -> float:
        """when it was told [s]"""

    @property
    def link(self) -> str:
        """as robot/link"""

    @property
    def p_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """where, from torques [m] (3)"""

    @property
    def n_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """unit, out of what was touched (3)"""

    @property
    def spread(self) -> float:
        """deviation of the estimates [m]"""

    @property
    def force(self) -> float:
        """mean of the estimates [N]"""

    @property
    def radius(self) -> float:
        """of the ball that stands for it from then on (G.2) [m]"""

    @property
    def error(self) -> float | None:
        """
        distance from the nearest contact of the simulation [m]; None: there was none
        """

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class TouchRoute:
    """A way to the goal among what was known then."""

    @property
    def time(self) -> float:
        """when it was found [s]"""

    @property
    def found(self) -> bool: ...

    @property
    def postures(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """to the goal, both ends included (postures, n_a) [rad or m]"""

    @property
    def travel(self) -> float:
        """its length (G.1) [m]"""

    @property
    def wall_s(self) -> float:
        """that the search took"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class TouchResult:
    """What came of going to a posture among unknown things."""

    @property
    def status(self) -> Status: ...

    @property
    def outcome(self) -> TouchOutcome: ...

    @property
    def reached(self) -> bool: ...

    @property
    def reason(self) -> str:
        """why the goal was not reached, or what the simulation said"""

    @property
    def touches(self) -> list[Touch]: ...

    @property
    def routes(self) -> list[TouchRoute]:
        """the first before the first motion, then one after each touch"""

    @property
    def goal_error(self) -> float:
        """of the largest joint at the end [rad; m in lengths of the robots]"""

    @property
    def run(self) -> ControlRunResult:
        """series and forces of the whole run"""

    @property
    def world(self) -> Model:
        """what was simulated"""

    @property
    def map(self) -> Model:
        """
        what the arm knows at the end: the scene, and a ball touch_1, touch_2, … for each place
        """

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

@overload
def load_touch_scenario(scenario: str | str | os.PathLike) -> TouchScenario:
    """
    A scenario of touch: the name of a built-in one, or a file. Raises InvalidInput: "FILE:LINE: field: got …".

        >>> scenario = st.load_touch_scenario("reach_past_pillar")
        >>> scenario.goal.shape == scenario.start.shape, scenario.lambda_max
        (True, 15.0)
    """

@overload
def load_touch_scenario(scenario: dict, *, base: str | os.PathLike | None = None) -> TouchScenario:
    """
    The same of a dict, with the keys of a file. base: the folder that paths in it are relative to; None: the working folder. Raises InvalidInput: "field: got …".
    """

@overload
def touch(scenario: TouchScenario, *, seed: int | None = None, settle: float = 0.3, timeout_s: float | None = None) -> TouchResult:
    """
    An arm goes to its goal with bounded forces, locates what it meets from joint torques, and plans around it.

      seed: of torque noise, of where the unknown is and of paths; None: the scenario's.
      settle: forces are called steady this long after their contact was made [s], >= 0.
      timeout_s: [s] > 0; None: as long as it takes.

    status: Solved: `outcome` says to what; MaxIterations (time used up); NumericalFailure (`reason`). Raises InvalidInput.

        >>> run = st.touch("reach_past_pillar", seed=0)
        >>> run.outcome, len(run.touches) > 0, run.run.q.shape == (len(run.run.times), 7)
        (TouchOutcome.Reached, True, True)
    """

@overload
def touch(scenario: str | str | os.PathLike, *, seed: int | None = None, settle: float = 0.3, timeout_s: float | None = None) -> TouchResult:
    """The same of load_touch_scenario(scenario)."""

class MoveOutcome(enum.Enum):
    """How a move ended."""

    Arrived = 0
    """at the end of its way"""

    Felt = 1
    """what its end asks for was felt, and is pressed with its force"""

    Lost = 2
    """what it pressed on is no longer there: an edge"""

    NotFelt = 3
    """at the end of its way, and nothing was felt"""

    WrongLink = 4
    """something was felt, on none of the links of its end"""

    StillThere = 5
    """at the end of its way, and what it presses on goes on"""

class FeltContact:
    """
    A contact that ended a move, as torques tell. Times are those of the run.
    """

    @property
    def link(self) -> str:
        """as robot/link"""

    @property
    def probability(self) -> float:
        """of that link"""

    @property
    def p_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """place [m] (3)"""

    @property
    def direction_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """of the force on the arm, unit (3)"""

    @property
    def force(self) -> float:
        """[N]"""

    @property
    def begin(self) -> float:
        """when it began [s]"""

    @property
    def alarm(self) -> float:
        """when that was noticed, and the arm stopped [s]"""

    @property
    def time(self) -> float:
        """when it was told, pressed with the force of its move [s]"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class GuardedMoveResult:
    """What became of a move, and, from the simulation, how hard it pressed."""

    @property
    def name(self) -> str: ...

    @property
    def outcome(self) -> MoveOutcome: ...

    @property
    def reason(self) -> str:
        """where it is not as wanted"""

    @property
    def begin(self) -> float:
        """[s]"""

    @property
    def end(self) -> float:
        """[s]"""

    @property
    def travelled(self) -> float:
        """of the tool along its direction, as measured [m]"""

    @property
    def felt(self) -> list[FeltContact]:
        """one contact; of a hand one of each side"""

    @property
    def corrected(self) -> str:
        """fixed body that was moved in the model; empty: none"""

    @property
    def correction(self) -> float | None:
        """by which it was moved along the direction [m]; None: it was not"""

    @property
    def correction_error(self) -> float | None:
        """where it then is less where it is in the simulation [m]"""

    @property
    def contact(self) -> float:
        """when the first contact was made; the end where there was none [s]"""

    @property
    def peak(self) -> float:
        """largest force [N]"""

    @property
    def late_peak(self) -> float:
        """the same from 0.1 s after the contact on [N]"""

    @property
    def last_force(self) -> float:
        """mean over the last 0.1 s [N]"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class GuardedResult:
    """What came of the moves of a scenario."""

    @property
    def status(self) -> Status: ...

    @property
    def reached(self) -> bool:
        """all moves ended as they should"""

    @property
    def reason(self) -> str:
        """why not, or what the simulation said"""

    @property
    def moves(self) -> list[GuardedMoveResult]:
        """those that were begun"""

    @property
    def places(self) -> dict[str, Pose]:
        """
        of fixed bodies that were felt, where the arm now knows them to be: name, pose in W
        """

    @property
    def friction(self) -> JointFriction | None:
        """
        of the joints, as a motion before the moves showed it; None: not asked for
        """

    @property
    def run(self) -> ControlRunResult:
        """series and forces of the whole run"""

    @property
    def world(self) -> Model:
        """what was simulated"""

    @property
    def model(self) -> Model:
        """what the arm knows at the end"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

@overload
def guarded_moves(scenario: TouchScenario, *, seed: int | None = None, settle: float = 0.3, timeout_s: float | None = None) -> GuardedResult:
    """
    Carries out the moves of a scenario one after the other, each until it arrives or feels something (docs/guarded_moves.md).

      scenario: one of load_touch_scenario() that has moves, or its name or file.
      seed: of torque noise and of where the misplaced is; None: the scenario's.
      settle: forces are called steady this long after their contact was made [s], >= 0.
      timeout_s: [s] > 0; None: as long as it takes.

    status: Solved: `reached` says whether all moves ended as they should; MaxIterations (time used up); NumericalFailure (`reason`). Raises InvalidInput.

        >>> done = st.guarded_moves("lower_until_touch", seed=1)
        >>> done.reached, done.moves[0].outcome, done.moves[0].felt[0].link, sorted(done.places)
        (True, MoveOutcome.Felt, 'arm/link_7', ['table'])
    """

@overload
def guarded_moves(scenario: str | str | os.PathLike, *, seed: int | None = None, settle: float = 0.3, timeout_s: float | None = None) -> GuardedResult:
    """The same of load_touch_scenario(scenario)."""

class Sampling(enum.Enum):
    """How samples lie on a link."""

    Uniform = 0
    """independent, uniform by area"""

    Stratified = 1
    """one in each of equal areas"""

    BlueNoise = 2
    """of five times as many those that lie farthest apart"""

class Normals(enum.Enum):
    """Normals of a surface."""

    Flat = 0
    """of the triangle"""

    Smooth = 1
    """of the corners, over edges that are not sharp"""

class SurfaceOptions:
    """
    What of a link counts as its surface.

      segments: triangles around a sphere, a cylinder or a capsule, >= 3.
      rays: from each point whose visibility is tested; 0: hidden faces stay.
      postures: of the robot in which a face may be seen, >= 1.
      crease: edges sharper than this stay sharp with smooth normals [rad].
    """

    def __init__(self, *, segments: int = 32, rays: int = 32, postures: int = 4, crease: float = 0.8) -> None: ...

    @property
    def segments(self) -> int: ...

    @property
    def rays(self) -> int: ...

    @property
    def postures(self) -> int: ...

    @property
    def crease(self) -> float: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class GaussNewton:
    """
    Levenberg-Marquardt on point and force together; steps in shares of the link's size.
    """

    def __init__(self, *, max_steps: int = 20, tol_step: float = 1e-06, damping: float = 1e-06, max_step: float = 0.2) -> None: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class SteepestDescent:
    """Algorithm 4 of the thesis (RSGD): steepest descent on the surface."""

    def __init__(self, *, max_steps: int = 50, tol_gradient: float = 1e-05, armijo: float = 0.4, backtrack: float = 0.5, max_backtracks: int = 10, max_step: float = 0.1) -> None: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class RejectionSampling:
    """The accepted samples as they are (4.9)."""

    def __init__(self) -> None: ...

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Detectability(enum.Enum):
    """
    What the torque of the last joint before a link shows of a contact (4.7).
    """

    Undetectable = 0
    """no force of the cone makes a torque"""

    Partial = 1
    """some do"""

    Full = 2
    """every one does, but 0"""

class DetectabilityMap:
    """Of the samples of a link."""

    @property
    def kinds(self) -> list[Detectability]:
        """per sample"""

    @property
    def eta(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        share of the unit forces whose torque is at most epsilon (4.8), in [0, 1] (samples)
        """

    @property
    def full(self) -> int:
        """number of fully detectable samples"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Verdict(enum.Enum):
    """What torques say of contacts."""

    BelowThreshold = 0
    """no contact, or one that these torques do not show"""

    Explained = 1
    """
    at least one candidate makes the torques, as far as noise and tolerance tell
    """

    Unexplained = 2
    """
    a single contact on the sensed links does not: several contacts, another link, or a wrong friction
    """

class SensedLink:
    """A link on which contacts are looked for."""

    @property
    def name(self) -> str:
        """as robot/link"""

    @property
    def p_L(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """samples, in the link's frame [m] (samples, 3)"""

    @property
    def n_L(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """their outward unit normals (samples, 3)"""

    @property
    def spacing(self) -> float:
        """root of the area per sample [m]"""

    @property
    def joints(self) -> int:
        """
        coordinates that move it: below 3 forces are not unique, below 5 points are not
        """

    @property
    def area(self) -> float:
        """of its surface [m^2]"""

    @property
    def size(self) -> float:
        """diagonal of its bounding box [m]"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Candidate:
    """
    A cluster of points that explain the torques alike, by its best one. A valley is one candidate with its extent.
    """

    @property
    def link(self) -> str:
        """as robot/link"""

    @property
    def p_L(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """in the link's frame [m] (3)"""

    @property
    def n_L(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """outward unit normal (3)"""

    @property
    def f_L(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """on the robot [N] (3)"""

    @property
    def p_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """[m] (3)"""

    @property
    def n_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """(3)"""

    @property
    def f_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """[N] (3)"""

    @property
    def residual(self) -> float:
        """l (4.5) [(N m)^2]"""

    @property
    def explains(self) -> bool:
        """the torques, as far as noise and tolerance tell"""

    @property
    def objective(self) -> float:
        """
        min l + (noise/F)^2 |f|^2 at the best point [(N m)^2]; over noise^2 it is -2 ln of a posterior, up to a constant
        """

    @property
    def probability(self) -> float:
        """
        of the places on its link that are nearest to it; 0 without posterior=True
        """

    @property
    def rank(self) -> int:
        """of J_C: below 3 the force is not unique"""

    @property
    def extent(self) -> float:
        """
        largest distance of its points, of those as good, from the best one [m]
        """

    @property
    def force_spread(self) -> float:
        """largest distance of their forces from f_W [N]"""

    @property
    def points(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """p_L of its points, by residual [m] (points, 3)"""

    @property
    def residuals(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """l of its points [(N m)^2] (points)"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Discrimination:
    """A small motion that tells candidates apart (4.13)."""

    @property
    def status(self) -> Status:
        """Solved, or Infeasible: proved that no motion does"""

    @property
    def dq(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """of the joints (n_a) [rad or m]"""

    @property
    def pull(self) -> list[int]:
        """of each candidate: 1 it pulls away, 0 it pushes into"""

    @property
    def objective(self) -> int:
        """
        how far from half of the candidates it pulls away, of those that are possible the least
        """

    @property
    def nodes(self) -> int:
        """linear programs that were solved"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Posterior:
    """
    Where the robot is touched, as probabilities: nothing, or one contact on a link.

    Before torques are seen a contact has the probability touch_prior, and acts anywhere on what can be touched, uniformly by area, with a force that is normal in every
    direction and cut to the friction cone. Its standard deviation is plausible_force, or not known: 4 N, what the weakest joint holds, or their geometric mean.
    """

    @property
    def nothing(self) -> float:
        """probability that nothing touches the robot"""

    @property
    def links(self) -> dict[str, float]:
        """
        probability of a contact on each link, the largest first; with `nothing` they sum to 1
        """

    @property
    def credible(self) -> list[str]:
        """
        the fewest links that hold 95 % of what is not `nothing`, the likeliest first
        """

    def points(self, link: str) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """
        places on a link that carry weight, the likeliest first, in its frame [m] (places, 3)
        """

    def probabilities(self, link: str) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """their probabilities (places)"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class SenseResult:
    """What torques say of one moment."""

    @property
    def verdict(self) -> Verdict: ...

    @property
    def candidates(self) -> list[Candidate]:
        """those that explain, by objective, then the others, by residual"""

    @property
    def explained(self) -> float:
        """l up to which torques count as explained [(N m)^2]"""

    @property
    def posterior(self) -> Posterior | None:
        """Posterior, or None without posterior=True"""

    @property
    def largest(self) -> float:
        """of the torques that is largest against its noise, less rest [N m; N]"""

    @property
    def largest_joint(self) -> int:
        """its joint"""

    @property
    def threshold(self) -> float:
        """from which that joint would have shown a contact [N m; N]"""

    @property
    def noise(self) -> float:
        """
        of each torque in the coordinates of residuals, so that residual/noise^2 has no unit [N m]
        """

    @property
    def friction(self) -> float:
        """
        with which they were looked for: more than was given where that explained nothing
        """

    @property
    def samples(self) -> int: ...

    @property
    def accepted(self) -> int:
        """samples with a residual small enough"""

    @property
    def descents(self) -> int: ...

    @property
    def converged(self) -> int:
        """of the descents"""

    def calc_distance(self, link: str, p_L: numpy.typing.ArrayLike) -> float:
        """
        Distance of a known contact, p_L in the frame of a link [m] (3), from the nearest point that explains the torques [m]; inf where none is on that link.
        """

    def discriminate(self, q: numpy.typing.ArrayLike, *, all: bool | numpy.bool_ = False, joint_step: float = 0.05, travel: float | None = None, least: float = 0.1, sideways: float = 0.5) -> Discrimination:
        """
        The motion that pulls away from half of the candidates and pushes into the others, as nearly as can be (4.13): what becomes
        of the torques then refutes one half. Of those that explain, in their order; with `all` of all.

          q: (n_q), or joint positions (n_a), of the measurement.
          joint_step: largest change of a joint [rad or m], > 0.
          travel: longest motion at a contact [m], > 0; None: a tenth of joint_step times the longest reach.
          least: of pulling and pushing, sideways: of sliding, shares of travel; least in (0, 1).

        Raises InvalidInput: options, no candidate.
        """

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Payload:
    """
    A rigid body that hangs on a link, and of which the robot does not know.
    """

    @property
    def mass(self) -> float:
        """[kg]; negative: the robot was told of too much, or the sign is -1"""

    @property
    def mass_deviation(self) -> float:
        """standard deviation [kg]"""

    @property
    def centre_L(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """of mass, in the frame of the link [m] (3)"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Hysteresis:
    """What a touch leaves for a while in the torques of rest."""

    @property
    def share(self) -> float:
        """
        of the largest torque of each joint in the touch, by which it is off right after it (standard deviation)
        """

    @property
    def freedom(self) -> float:
        """independent numbers by which it is known; 0: no touch is known"""

    @property
    def settle(self) -> float:
        """time after a touch from which on torques are those of rest [s]"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class TorqueNoise:
    """
    Noise of torques, and how well it is known: sense(noise=n.covariance, freedom=n.freedom).
    """

    @property
    def covariance(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')]:
        """(n_a, n_a) [(N m)^2]"""

    @property
    def freedom(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """independent numbers by which the noise of each joint is known (n_a)"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class Calibration:
    """What is known of torques after rows at rest: calibrate()."""

    @property
    def rest(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        torques where nothing touches, as measured: of the last record (n_a) [N m; N]
        """

    @property
    def noise(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')]:
        """covariance of a torque less rest (n_a, n_a) [(N m)^2]"""

    @property
    def within(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')]:
        """
        covariance of a row about the mean of a long record (n_a, n_a) [(N m)^2]
        """

    @property
    def noise_between(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')] | None:
        """
        the same with the rest of another record of the posture (n_a, n_a); None where no posture has two records
        """

    @property
    def deviation(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """standard deviation of each torque less rest (n_a) [N m; N]"""

    @property
    def drift(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')] | None:
        """of a random walk (n_a, 1) [N m/s^0.5]; None without times that differ"""

    @property
    def freedom(self) -> int:
        """independent numbers by which the noise is known: rows less records"""

    @property
    def hysteresis(self) -> Hysteresis:
        """what touches leave, where rows were touched: Hysteresis"""

    @property
    def payload(self) -> Payload | None:
        """Payload, or None"""

    @property
    def rows(self) -> int: ...

    @property
    def records(self) -> int: ...

    @property
    def postures(self) -> int: ...

    @property
    def touched(self) -> list[int]:
        """rows that were left out: something seems to touch the robot there"""

    @property
    def notes(self) -> list[str]:
        """a sentence each"""

    def calc_rest(self, q: numpy.typing.ArrayLike) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        rest at a posture, with the payload (n_a). q: (n_q), or joint positions (n_a).
        """

    def calc_noise(self, *, touch: numpy.typing.ArrayLike | None = None, seconds: float = 0.0, rest_rows: int = 1) -> TorqueNoise:
        """
        Noise of a torque less the mean of `rest_rows` rows, `seconds` after a touch, as TorqueNoise.

          touch: largest torque of each joint in the touch (n_a) [N m; N], or None where nothing has touched.
        """

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def calibrate(model: Model, q: numpy.typing.ArrayLike, tau: numpy.typing.ArrayLike, *, t: numpy.typing.ArrayLike | None = None, records: Sequence[int] | None = None, touched: Sequence[bool] | None = None, payload: str | None = None, same_posture: float = 0.05, settle: float = 1.0, unmeasured: Sequence[int | str] = []) -> Calibration:
    """
    Offset, noise and drift of a robot's external torques, and a payload that it does not know of, from rows in which nothing touches it.

      q, tau: joint positions and torques as measured (rows, n_a). t: times [s] (rows). records: number of the record of each row (rows), or one record.
      touched: rows in which something touches the robot (rows), or None. They and those less than `settle` seconds after them are no rest, and say what a touch leaves.
      payload: "robot/link" that may carry one; it takes rest in three postures or more.
      same_posture: largest difference of joint positions of one posture.
      unmeasured: joints without a torque sensor, by index or name; their noise is given as 1 and their rest as 0.

    Raises InvalidInput: sizes, no record with two rows, a torque that never changes, rows of which many are touched.
    """

class SignCheck:
    """Which sign total torques have."""

    @property
    def sign(self) -> int:
        """
        1: of the motors on the links; -1: the other one; 0: these are no total torques
        """

    @property
    def factor(self) -> float:
        """of the torques that hold the robot against gravity"""

    @property
    def message(self) -> str:
        """what it means, or what to do"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def check_sign(model: Model, q: numpy.typing.ArrayLike, tau: numpy.typing.ArrayLike) -> SignCheck:
    """The sign of total torques at rest, from gravity. q, tau: (rows, n_a)."""

def calc_holding_torques(model: Model, q: numpy.typing.ArrayLike) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
    """
    Torques with which motors hold the robots against gravity (n_a) [N m; N]. q: (n_q), or joint positions (n_a).
    """

class JointFriction:
    """
    Friction coulomb tanh(qd/stiction_speed) + viscous qd of each joint, and the offset of its torque sensor.
    """

    @property
    def coulomb(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """(n_a) [N m; N]"""

    @property
    def viscous(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """(n_a) [N m s/rad; N s/m]"""

    @property
    def offset(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """(n_a) [N m; N]"""

    @property
    def stiction_speed(self) -> float:
        """below which friction has no sure sign [rad/s or m/s]"""

    @property
    def left(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        deviation of the torques that the fit leaves, their noise included (n_a) [N m; N]
        """

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def observe(model: Model, t: numpy.typing.ArrayLike, q: numpy.typing.ArrayLike, qd: numpy.typing.ArrayLike, tau: numpy.typing.ArrayLike, *, time_constant: float = 0.02, friction: JointFriction | None = None) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
    """
    External torques from motion and motor torques, by the momentum observer: no accelerations are needed (time, n_a) [N m; N].

      t: times, increasing [s] (time). q, qd, tau: joint positions, velocities and torques of the motors on the links (time, n_a).
      time_constant: lag [s], > 0. friction: of identify_friction(), or None.

    Raises InvalidInput: sizes, numbers that are not finite, times that do not increase, a robot without masses.
    """

def identify_friction(model: Model, t: numpy.typing.ArrayLike, q: numpy.typing.ArrayLike, qd: numpy.typing.ArrayLike, tau: numpy.typing.ArrayLike, *, time_constant: float = 0.02, stiction_speed: float = 0.01) -> JointFriction:
    """
    Friction of each joint, from motion in which nothing touches the robot and every joint moves in both directions.

      Arguments as of observe(). stiction_speed: below which friction has no sure sign [rad/s or m/s], > 0.

    Raises InvalidInput: as observe(); a joint that does not move in both directions.
    """

class TouchOnset:
    """
    When a touch begins, and its torques since then as one measurement.

    The slow offset of the torques is followed where nothing touches, and a change test adds up what differs from it. From the beginning of a touch on the offset is
    held, and the mean of the torques grows sharper: sense(q, onset.mean, rest=onset.rest, noise=onset.noise). Belongs to one thread.

      rest: torques where nothing touches (n) [N m; N]. noise: standard deviations of one row (n), or their covariance (n, n): Calibration.within.
      drift: of the offset, a random walk (n) [N m/s^0.5], or None. false_alarms: share of rows at which an alarm begins where nothing touches, in (0, 0.1).
      hysteresis, settle: what a touch leaves, as Calibration.hysteresis says: for `settle` seconds the offset is off by this share of its torques.
      shift: change that is to be found soonest, in deviations of the noise, > 0. rest_rows: of which rest is the mean. quiet: rows within noise that end a touch, >= 1.

    Raises InvalidInput by the name of the argument.
    """

    def __init__(self, rest: numpy.typing.ArrayLike, noise: numpy.typing.ArrayLike | numpy.typing.ArrayLike, *, drift: numpy.typing.ArrayLike | None = None, hysteresis: float = 0.0, settle: float = 1.0, false_alarms: float = 1.388888888888889e-06, shift: float = 2.0, rest_rows: int = 1, quiet: int = 5) -> None: ...

    def update(self, tau: numpy.typing.ArrayLike, dt: float) -> bool:
        """
        A row of torques (n), dt after the one before [s]. Returns whether something touches.
        """

    @property
    def touches(self) -> bool: ...

    @property
    def rows(self) -> int:
        """since the touch began"""

    @property
    def rest(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """offset before the touch (n) [N m; N]"""

    @property
    def mean(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """of the torques since the touch began (n) [N m; N]"""

    @property
    def noise(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')]:
        """covariance of mean - rest (n, n) [(N m)^2]"""

    @property
    def sum(self) -> float:
        """of the change test"""

    @property
    def bound(self) -> float:
        """from which on something touches"""

    def __reduce__(self) -> tuple: ...

class Sensor:
    """
    Surfaces and samples of the links of a robot, on which contacts are looked for. Immutable, shared by threads.

      model: with at least one robot.
      links: "robot/link", * matches any run of characters; empty: all that a joint moves and that have geometry.
      samples: on each link, >= 1. sampling, normals: Sampling.Stratified, Normals.Flat.
      seed: of samples and of the postures in which faces may be seen.
      surface: SurfaceOptions().

    Raises InvalidInput: a pattern that matches no link; a link that no joint moves or that has no surface.

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
    def model(self) -> Model: ...

    @property
    def links(self) -> list[SensedLink]:
        """the sensed ones, in the order of the model"""

    @property
    def notes(self) -> list[str]:
        """faces left out, and links whose joints leave contacts ambiguous"""

    def calc_residuals(self, q: numpy.typing.ArrayLike, tau: numpy.typing.ArrayLike, link: str, p_L: numpy.typing.ArrayLike, n_L: numpy.typing.ArrayLike, *, friction: float = 1.0, rays: int = 4) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        l(p) = min over f in the cone of |J_C^T f - tau|^2 at given points (4.5) [(N m)^2] (points).

          q: (n_q), or joint positions (n_a). tau: external torques (n_a) [N m; N]. link: "robot/link".
          p_L, n_L: points and outward normals, in the link's frame (points, 3) [m].
        """

    def calc_undetectability(self, link: str, p_L: numpy.typing.ArrayLike, n_L: numpy.typing.ArrayLike, *, friction: float = 1.0, epsilon: float) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        eta (4.8) at given points: share of the unit forces of the exact cone whose torque is at most epsilon [N m/N], > 0 (points).

          p_L, n_L: points and outward normals, in the link's frame (points, 3) [m].
        """

    def calc_detectability(self, link: str, *, friction: float = 1.0, rays: int = 4, epsilon: float) -> DetectabilityMap:
        """
        What the torque of the last joint shows at every sample of a link (4.7), (4.8).
        """

    def sense(self, q: numpy.typing.ArrayLike, tau: numpy.typing.ArrayLike, last: SenseResult | None = None, *, friction: float = 1.0, rays: int = 4, noise: float | numpy.typing.ArrayLike | numpy.typing.ArrayLike = 0.1, threshold: float | None = None, accept: float | None = None, accept_share: float = 0.05, tolerance: float = 0.01, method: RejectionSampling | SteepestDescent | GaussNewton = ..., merge: float = 3.0, thin: float = 2.0, plausible_force: float | None = None, friction_error: float = 0.0, rest: Calibration | numpy.typing.ArrayLike | None = None, sign: int = 1, unmeasured: Sequence[int | str] = [], posterior: bool | numpy.bool_ = False, touch_prior: float = 0.5, freedom: float | numpy.typing.ArrayLike | None = None) -> SenseResult:
        """
        Every single contact on the sensed links that makes the torques.

          q: configuration (n_q), or joint positions alone (n_a) with objects at their placed frames [rad or m].
          tau: external torques (n_a), in the order of u: measured ones less those of gravity and motion [N m; N].
          last: result of the cycle before, whose candidates are starts as well.

        Options:
          friction, rays: the cone (4.2) in which forces are looked for, of so many rays, in [3, 64]; rays=0: the exact one.
          noise: standard deviation of every torque [N m], > 0; or one for each joint (n_a), or their covariance (n_a, n_a): Calibration.noise.
          rest: torques where nothing touches, as measured (n_a), a Calibration, or None for 0.
          sign: -1 where the robot reports what it does to its surroundings, as libfranka does; else 1.
          unmeasured: joints without a torque sensor, by index or name: their torques are unknown, and not 0.
          threshold: contacts are looked for where max |tau| is at least this [N m], > 0; None: 4 times the noise of the joint, or more where that is known from few rows.
          accept: samples with residual l up to this are accepted [(N m)^2]; None: accept_share |tau|^2, or what noise may make if that is more.
          tolerance: share of |tau| that an explanation may leave where there is no noise.
          method: GaussNewton(), SteepestDescent() (algorithm 4), RejectionSampling().
          merge: points nearer than this many sample spacings are one candidate.
          thin: Gauss-Newton leaves out starts within so many sample spacings of an earlier start or an end, >= 0.
          plausible_force: F [N], > 0: candidates that explain are ordered by l + (noise/F)^2 |f|^2; None: what the weakest joint holds at its full reach.
          friction_error: share by which the true friction may be larger, in [0, 1): used where nothing explains the torques.
          posterior: SenseResult.posterior as well, by which candidates that explain are then ordered.
          touch_prior: probability of a contact before torques are seen, in (0, 1).
          freedom: independent numbers by which the noise is known, one or one for each joint (n_a), > 0: Calibration.freedom; None: it is known.

        Raises InvalidInput by the name of the argument: sizes, numbers that are not finite, options out of range.
        """

    def sense_series(self, q: numpy.typing.ArrayLike, tau: numpy.typing.ArrayLike, *, friction: float = 1.0, rays: int = 4, noise: float | numpy.typing.ArrayLike | numpy.typing.ArrayLike = 0.1, threshold: float | None = None, accept: float | None = None, accept_share: float = 0.05, tolerance: float = 0.01, method: RejectionSampling | SteepestDescent | GaussNewton = ..., merge: float = 3.0, thin: float = 2.0, plausible_force: float | None = None, friction_error: float = 0.0, rest: Calibration | numpy.typing.ArrayLike | None = None, sign: int = 1, unmeasured: Sequence[int | str] = [], posterior: bool | numpy.bool_ = False, touch_prior: float = 0.5, freedom: float | numpy.typing.ArrayLike | None = None) -> list[SenseResult]:
        """
        The same for a series, each moment from the candidates of the one before.

          q: (time, n_q) or (time, n_a). tau: (time, n_a) [N m; N].

        Options:
          friction, rays: the cone (4.2) in which forces are looked for, of so many rays, in [3, 64]; rays=0: the exact one.
          noise: standard deviation of every torque [N m], > 0; or one for each joint (n_a), or their covariance (n_a, n_a): Calibration.noise.
          rest: torques where nothing touches, as measured (n_a), a Calibration, or None for 0.
          sign: -1 where the robot reports what it does to its surroundings, as libfranka does; else 1.
          unmeasured: joints without a torque sensor, by index or name: their torques are unknown, and not 0.
          threshold: contacts are looked for where max |tau| is at least this [N m], > 0; None: 4 times the noise of the joint, or more where that is known from few rows.
          accept: samples with residual l up to this are accepted [(N m)^2]; None: accept_share |tau|^2, or what noise may make if that is more.
          tolerance: share of |tau| that an explanation may leave where there is no noise.
          method: GaussNewton(), SteepestDescent() (algorithm 4), RejectionSampling().
          merge: points nearer than this many sample spacings are one candidate.
          thin: Gauss-Newton leaves out starts within so many sample spacings of an earlier start or an end, >= 0.
          plausible_force: F [N], > 0: candidates that explain are ordered by l + (noise/F)^2 |f|^2; None: what the weakest joint holds at its full reach.
          friction_error: share by which the true friction may be larger, in [0, 1): used where nothing explains the torques.
          posterior: SenseResult.posterior as well, by which candidates that explain are then ordered.
          touch_prior: probability of a contact before torques are seen, in (0, 1).
          freedom: independent numbers by which the noise is known, one or one for each joint (n_a), > 0: Calibration.freedom; None: it is known.

        Raises InvalidInput by the name of the argument: sizes, numbers that are not finite, options out of range.
        """

    def sense_touch(self, q: numpy.typing.ArrayLike, tau: numpy.typing.ArrayLike, correlation: float = 0.0, *, friction: float = 1.0, rays: int = 4, noise: float | numpy.typing.ArrayLike | numpy.typing.ArrayLike = 0.1, threshold: float | None = None, accept: float | None = None, accept_share: float = 0.05, tolerance: float = 0.01, method: RejectionSampling | SteepestDescent | GaussNewton = ..., merge: float = 3.0, thin: float = 2.0, plausible_force: float | None = None, friction_error: float = 0.0, rest: Calibration | numpy.typing.ArrayLike | None = None, sign: int = 1, unmeasured: Sequence[int | str] = [], posterior: bool | numpy.bool_ = False, touch_prior: float = 0.5, freedom: float | numpy.typing.ArrayLike | None = None) -> SenseResult:
        """
        Several moments of one touch: the same place on the same link, with another force at each moment.

          q: (moments, n_q) or (moments, n_a). tau: (moments, n_a) [N m; N].
          correlation: of the errors of the moments, in [0, 1]: m moments count as m/(1 + (m - 1) correlation). One error of the rest is common to all.

        Candidates are those of the moment whose torques are largest against their noise. Probabilities are always given.

        Options:
          friction, rays: the cone (4.2) in which forces are looked for, of so many rays, in [3, 64]; rays=0: the exact one.
          noise: standard deviation of every torque [N m], > 0; or one for each joint (n_a), or their covariance (n_a, n_a): Calibration.noise.
          rest: torques where nothing touches, as measured (n_a), a Calibration, or None for 0.
          sign: -1 where the robot reports what it does to its surroundings, as libfranka does; else 1.
          unmeasured: joints without a torque sensor, by index or name: their torques are unknown, and not 0.
          threshold: contacts are looked for where max |tau| is at least this [N m], > 0; None: 4 times the noise of the joint, or more where that is known from few rows.
          accept: samples with residual l up to this are accepted [(N m)^2]; None: accept_share |tau|^2, or what noise may make if that is more.
          tolerance: share of |tau| that an explanation may leave where there is no noise.
          method: GaussNewton(), SteepestDescent() (algorithm 4), RejectionSampling().
          merge: points nearer than this many sample spacings are one candidate.
          thin: Gauss-Newton leaves out starts within so many sample spacings of an earlier start or an end, >= 0.
          plausible_force: F [N], > 0: candidates that explain are ordered by l + (noise/F)^2 |f|^2; None: what the weakest joint holds at its full reach.
          friction_error: share by which the true friction may be larger, in [0, 1): used where nothing explains the torques.
          posterior: SenseResult.posterior as well, by which candidates that explain are then ordered.
          touch_prior: probability of a contact before torques are seen, in (0, 1).
          freedom: independent numbers by which the noise is known, one or one for each joint (n_a), > 0: Calibration.freedom; None: it is known.

        Raises InvalidInput by the name of the argument: sizes, numbers that are not finite, options out of range.
        """

    def sense_contacts(self, q: numpy.typing.ArrayLike, tau: numpy.typing.ArrayLike, base: BaseWrench | None = None, last: ContactSets | None = None, *, max_contacts: int = 2, friction: float = 1.0, rays: int = 4, noise: float | numpy.typing.ArrayLike | numpy.typing.ArrayLike = 0.1, threshold: float | None = None, tolerance: float = 0.01, starts: int = 24, descents: int = 6, rest: Calibration | numpy.typing.ArrayLike | None = None, sign: int = 1, unmeasured: Sequence[int | str] = []) -> ContactSets:
        """
        One to three contacts at the same time that make the torques, the fewest that do.

          q: configuration (n_q), or joint positions alone (n_a) [rad or m]. tau: external torques (n_a) [N m; N].
          base: BaseWrench, or None. n_a torques cannot fix the 5 numbers of each contact if they are fewer: sets say their freedom.
          last: of the measurement before, or None. Where one of its sets, led down from where it was, explains these torques and fewer contacts do not,
            no other is looked for.
          max_contacts: in [1, 3]. starts: first contacts that are tried on each link, >= 1. descents: for each combination of links, >= 1.
          friction, rays, noise, threshold, tolerance, rest, sign, unmeasured: as of sense(); rays in [3, 64].

        Raises InvalidInput by the name of the argument.
        """

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

    def __copy__(self) -> Self: ...

    def __deepcopy__(self, memo: object, /) -> Self: ...

class BaseWrench:
    """
    What a force and moment sensor under the base of a robot measures of contacts.

      force_W: sum of the contact forces [N] (3). moment_W: sum of their moments about the origin of the world [N m] (3).
      force_noise, moment_noise: standard deviation of each component [N], [N m], > 0.
    """

    def __init__(self, force_W: numpy.typing.ArrayLike, moment_W: numpy.typing.ArrayLike, *, force_noise: float = 1.0, moment_noise: float = 0.1) -> None: ...

    @property
    def force_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """[N] (3)"""

    @property
    def moment_W(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """about the origin of the world [N m] (3)"""

    @property
    def force_noise(self) -> float:
        """[N]"""

    @property
    def moment_noise(self) -> float:
        """[N m]"""

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def calc_base_wrench(p_W: numpy.typing.ArrayLike, f_W: numpy.typing.ArrayLike) -> BaseWrench:
    """That of a force at a point: f_W [N] (3) at p_W [m] (3)."""

class SetContact:
    """A contact of a set."""

    @property
    def link(self) -> str:
        """as robot/link"""

    @property
    def p_L(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """in the link's frame [m] (3)"""

    @property
    def n_L(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """outward unit normal (3)"""

    @property
    def f_L(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """on the robot [N] (3)"""

    @property
    def deviation(self) -> float:
        """
        standard deviation of the point; where torques say nothing of it the size of its link [m]
        """

    @property
    def is_unique(self) -> bool:
        """
        no motion of the points and forces that leaves all torques moves this point
        """

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class ContactSet:
    """Contacts that make the torques together."""

    @property
    def contacts(self) -> list[SetContact]:
        """by link"""

    @property
    def residual(self) -> float:
        """what they leave of the torques, squared (Y.9) [(N m)^2]"""

    @property
    def freedom(self) -> int:
        """
        dimension of the points and forces near these with the same torques; 0: isolated
        """

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class ContactSets:
    """What one measurement says of contacts at the same time."""

    @property
    def verdict(self) -> Verdict: ...

    @property
    def count(self) -> int:
        """contacts of each set: the fewest that explain the torques"""

    @property
    def ambiguous(self) -> bool:
        """
        several combinations of links explain the torques, or points and forces can change together without a trace in them
        """

    @property
    def sets(self) -> list[ContactSet]:
        """
        that explain the torques, by combination of links; where none do the best one
        """

    @property
    def best(self) -> list[ContactSet]:
        """the best set of each combination of links, the best combination first"""

    @property
    def explained(self) -> float:
        """what counts as explained [(N m)^2]"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

def calc_contact_torque(model: Model, q: numpy.typing.ArrayLike, link: str, p_L: numpy.typing.ArrayLike, f_L: numpy.typing.ArrayLike) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
    """
    Torques (n_a) of a force on a link [N m; N] (Y.1).

      q: (n_q), or joint positions (n_a). p_L, f_L: point [m] and force on the robot [N], in the link's frame (3).
    """

class KnownContact:
    """A contact from which the torques of a scenario were computed."""

    @property
    def link(self) -> str:
        """as robot/link"""

    @property
    def p_L(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """in the link's frame [m] (3)"""

    @property
    def f_L(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """on the robot [N] (3)"""

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

class SensingScenario:
    """
    A robot and what was measured, as a file says (tasks/schema/sensing.schema.json).
    """

    @property
    def name(self) -> str: ...

    @property
    def description(self) -> str: ...

    @property
    def file(self) -> pathlib.Path: ...

    @property
    def sensor(self) -> Sensor: ...

    @property
    def times(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """[s] (time)"""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """joint positions [rad or m] (time, n_a)"""

    @property
    def tau(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """external torques [N m; N] (time, n_a)"""

    @property
    def notes(self) -> list[str]:
        """
        a sentence each: columns of the file of the series that were not read, or whose meaning needs a word
        """

    @property
    def pushed(self) -> list[list[int]]:
        """
        of a simulated robot: indices into contacts of the pushes that act (time); of others empty
        """

    @property
    def contact(self) -> KnownContact | None:
        """where the file gives a single one instead of torques, or None"""

    @property
    def contacts(self) -> list[KnownContact]:
        """all that the file gives instead of torques"""

    @property
    def noise(self) -> float:
        """standard deviation of each torque [N m]"""

    def sense(self, q: numpy.typing.ArrayLike, tau: numpy.typing.ArrayLike, last: SenseResult | None = None) -> SenseResult:
        """
        One measurement with the options of the scenario.

          q: (n_q), or joint positions (n_a). tau: external torques (n_a) [N m; N]. last: of the measurement before, or None.

        Raises InvalidInput: sizes, numbers that are not finite.
        """

    @property
    def max_contacts(self) -> int:
        """at the same time"""

    @property
    def base_wrench(self) -> BaseWrench | None:
        """
        under the base, or None; of a simulated robot only the noise of the sensor
        """

    @property
    def base_wrenches(self) -> list[BaseWrench]:
        """measured under the base (time); empty: none"""

    def sense_contacts(self, q: numpy.typing.ArrayLike, tau: numpy.typing.ArrayLike, base: BaseWrench | None = None, last: ContactSets | None = None) -> ContactSets:
        """
        Contacts at the same time, at most max_contacts, with the options of the scenario: Sensor.sense_contacts().

          q: (n_q), or joint positions (n_a). tau: external torques (n_a) [N m; N]. base: BaseWrench, or None. last: of the measurement before, or None.

        Raises InvalidInput: sizes, numbers that are not finite.
        """

    def __repr__(self) -> str: ...

    def __getstate__(self) -> tuple: ...

    def __setstate__(self, state: tuple, /) -> None: ...

@overload
def load_sensing_scenario(scenario: str | str | os.PathLike) -> SensingScenario:
    """
    A scenario of sensing: the name of a built-in one, or a file. Raises InvalidInput: "FILE:LINE: field: got …".

        >>> scenario = st.load_sensing_scenario("ur5_forearm")
        >>> scenario.tau.shape, scenario.contact.link
        ((1, 6), 'arm/forearm_link')
    """

@overload
def load_sensing_scenario(scenario: dict, *, base: str | os.PathLike | None = None) -> SensingScenario:
    """
    The same of a dict, with the keys of a file. base: the folder that paths in it are relative to; None: the working folder. Raises InvalidInput: "field: got …".
    """

@overload
def sense(scenario: SensingScenario) -> list[SenseResult]:
    """
    What every moment of a scenario says, with the scenario's options, each from the candidates of the one before.

        >>> [result.verdict for result in st.sense("ur5_forearm")]
        [Verdict.Explained]
    """

@overload
def sense(scenario: str | str | os.PathLike) -> list[SenseResult]:
    """The same of load_sensing_scenario(scenario)."""

class _SharedSensor:
    def __reduce__(self) -> tuple: ...

    def __copy__(self) -> Self: ...

    def __deepcopy__(self, memo: object, /) -> Self: ...

def _make_shared_sensor(model: Model, options: tuple) -> _SharedSensor: ...
