"""Robot motion through contact."""

from collections.abc import Callable, Sequence
import enum
import os
import pathlib
from typing import Annotated, overload

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
        """R: a rotation (3, 3); p [m] (3)"""

    @property
    def R(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3, 3), order='F')]:
        """rotation (3, 3)"""

    @property
    def p(self) -> Annotated[NDArray[numpy.float64], dict(shape=(3), order='C')]:
        """position [m] (3)"""

    def __matmul__(self, arg: Pose, /) -> Pose: ...

    def inverse(self) -> Pose: ...

    def __repr__(self) -> str: ...

class BodyKind(enum.Enum):
    Fixed = 0

    Object = 1

    Robot = 2

class DofKind(enum.Enum):
    Prismatic = 0

    Revolute = 1

class Body:
    @property
    def name(self) -> str: ...

    @property
    def kind(self) -> BodyKind: ...

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

@overload
def load_scene(file: str | os.PathLike) -> Scene:
    """
    The scene of a file (YAML, also of a task). Raises InvalidInput: "FILE:LINE: field: got …".
    """

@overload
def load_scene(scene: dict, *, base: str | os.PathLike | None = None) -> Scene:
    """
    The scene of a dict, with the keys of a file. base: the folder that paths in it are relative to; None: the working folder. Raises InvalidInput: "field: got …, expected …".
    """

@overload
def load_model(file: str | os.PathLike) -> Model:
    """Model.make(load_scene(file))."""

@overload
def load_model(scene: dict, *, base: str | os.PathLike | None = None) -> Model:
    """Model.make(load_scene(scene, base=base))."""

