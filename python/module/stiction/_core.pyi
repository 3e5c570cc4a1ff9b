"""Robot motion through contact."""

from collections.abc import Callable
import enum
import os
import pathlib
from typing import Annotated

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

    def __init__(self, R: numpy.typing.ArrayLike, p: numpy.typing.ArrayLike) -> None: ...

    @property
    def R(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3, 3), order='F')]:
        """rotation (3, 3)"""

    @property
    def p(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """position [m] (3)"""

    def __matmul__(self, arg: Pose, /) -> Pose: ...

    def inverse(self) -> Pose: ...

    def __repr__(self) -> str: ...

class Body:
    @property
    def name(self) -> str: ...

    @property
    def kind(self) -> str: ...

    @property
    def dofs(self) -> list[int]:
        """velocity indices that move it"""

class Geometry:
    @property
    def name(self) -> str: ...

    @property
    def body(self) -> int: ...

    @property
    def X_BG(self) -> Pose: ...

    @property
    def friction(self) -> float: ...

class Pair:
    @property
    def geometry_a(self) -> int: ...

    @property
    def geometry_b(self) -> int: ...

    @property
    def friction(self) -> float: ...

    @property
    def max_distance(self) -> float:
        """[m]"""

class Dof:
    @property
    def name(self) -> str: ...

    @property
    def revolute(self) -> bool: ...

    @property
    def lower(self) -> float: ...

    @property
    def upper(self) -> float: ...

    @property
    def stiffness(self) -> float:
        """K_a [N/m or N m/rad], 0 for objects"""

class ObjectInfo:
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
    def mass(self) -> float:
        """[kg]"""

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

def load_scene(file: str | os.PathLike) -> Scene:
    """Reads a scene file (YAML)."""

def load_model(file: str | os.PathLike) -> Model:
    """The model of a scene file."""

class Model:
    """
    Immutable kinematics, actuation, geometry and friction of a scene, shared by threads.
    """

    @staticmethod
    def make(scene: Scene) -> Model: ...

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
    def geometries(self) -> list[Geometry]: ...

    @property
    def pairs(self) -> list[Pair]: ...

    @property
    def dofs(self) -> list[Dof]: ...

    @property
    def objects(self) -> list[ObjectInfo]: ...

    @property
    def planar_axis(self) -> int | None:
        """axis normal to the plane in which everything moves, or None"""

    def neutral(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        every object at its placed frame, every joint as near to 0 as its limits allow (n_q)
        """

    def joint_index(self, name: str) -> int: ...

    def object_index(self, name: str) -> int: ...

    def retract(self, q: numpy.typing.ArrayLike, delta: numpy.typing.ArrayLike) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """q ⊕ δ: the only way to move (n_q)"""

    def local(self, q0: numpy.typing.ArrayLike, q1: numpy.typing.ArrayLike) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """q1 ⊖ q0 (n_v)"""

    def object_pose(self, q: numpy.typing.ArrayLike, object: str) -> Pose:
        """X_WB of a named object"""

    def calc_kinematics(self, q: numpy.typing.ArrayLike) -> Kinematics: ...

    def body_poses(self, q: numpy.typing.ArrayLike) -> dict[str, Pose]:
        """X_WB by name of the body"""

    def __repr__(self) -> str: ...

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

class Residuals:
    @property
    def stationarity(self) -> float: ...

    @property
    def primal(self) -> float: ...

    @property
    def complementarity(self) -> float: ...

    @property
    def cone(self) -> float: ...

class StepResult:
    @property
    def status(self) -> Status: ...

    @property
    def q_next(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """(n_q)"""

    @property
    def delta(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """δq (n_v)"""

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

class Knot:
    """State after one sub-step."""

    @property
    def u(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]: ...

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]: ...

    @property
    def contacts(self) -> list[ContactImpulse]:
        """the active ones"""

class RolloutResult:
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

class Exact:
    """The contact dynamics themselves (2.6)."""

    def __init__(self) -> None: ...

class Analytic:
    """Smoothed by a log barrier of weight kappa [1/J] (2.27)."""

    def __init__(self, *, kappa: float = 100.0, self_sharpness: float = 10.0, limit_sharpness: float = 10.0) -> None: ...

    @property
    def kappa(self) -> float: ...

    @property
    def self_sharpness(self) -> float: ...

    @property
    def limit_sharpness(self) -> float: ...

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

class StepWorkspace:
    """Scratch and warm starts of steps; for one thread at a time."""

    def __init__(self, model: Model) -> None: ...

    def forget(self) -> None:
        """drops warm starts, so that the next step depends on its input alone"""

def step(model: Model, q: numpy.typing.ArrayLike, u: numpy.typing.ArrayLike, *, tau_ext: numpy.typing.ArrayLike | None = None, damping: numpy.typing.ArrayLike | None = None, with_A: bool = False, with_B: bool = False, with_force_derivatives: bool = False, warm_start: bool = True, workspace: StepWorkspace | None = None, h: float = 0.1, kappa: float | None = None, self_sharpness: float = 10.0, limit_sharpness: float = 10.0, epsilon: float | None = None, regularisation_ratio: float = 0.1, friction_scale: float = 1.0, rays: int | None = None, coulomb: bool = False, contact_margin: float = 0.0, joint_limits: bool = True, tol_complementarity: float = 1e-10) -> StepResult:
    """
    One quasi-static step from q with command u. Exact, or smoothed where kappa [1/J] is given; the objects are regularised by the rule of docs/theory/step.md or by epsilon; friction is a second-order cone or a pyramid of `rays`. Without a workspace every call makes one.
    """

def calc_local_model(model: Model, q: numpy.typing.ArrayLike, u: numpy.typing.ArrayLike, *, scheme: Exact | Analytic | RandomizedFirstOrder | RandomizedZerothOrder | None = None, tau_ext: numpy.typing.ArrayLike | None = None, damping: numpy.typing.ArrayLike | None = None, with_A: bool = False, threads: int = 1, h: float = 0.1, kappa: float | None = None, self_sharpness: float = 10.0, limit_sharpness: float = 10.0, epsilon: float | None = None, regularisation_ratio: float = 0.1, friction_scale: float = 1.0, rays: int | None = None, coulomb: bool = False, contact_margin: float = 0.0, joint_limits: bool = True, tol_complementarity: float = 1e-10) -> LocalModel:
    """
    Local model around (q, u) by one of the four schemes; without `scheme`, Exact or Analytic as kappa says.
    """

def rollout(model: Model, q: numpy.typing.ArrayLike, u_start: numpy.typing.ArrayLike, u_end: numpy.typing.ArrayLike, *, joint_angle: float = 0.03, joint_travel: float = 0.01, slide: float = 0.001, max_substeps: int = 400, workspace: StepWorkspace | None = None, h: float = 0.1, kappa: float | None = None, self_sharpness: float = 10.0, limit_sharpness: float = 10.0, epsilon: float | None = None, regularisation_ratio: float = 0.1, friction_scale: float = 1.0, rays: int | None = None, coulomb: bool = False, contact_margin: float = 0.0, joint_limits: bool = True, tol_complementarity: float = 1e-10) -> RolloutResult:
    """
    Moves the command from u_start to u_end in sub-steps small enough for the limits.
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
    def depth(self) -> float:
        """deepest penetration [m]"""

class SimulationResult:
    @property
    def status(self) -> Status: ...

    @property
    def message(self) -> str: ...

    @property
    def times(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """[s] (samples)"""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')]:
        """(n_q, samples)"""

    @property
    def v(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')]:
        """(n_v, samples)"""

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

class Plant:
    """
    A model as MuJoCo simulates it; contacts as docs/theory/simulation.md says.
    """

    def __init__(self, model: Model, *, timestep: float = 0.0002, damping_ratio: float = 1.0, armature: float = 0.0, spring_resolution: float = 1.0, time_constant: float = 0.002, friction_time_constant: float = 0.02, impedance: float = 0.95, friction_stiffening: float = 100.0, noslip_iterations: int = 0, friction_scale: float = 1.0, ground_softness: float = 2.5, velocity_reference: bool = False) -> None: ...

    @property
    def timestep(self) -> float:
        """[s]"""

    @property
    def damping(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """of the joint springs (n_a) [N s/m or N m s/rad]"""

    @property
    def armature(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """(n_a) [kg or kg m^2]"""

def simulate(plant: Plant, q0: numpy.typing.ArrayLike, times: numpy.typing.ArrayLike, u: numpy.typing.ArrayLike, *, v0: numpy.typing.ArrayLike | None = None, record_interval: float = 0.01, timeout_s: float | None = None) -> SimulationResult:
    """
    Second-order simulation of commands u (n_a, knots), linear between the knots at `times`, from q0 to the last knot.
    """

class Goal:
    @property
    def object(self) -> int:
        """index of the object"""

    @property
    def X_WG(self) -> Pose: ...

    @property
    def tol_position(self) -> float:
        """[m]"""

    @property
    def tol_angle(self) -> float:
        """[rad]"""

class GoalError:
    @property
    def position(self) -> float:
        """[m]"""

    @property
    def angle(self) -> float:
        """[rad]"""

class Task:
    """A scene, a start, a goal and how to plan."""

    @property
    def name(self) -> str: ...

    @property
    def description(self) -> str: ...

    @property
    def file(self) -> pathlib.Path: ...

    @property
    def model(self) -> Model: ...

    @property
    def q_start(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """(n_q)"""

    @property
    def goal(self) -> Goal: ...

    @property
    def scene_sha256(self) -> str: ...

    def set_goal(self, values: numpy.typing.ArrayLike) -> None:
        """
        x y z [m] roll pitch yaw [rad] of a free object, the coordinates of any other
        """

def list_tasks() -> list[str]:
    """Names of the built-in tasks."""

def load_task(name_or_file: str) -> Task:
    """A built-in task by its name, or a file."""

class Progress:
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

class TreeNode:
    @property
    def parent(self) -> int:
        """-1 of the root"""

    @property
    def edge(self) -> str:
        """that leads to it: settle, contact, regrasp"""

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

class PlanResult:
    @property
    def status(self) -> Status: ...

    @property
    def seed(self) -> int: ...

    @property
    def error(self) -> GoalError:
        """of the object at the last knot"""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')]:
        """configurations of the best path, the start first (n_q, knots + 1)"""

    @property
    def u(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')]:
        """commands (n_a, knots + 1)"""

    @property
    def iterations(self) -> int: ...

    @property
    def nodes(self) -> int: ...

    @property
    def steps(self) -> int: ...

    @property
    def failed_steps(self) -> int: ...

    @property
    def wall_s(self) -> float: ...

    @property
    def tree(self) -> list[TreeNode]:
        """its nodes, the root first, with `record_tree` in the task"""

    @property
    def tree_errors(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')]:
        """distances of the nodes in `tree` from the goal [m], [rad] (2, nodes)"""

    def packing_ratio(self, threshold: float = 3.0, samples: int = 1000, seed: int = 0) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        (3.9) after each node in `tree`, by the boxes and γ of the task (nodes)
        """

    def write(self, file: str | os.PathLike) -> None:
        """writes the plan file that `stiction check` and `stiction view` read"""

    def __repr__(self) -> str: ...

def plan(task: Task, *, seed: int | None = None, scheme: str | None = None, timeout_s: float = 20.0, threads: int = 0, on_progress: Callable[[Progress], None] | None = None) -> PlanResult:
    """
    Plans a path of the object to the goal. Ctrl-C and an error in on_progress stop it.
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

class IterationLog:
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

class OptimizeResult:
    @property
    def status(self) -> Status: ...

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')]:
        """configurations of the best trajectory (n_q, T + 1)"""

    @property
    def u(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')]:
        """commands (n_a, T)"""

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

def optimize(task: Task, *, scheme: str | None = None, solver: str | None = None, iterations: int | None = None, forces: bool = False, seed: int | None = None, timeout_s: float = 60.0, threads: int = 0, on_progress: Callable[[Progress], None] | None = None) -> OptimizeResult:
    """
    Optimises a trajectory by the section `optimize` of the task (iMPC). scheme: exact, analytic, randomized-first or randomized-zeroth; solver: sweep or receding; forces: with the contact trust region. Ctrl-C and an error in on_progress stop it.
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
        """None where the plan moves the object by less than 0.1 mm"""

    @property
    def normalised_angle(self) -> float | None: ...

class PieceReport:
    @property
    def kind(self) -> str:
        """'contact' or 'regrasp'"""

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

class TransferResult:
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
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')]:
        """simulated (n_q, samples)"""

    @property
    def q_plan(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='F')]:
        """planned (n_q, samples)"""

    @property
    def piece(self) -> list[int]:
        """index into pieces (samples)"""

    @property
    def wall_s(self) -> float: ...

def transfer(plan_file: str | os.PathLike, *, speed: float = 1.0, pause: float = 4.0, load_time: float = 0.5, regrasp_factor: float = 4.0, substeps: int | None = None, rest_time: float = 0.05, friction_scale: float = 1.0, velocity_reference: bool = True, hold: float = 4.0, whole: bool = True, alone: bool = True, threads: int = 0, timeout_s: float | None = None) -> TransferResult:
    """
    Runs a plan file open loop in the second-order simulation and compares it with the plan; `substeps` predicts every contact edge anew in so many steps first. `speed` multiplies 0.1 rad/s and 0.0125 m/s; joint springs take up or let go the weight of the lightest object in `load_time` [s], with 0 as fast as comes. Without `velocity_reference` damping acts on the velocities of the joints themselves, which lag behind their commands, as in the thesis.
    """
