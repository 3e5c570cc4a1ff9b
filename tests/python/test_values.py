"""Values in Python: their text, equality and hash, and what the calls say of arrays of another shape."""

from __future__ import annotations

import copy
import enum
import inspect
import pickle
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

MODULE = Path(__file__).resolve().parents[2] / "build" / "release" / "python"
if not (MODULE / "stiction").is_dir():
    pytest.skip(f"{MODULE} does not exist: run `make build`", allow_module_level=True)
sys.path.insert(0, str(MODULE))

import stiction as st  # noqa: E402


@pytest.fixture(scope="module")
def task() -> st.Task:
    return st.load_task("planar_pushing")


def classes() -> list[type]:
    return [value for value in vars(st._core).values() if inspect.isclass(value) and not issubclass(value, (enum.Enum, BaseException))]


def test_every_class_has_a_text_of_its_own() -> None:
    assert [cls.__name__ for cls in classes() if cls.__repr__ is object.__repr__] == []


def test_text_shows_the_fields_and_no_address(task: st.Task) -> None:
    model = task.model
    assert repr(task) == "<stiction.Task 'planar_pushing'>"
    assert repr(model.bodies[0]) == "<stiction.Body: name='box', kind=BodyKind.Object, dofs=[0, 1, 2]>"
    assert repr(task.goal) == "<stiction.Goal: object=0, X_WG=Pose(p=[0, 0, -0.5]), open=[], tol_position=0.02, tol_angle=0.1>"
    plan = st.plan(task, seed=0).plan
    for value in (model.scene, model.dofs[0], model.geometries[0], plan[0], st.make_trajectory(plan), st.Plant(model), st.BatchWorkspace(model, 1)):
        text = repr(value)
        assert text.startswith(f"<stiction.{type(value).__name__}") and " object at 0x" not in text and len(text) < 1000, text


def test_values_with_equal_fields_are_equal_and_have_one_hash(task: st.Task) -> None:
    pose, turned = st.Pose(np.eye(3), [1, 2, 0.0]), st.Pose([[0, -1, 0], [1, 0, 0], [0, 0, 1]], [1, 2, 0])
    assert pose == st.Pose(np.eye(3), [1, 2, -0.0]) and hash(pose) == hash(st.Pose(np.eye(3), [1, 2, -0.0]))
    assert pose != turned and pose != 3 and {pose: 1}[copy.copy(pose)] == 1
    assert st.Analytic(kappa=7) == st.Analytic(kappa=7) != st.Analytic(kappa=8)
    assert st.BaseWrench([1, 2, 3], [0, 0, 0]) == st.BaseWrench([1, 2, 3], [0, 0, 0])
    other = st.load_task("planar_pushing")
    assert task == other and hash(task) == hash(other) and task.model == other.model and hash(task.model) == hash(other.model)
    assert task != st.load_task("planar_hand") and task != task.with_(options={"goal_bias": 0.125})
    assert task.options == other.options and len({task.options, other.options}) == 1
    plan = st.plan(task, seed=0).plan
    assert plan == pickle.loads(pickle.dumps(plan)) and plan != plan[:1]


def test_minus_zero_equals_zero(task: st.Task) -> None:
    pairs = [
        (st.PlannerOptions(task.model, goal_bias=0.0), st.PlannerOptions(task.model, goal_bias=-0.0)),
        (st.BaseWrench([1, 2, 0.0], [0.0, 0, 0]), st.BaseWrench([1, 2, -0.0], [-0.0, 0, 0])),
    ]
    for zero, minus in pairs:
        assert zero == minus and hash(zero) == hash(minus) and len({zero, minus}) == 1, zero


def test_arrays_of_dataclasses_are_compared(tmp_path: Path) -> None:
    zeros = np.zeros((2, 1))
    log = st.JointStates(["a"], np.array([0.0, 1.0]), zeros, zeros * np.nan, zeros)
    assert log == copy.deepcopy(log) and log != st.JointStates(["a"], np.array([0.0, 2.0]), zeros, zeros, zeros)
    with pytest.raises(TypeError, match="unhashable"):
        hash(log)
    hand = st.load_task("planar_hand")
    grasps = st.find_grasps(hand, count=3, seed=0)
    assert grasps == st.read_grasps(grasps.write(tmp_path / "g.npz"), hand) and grasps != grasps[:2]