class Model:
    """
    Immutable kinematics, actuation, geometry and friction of a scene, shared by threads.
    """

    @staticmethod
    def make(scene: Scene) -> Model: ...

    def __reduce__(self) -> object: ...

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
    def torque(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """of the springs (n_a), within Model.effort with effort_limits [N m, N]"""

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

    def __repr__(self) -> str: ...

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

class ByRule:
    """
    Regularisation of the objects in units of the springs, > 0 (docs/theory/step.md).
    """

    def __init__(self, *, ratio: float = 0.1) -> None: ...

    @property
    def ratio(self) -> float: ...

    def __repr__(self) -> str: ...

class FixedEpsilon:
    """Regularisation of the objects, 1 for their true mass, > 0 (2.6c)."""

    def __init__(self, *, epsilon: float = 1.0) -> None: ...

    @property
    def epsilon(self) -> float: ...

    def __repr__(self) -> str: ...

class SecondOrderCone:
    """Friction of spatial models; planar ones have two rays, which is exact."""

    def __init__(self) -> None: ...

    def __repr__(self) -> str: ...

class PolyhedralCone:
    """A pyramid of rays inside the friction cone, in [3, 64]."""

    def __init__(self, *, rays: int = 4) -> None: ...

    @property
    def rays(self) -> int: ...

    def __repr__(self) -> str: ...

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

def step(model: Model, q: numpy.typing.ArrayLike, u: numpy.typing.ArrayLike, *, tau_ext: numpy.typing.ArrayLike | None = None, damping: numpy.typing.ArrayLike | None = None, with_A: bool = False, with_B: bool = False, with_force_derivatives: bool = False, warm_start: bool = True, workspace: StepWorkspace | None = None, h: float = 0.1, smoothing: Exact | Analytic = ..., regularisation: ByRule | FixedEpsilon = ..., friction_cone: SecondOrderCone | PolyhedralCone = ..., friction_law: FrictionLaw = FrictionLaw.Anitescu, friction_scale: float = 1.0, contact_margin: float = 0.0, joint_limits: bool = True, effort_limits: bool = False, tol_complementarity: float = 1e-10) -> StepResult:
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

    Raises InvalidInput by the name of the argument.
    """

def calc_local_model(model: Model, q: numpy.typing.ArrayLike, u: numpy.typing.ArrayLike, *, scheme: Exact | Analytic | RandomizedFirstOrder | RandomizedZerothOrder | None = None, tau_ext: numpy.typing.ArrayLike | None = None, damping: numpy.typing.ArrayLike | None = None, with_A: bool = False, threads: int = 1, h: float = 0.1, smoothing: Exact | Analytic = ..., regularisation: ByRule | FixedEpsilon = ..., friction_cone: SecondOrderCone | PolyhedralCone = ..., friction_law: FrictionLaw = FrictionLaw.Anitescu, friction_scale: float = 1.0, contact_margin: float = 0.0, joint_limits: bool = True, effort_limits: bool = False, tol_complementarity: float = 1e-10) -> LocalModel:
    """
    Local model q_next(q + dq, u + du) ~ c + (A dq + B du) around q (n_q) and u (n_a) [m or rad], in tangent coordinates (2.4.1).

      scheme: Exact, Analytic, RandomizedFirstOrder or RandomizedZerothOrder; None: smoothing.
      tau_ext, damping: as in step() (n_v).
      with_A: LocalModel.A as well as B.
      threads: of randomised schemes; the result does not depend on it.

    status: Solved; that of the step that failed. Samples that fail are left out and counted.

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

    Raises InvalidInput by the name of the argument.
    """

def rollout(model: Model, q: numpy.typing.ArrayLike, u_start: numpy.typing.ArrayLike, u_end: numpy.typing.ArrayLike, *, joint_angle: float = 0.03, joint_travel: float = 0.01, slide: float = 0.001, max_substeps: int = 400, workspace: StepWorkspace | None = None, h: float = 0.1, smoothing: Exact | Analytic = ..., regularisation: ByRule | FixedEpsilon = ..., friction_cone: SecondOrderCone | PolyhedralCone = ..., friction_law: FrictionLaw = FrictionLaw.Anitescu, friction_scale: float = 1.0, contact_margin: float = 0.0, joint_limits: bool = True, effort_limits: bool = False, tol_complementarity: float = 1e-10) -> RolloutResult:
    """
    Moves the command from u_start to u_end (n_a) [m or rad] in exact sub-steps from q (n_q).

      joint_angle [rad], joint_travel [m]: no joint is commanded farther than this in a sub-step.
      slide: no contact slides farther than this in a sub-step, where max_substeps allows it [m].
      max_substeps: at most so many.
      workspace: scratch, of one thread at a time; None: one for this call.

    status: Solved; that of the sub-step that failed, and the knots before it.

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
    def q(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """(samples, n_q)"""

    @property
    def v(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """(samples, n_v) [m/s, rad/s]"""

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

    Raises InvalidInput by the name of the argument.
    """

    def __init__(self, model: Model, *, timestep: float = 0.0002, damping_ratio: float = 1.0, armature: float = 0.0, spring_resolution: float = 1.0, time_constant: float = 0.002, friction_time_constant: float = 0.02, impedance: float = 0.95, friction_stiffening: float = 100.0, noslip_iterations: int = 0, friction_scale: float = 1.0, ground_softness: float = 2.5, velocity_reference: bool = False, effort_limits: bool = False) -> None: ...

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
    Second-order simulation, from q0 to the last knot.

      q0: configuration (n_q).
      times: of the knots, increasing from 0 (knots) [s].
      u: commanded joint positions, linear between knots (knots, n_a) [m or rad].
      v0: velocity in tangent coordinates (n_v) [m/s, rad/s]; None: at rest.
      record_interval: of the samples [s], > 0.
      timeout_s: [s] > 0; None: as long as it takes.

    status: Solved; MaxIterations (time used up); NumericalFailure (`message`). Raises InvalidInput.
    """

class PlannerOptions:
    """
    Options of the planner. Each has the name and the value that it has in the section `planner` of a task file (tasks/schema/task.schema.json); dir() lists them.
    """

    def __init__(self, model: Model, **values) -> None:
        """
        Defaults, and what differs from them. Raises InvalidInput: unknown names, values that cannot be.
        """

    def replace(self, **changes) -> PlannerOptions:
        """
        These options with others; each one is replaced as a whole, None stands for its default. Raises InvalidInput.
        """

    def to_dict(self) -> dict[str, object]:
        """every option by its name"""

    def __getattr__(self, arg: str, /) -> object: ...

    def __dir__(self) -> list: ...

    def __eq__(self, arg: PlannerOptions, /) -> bool: ...

    def __repr__(self) -> str: ...

def planner_schema() -> dict[str, object]:
    """
    JSON schema of the section `planner` of a task file: every option with what it is, its unit and its range.
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

    def __repr__(self) -> str: ...

class Task:
    """A scene, a start, a goal and how to plan."""

    def __init__(self, task: dict, *, base: str | os.PathLike | None = None) -> None:
        """
        A task made in memory: a dict with the keys of a task file (tasks/schema/task.schema.json). Arrays, poses and paths may stand in it. base: the folder that paths in it are relative to; None: the working folder. Raises InvalidInput: "field: got …, expected …".
        """

    @property
    def name(self) -> str: ...

    @property
    def description(self) -> str: ...

    @property
    def file(self) -> pathlib.Path:
        """of a task made in memory the folder that its paths are relative to"""

    @property
    def model(self) -> Model: ...

    @property
    def q_start(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """(n_q)"""

    @property
    def goal(self) -> Goal: ...

    @property
    def options(self) -> PlannerOptions:
        """of its section `planner`"""

    @property
    def scene_sha256(self) -> str: ...

    def set_goal(self, values: numpy.typing.ArrayLike) -> None:
        """
        x y z [m] roll pitch yaw [rad] of a free object, the coordinates of any other. Raises InvalidInput.
        """

def list_tasks() -> list[str]:
    """Names of the built-in tasks."""

def load_task(name_or_file: str | str | os.PathLike) -> Task:
    """
    A built-in task by its name, or a file: a str that ends in .yaml or .yml or has a '/', or any os.PathLike. Raises InvalidInput: "FILE:LINE: field: got …, expected …".
    """

class SegmentKind(enum.Enum):
    Settle = 0
    """from the given start to rest on the constraints (first segment only)"""

    Contact = 1
    """the robot pushes"""

    Regrasp = 2
    """the robot moves to new contacts while the object rests"""

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

class Plan:
    """
    Commands and predicted configurations from the start to (near) the goal, with the task. Can be pickled.
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
    """

def parse_plan(text: str, folder: str | os.PathLike | None = None) -> Plan:
    """
    A plan from the text of its file. folder: in which the text stands, None: the working folder. Raises InvalidInput.
    """

class RefineResult:
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
    def steps(self) -> int: ...

    @property
    def failed_steps(self) -> int: ...

    @property
    def wall_s(self) -> float: ...

    def __repr__(self) -> str: ...

def refine(plan: Plan, *, options: PlannerOptions | dict | None = None, threads: int | None = None, timeout_s: float = 20.0, on_progress: Callable[[Progress], None] | None = None) -> RefineResult:
    """
    Makes a plan shorter and its regrasps wider (docs/theory/refinement.md).

    plan: one that is Solved. options: PlannerOptions, or a dict of those that differ; None: those that the plan was made with. threads: 0 for all cores; the result does not depend on them. timeout_s: [s] > 0.

    status: Solved; MaxIterations (time used up) and Cancelled: refined at its own steps, or the given plan; NumericalFailure: the given plan does not reach its goal. Raises InvalidInput.
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

class CheckReport:
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

def check_plan(plan: Plan) -> CheckReport:
    """
    Simulates a plan anew with the exact dynamics at half the sub-step, and compares every number in it with what comes out and with its task. The check shares nothing with the planner.
    """

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
    def duration(self) -> float:
        """[s]"""

def make_trajectory(plan: Plan, *, speed: float = 1.0, pause: float = 4.0, load_time: float = 0.5, regrasp_factor: float = 4.0) -> Trajectory:
    """
    Times of the commands of a plan (E.1). speed multiplies 0.1 rad/s and 0.0125 m/s; regrasps are regrasp_factor times as fast; commands rest for pause [s] between pieces; joint springs take up or let go the weight of the lightest object in load_time [s]. Raises InvalidInput.
    """

class PlanResult:
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
    def wall_s(self) -> float: ...

    @property
    def tree(self) -> list[TreeNode]:
        """its nodes, the root first, with the option record_tree"""

    @property
    def tree_errors(self) -> Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C')]:
        """distances of the nodes in `tree` from the goal [m], [rad] (nodes, 2)"""

    def packing_ratio(self, threshold: float = 3.0, samples: int = 1000, seed: int = 0) -> Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C')]:
        """
        (3.9) after each node in `tree`, by the boxes and γ of the task (nodes)
        """

    def __repr__(self) -> str: ...

def plan(task: Task, *, options: PlannerOptions | dict | None = None, seed: int | None = None, threads: int | None = None, timeout_s: float = 20.0, on_progress: Callable[[Progress], None] | None = None) -> PlanResult:
    """
    Plans a path of the object to the goal (Algorithms 2 and 3).

    options: PlannerOptions, or a dict of those that differ from the task's; None: the task's. seed, threads (0: all cores): None: those of the options; the plan does not depend on threads. timeout_s: [s] > 0. on_progress: called with Progress; Ctrl-C and an error in it stop the search.

    status: Solved; MaxIterations (time or budget used up, or `reason`); Cancelled; NumericalFailure (the objects do not come to rest at the start). Raises InvalidInput.
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

def optimize(task: Task, *, scheme: str | None = None, solver: str | None = None, iterations: int | None = None, forces: bool = False, seed: int | None = None, timeout_s: float = 60.0, threads: int = 0, on_progress: Callable[[Progress], None] | None = None) -> OptimizeResult:
    """
    Optimises a trajectory by the section `optimize` of the task (iMPC, Alg. 1).

      scheme: exact, analytic, randomized-first or randomized-zeroth; solver: sweep or receding; iterations: at most; None: as the task says.
      forces: with the contact trust region.
      seed: of the randomised schemes.
      timeout_s: [s] > 0.
      threads: 0 for all cores; the result does not depend on it.
      on_progress: called with Progress; Ctrl-C and an error in it stop the run.

    status: Solved; MaxIterations (time used up) and Cancelled: the best trajectory so far. Raises InvalidInput.
    """

class Finding:
    """Something in a task that is hardly what was meant."""

    @property
    def kind(self) -> str: ...

    @property
    def message(self) -> str:
        """field or body, what was found, what was likely meant"""

    def __repr__(self) -> str: ...

def lint(task: Task) -> list[Finding]:
    """
    Looks at a task without planning it: overlaps, objects that nothing supports, goals that nothing reaches, units that look wrong.
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

class SolveResult:
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

def solve(task: Task, *, options: PlannerOptions | dict | None = None, seed: int | None = None, tries: int = 20, friction: Sequence[float] = [1.0], speed: float = 1.0, threads: int = 0, timeout_s: float = 120.0, on_progress: Callable[[Progress], None] | None = None) -> SolveResult:
    """
    Plans, refines, checks and simulates seeds until one reaches its goal in the second-order simulation.

      options: of the planner: PlannerOptions, or a dict of those that differ from the task's; None: the task's.
      seed: of the first try, the next ones count up; None: that of the options. tries: at most, >= 1.
      friction: the goal has to be reached with every coefficient of friction times each of these, >= 0.
      speed: times 0.1 rad/s and 0.0125 m/s, > 0.
      threads: 0 for all cores; the result does not depend on it. timeout_s: of all tries [s], > 0.
      on_progress: called with Progress; Ctrl-C and an error in it stop the run.

    status: Solved: best.holds; MaxIterations: no try holds, or time used up; Cancelled. Raises InvalidInput.
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

def transfer(plan: Plan, *, speed: float = 1.0, pause: float = 4.0, load_time: float = 0.5, regrasp_factor: float = 4.0, substeps: int | None = None, rest_time: float = 0.05, friction_scale: float = 1.0, velocity_reference: bool = True, hold: float = 4.0, whole: bool = True, alone: bool = True, threads: int = 0, timeout_s: float | None = None) -> TransferResult:
    """
    Runs a plan open loop in the second-order simulation and compares it with what the plan predicts (3.10)-(3.12).

      speed: times 0.1 rad/s and 0.0125 m/s, > 0; regrasps are regrasp_factor times as fast.
      pause: commands rest this long between pieces [s], >= 0.
      load_time: joint springs take up or let go the weight of the lightest object in this time [s]; 0: as fast as comes.
      substeps: every contact edge is predicted anew in so many steps first; None: as the plan does.
      rest_time: in which objects on joints come to rest [s].
      friction_scale: factor of every coefficient of friction, >= 0.
      velocity_reference: damping of the joint springs acts on the difference to the commanded velocity; else on the velocity, so that
        joints lag behind their commands, as in the thesis.
      hold: the last command is held so long before the goal is judged [s].
      whole: run the whole plan. alone: run every push by itself from its planned start.
      threads: for those; 0 for all cores; the result does not depend on it.
      timeout_s: [s] > 0; None: as long as it takes.

    status: Solved: run to the end, whatever came out; MaxIterations (time used up); NumericalFailure (`message`). Raises InvalidInput.
    """