Call = Callable[[st.Task], Any]
SHAPES: dict[str, tuple[Call, str]] = {
    "step": (lambda t: st.step(t.model, t.q_start[None], t.q_start[3:]), r"^q: got an array of shape \(1, 5\), expected one dimension, a number each$"),
    "step, a number": (lambda t: st.step(t.model, t.q_start, 0.5), r"^u: got an array of shape \(\), expected one dimension"),
    "step_batch": (lambda t: st.step_batch(t.model, t.q_start, t.q_start[3:]), r"^q: got an array of shape \(5,\), expected two dimensions, a row each$"),
    "rollout_batch": (lambda t: st.rollout_batch(t.model, t.q_start[None], t.q_start[None, 3:]), r"^u: got an array of shape \(1, 2\), expected three dimensions"),
    "Pose": (lambda t: st.Pose(np.eye(3), np.zeros((3, 1))), r"^p: got an array of shape \(3, 1\)"),
    "with_": (lambda t: t.with_(goal=[[0, 0, 0]]), r"^goal: got an array of shape \(1, 3\)"),
    "plan": (lambda t: st.plan(t, q_start=t.q_start[None]), r"^q_start: got an array of shape \(1, 5\)"),
    "simulate": (lambda t: st.simulate(st.Plant(t.model), t.q_start, [0, 1], t.q_start[3:]), r"^u: got an array of shape \(2,\), expected two dimensions"),
    "Measurement": (lambda t: st.Measurement(0.0, t.q_start[None], t.q_start[3:]), r"^q: got an array of shape \(1, 5\)"),
    "calibrate": (lambda t: st.calibrate(t.model, t.q_start[3:], t.q_start[3:]), r"^q: got an array of shape \(2,\), expected two dimensions"),
    "retract": (lambda t: t.model.retract(t.q_start, np.zeros((5, 1))), r"^delta: got an array of shape \(5, 1\)"),
}


@pytest.mark.parametrize("name", SHAPES)
def test_array_of_other_dimensions_is_named(task: st.Task, name: str) -> None:
    call, message = SHAPES[name]
    with pytest.raises(st.InvalidInput, match=message):
        call(task)


def test_what_is_no_array_of_numbers_is_a_type_error(task: st.Task) -> None:
    for q in (None, "abc", ["a"], [1, [2, 3]], task.q_start * 1j, {}):
        with pytest.raises(TypeError):
            st.step(task.model, q, task.q_start[3:])


def test_gradient_of_another_rollout_is_named(task: st.Task) -> None:
    q, u = task.q_start[None], np.tile(task.q_start[3:], (1, 4, 1))
    rolled = st.rollout_batch(task.model, q, u)
    with pytest.raises(st.InvalidInput, match="^rolled: got 5 configurations a trajectory, expected 4, the start and one for each of the 3 commands of u$"):
        st.pull_back_rollout(task.model, rolled, u[:, :3], np.zeros_like(rolled.q))
    with pytest.raises(st.InvalidInput, match="^D_L_q: got 4 configurations a trajectory, expected 5"):
        st.pull_back_rollout(task.model, rolled, u, np.zeros_like(rolled.q)[:, 1:])


def test_threads_have_a_bound(task: st.Task) -> None:
    q = np.tile(task.q_start, (4, 1))
    for call in (
        lambda n: st.BatchWorkspace(task.model, threads=n),
        lambda n: st.step_batch(task.model, q, q[:, 3:], threads=n),
        lambda n: st.calc_local_model(task.model, q[0], q[0, 3:], threads=n),
    ):
        with pytest.raises(st.InvalidInput, match="^threads: got 1000000, expected"):
            call(1_000_000)


def test_unknown_option_is_told_those_of_today(task: st.Task) -> None:
    with pytest.raises(st.InvalidInput) as error:
        task.options.replace(goal_biass=0.2)
    text = str(error.value)
    assert text.startswith("goal_biass: got an unknown key, expected one of seed, threads, ") and text.endswith("did you mean 'goal_bias'?")
    assert "gamma" not in text and len(text) < 250


def test_text_of_a_plan_is_not_called_a_file() -> None:
    for text, message in (("[]", "^text: top level: got a list of 0"), ('{"format": ', "^text: file: got something that is not JSON")):
        with pytest.raises(st.InvalidInput, match=message):
            st.parse_plan(text)


def interrupted_after(call: Callable[[], object], seconds: float = 0.2) -> float:
    """Seconds after the signal until Ctrl-C ends the call."""

    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGVTALRM, stop)  # of processor time: the limit of a test uses the other timer
    try:
        signal.setitimer(signal.ITIMER_VIRTUAL, seconds)
        begin = time.process_time()
        with pytest.raises(KeyboardInterrupt):
            call()
        return time.process_time() - begin - seconds
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        signal.signal(signal.SIGVTALRM, before)


def test_ctrl_c_ends_long_calls() -> None:
    ball = st.load_task("allegro_ball")
    model, q, u = ball.model, ball.q_start, ball.q_start[7:]
    many, steps = np.tile(q, (50_000, 1)), np.tile(u, (2, 20_000, 1)) + 0.05 * np.sin(np.arange(20_000))[None, :, None]
    smooth = st.Analytic(kappa=100)
    scenario = st.load_sensing_scenario("ur5_forearm")
    rolled = st.rollout_batch(model, many[:2], steps[:, :500])
    long_rolled = np.zeros((2, 501, model.n_q))
    calls: dict[str, Callable[[], object]] = {
        "step_batch": lambda: st.step_batch(model, many, many[:, 7:], with_A=True, with_B=True, smoothing=smooth),
        "rollout_batch": lambda: st.rollout_batch(model, many[:2], steps, smoothing=smooth),
        "pull_back_rollout": lambda: [st.pull_back_rollout(model, rolled, steps[:, :500], long_rolled, smoothing=smooth) for _ in range(100)],
        "calc_local_model": lambda: st.calc_local_model(model, q, u, scheme=st.RandomizedFirstOrder(std_q=[0], std_u=[0.01], samples=20_000), with_A=True),
        "sense_series": lambda: scenario.sensor.sense_series(np.repeat(scenario.q, 100_000, 0), np.repeat(scenario.tau, 100_000, 0)),
    }
    for name, call in calls.items():
        assert interrupted_after(call) < 1.0, name
    task = st.load_task("planar_pushing")
    assert st.step_batch(task.model, task.q_start[None], task.q_start[None, 3:]).failed == 0  # and goes on afterwards


def test_ctrl_c_ends_a_check() -> None:
    plan = st.plan(st.load_task("allegro_ball"), seed=0).plan
    begin = time.process_time()
    assert st.check_plan(plan).pass_
    whole = time.process_time() - begin
    for _ in range(3):
        assert interrupted_after(lambda: st.check_plan(plan), 0.1 * whole) < 0.6 * whole, "at its end it would be 0.9"


def test_touched_rows_may_be_an_array() -> None:
    model = st.load_model({"robots": [{"name": "arm", "urdf": "package://example-robot-data/robots/ur_description/urdf/ur5_robot.urdf"}]})
    random = np.random.default_rng(0)
    q, tau = np.zeros((40, 6)), random.normal(size=(40, 6))
    touched = np.arange(40) >= 35
    plain = st.calibrate(model, q, tau, t=np.arange(40.0), touched=touched.tolist())
    assert st.calibrate(model, q, tau, t=np.arange(40.0), touched=touched) == plain
    for unmeasured in (["wrist"], [6]):
        with pytest.raises(st.InvalidInput, match="^unmeasured: "):
            st.calibrate(model, q, tau, unmeasured=unmeasured)
    with pytest.raises(st.InvalidInput, match="^t: got 3 numbers, expected 40"):
        st.calibrate(model, q, tau, t=[0, 1, 2])
