"""Values go through pickle and copy: every class that the module exports is a value, is shared, or says what to pass in its place."""

from __future__ import annotations

import copy
import enum
import inspect
import pickle
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
MODULE = ROOT / "build" / "release" / "python"
if not (MODULE / "stiction").is_dir():
    pytest.skip(f"{MODULE} does not exist: run `make build`", allow_module_level=True)
sys.path.insert(0, str(MODULE))

import stiction as st  # noqa: E402

VALUES = """
    Analytic BaseWrench Body ByRule Calibration Candidate CheckItem CheckReport ContactForce ContactImpulse ContactSet ContactSets ControlRunResult ControlSample ControlScenario
    ControllerCommand ControllerState CostTerms DetectabilityMap Discrimination Dof ErrorSets Exact Finding FixedEpsilon FeltContact ForceDampingOptions GaussNewton Geometry Goal
    GoalError Growth GuardedMoveResult GuardedResult Hysteresis IterationLog JointFriction Kinematics KnownContact Knot LocalModel Measurement ObjectInfo OptimizeResult Pair PairForce Payload PieceError PieceReport Plan
    PlacedLinks PlanContact PlanResult PlannerOptions PolyhedralCone Pose Posterior Progress RandomizedFirstOrder RandomizedZerothOrder RefineResult RefusedMoves RejectionSampling Residuals
    RobotLink RolloutBatch RolloutResult RunGoal RunPiece RunPlan RunResult RunSample Scene SecondOrderCone Segment SenseResult SensedLink SensingScenario SetContact SignCheck SimulationResult SolveResult
    SolveRun SolveTry SpeedLimits SteepestDescent StepBatch StepResult SurfaceOptions Task ToolReference TorqueNoise Touch TouchResult TouchRoute TouchScenario Trajectory
    TransferResult TreeNode TubeRest TubeResult Visual Visuals WorldError
""".split()
SHARED = ["Model", "Sensor"]  # immutable and large: pickle makes them anew, a copy is the object itself
AT_WORK = ["BatchWorkspace", "ContactController", "ControlLoop", "DrivenPlant", "Plant", "SimulatedPlant", "StepWorkspace", "TouchOnset"]


def exported_classes() -> dict[str, type]:
    return {name: value for name, value in vars(st).items() if inspect.isclass(value) and not name.startswith("_") and value.__module__ == "stiction._core"}


def test_every_exported_class_is_one_of_these() -> None:
    classes = exported_classes()
    enums = [name for name, value in classes.items() if issubclass(value, enum.Enum)]
    errors = [name for name, value in classes.items() if issubclass(value, Exception)]
    assert len(enums) > 10 and errors == ["InvalidInput"]
    assert sorted(classes) == sorted(VALUES + SHARED + AT_WORK + enums + errors)


def same(a: Any, b: Any, path: str = "value", depth: int = 0) -> None:
    """Everything that can be read of two values is equal, whatever the depth."""
    assert type(a) is type(b), path
    if isinstance(a, np.ndarray):
        np.testing.assert_array_equal(a, b, err_msg=path)
    elif isinstance(a, (list, tuple)):
        assert len(a) == len(b), path
        for i, (x, y) in enumerate(zip(a, b)):
            same(x, y, f"{path}[{i}]", depth)
    elif isinstance(a, dict):
        assert list(a) == list(b), path
        for key in a:
            same(a[key], b[key], f"{path}[{key!r}]", depth)
    elif isinstance(a, float):
        assert a == b or (np.isnan(a) and np.isnan(b)), f"{path}: {a} and {b}"
    elif isinstance(a, st.PlanContact):  # for display: the text of a plan has it to a millionth
        assert (a.a, a.b) == (b.a, b.b), path
        for name in ("point", "normal", "force", "friction", "gap"):
            np.testing.assert_allclose(getattr(a, name), getattr(b, name), rtol=0, atol=5.1e-7, err_msg=f"{path}.{name}")
    elif type(a).__name__ in VALUES + SHARED:
        assert depth < 12, path
        for name in dir(a):
            if name.startswith("_") or callable(getattr(type(a), name, None)):
                continue
            same(getattr(a, name), getattr(b, name), f"{path}.{name}", depth + 1)
    else:
        assert a == b, path


# ---- a value of every class


def task() -> Any:
    return st.load_task("planar_pushing")


def planned() -> Any:
    return st.plan(task(), seed=0, threads=1)


def stepped(**options: Any) -> Any:
    t = task()
    return st.step(t.model, t.q_start, t.q_start[3:] + [0.0, 0.1], **options)


def rolled() -> Any:
    t = task()
    return st.rollout(t.model, t.q_start, [0.0, 0.0], [0.0, 0.3], joint_travel=0.05)


def told(**functions: Any) -> list[Any]:
    heard: list[Any] = []
    st.plan(task(), seed=0, threads=1, **{name: heard.append for name in functions})
    return heard


def sensed() -> Any:
    return st.sense("ur5_forearm")[0]


def at_rest(**options: Any) -> Any:
    """Rest of an arm in a few postures, whose last link carries a kilogram that it does not know of."""
    model = st.load_sensing_scenario("ur5_forearm").sensor.model
    random = np.random.default_rng(0)
    q = np.repeat(random.uniform(-1, 1, (8, 6)), 3, axis=0)
    link = "arm/wrist_3_link"
    weights = [st.calc_contact_torque(model, row, link, [0, 0, 0.05], model.body_poses(row)[link].R.T @ [0, 0, -9.81]) for row in q]
    return st.calibrate(model, q, np.array(weights) + 0.01 * random.normal(size=q.shape), records=list(np.arange(24) // 3), **options)


def rubbed() -> Any:
    model = st.load_sensing_scenario("ur5_forearm").sensor.model
    t = np.linspace(0, 4, 401)
    q, qd = (0.2 * np.repeat(wave[:, None], 6, axis=1) for wave in (np.sin(3 * t), 3 * np.cos(3 * t)))
    return st.identify_friction(model, t, q, qd, qd)


def sets() -> Any:
    scenario = st.load_sensing_scenario("ur5_two_pushes")
    k = next(k for k in range(len(scenario.times)) if len(scenario.pushed[k]) == 2)
    return scenario.sense_contacts(scenario.q[k + 4], scenario.tau[k + 4])


def commanded() -> Any:
    model = st.load_control_scenario("box_in_the_way").model
    controller = st.ContactController(model, lambda_max=15.0)
    controller.configure(np.zeros(model.n_a))
    return controller.update(st.ControllerState(time=0.0, q=np.zeros(model.n_a), q_ref=np.full(model.n_a, 1e-4)), 0.005)


def simulated() -> Any:
    t = task()
    return st.simulate(st.Plant(t.model), t.q_start, [0.0, 0.5], [[0, 0], [0, 0.3]], record_interval=0.05)


def touched() -> Any:
    return st.touch("reach_past_pillar", seed=0)


def guarded() -> Any:
    text = yaml.safe_load((ROOT / "scenarios/lower_until_touch.yaml").read_text(encoding="utf-8"))
    return st.guarded_moves(st.load_touch_scenario(text | {"moves": text["moves"][:1]}, base=ROOT / "scenarios"), seed=1)


def controlled() -> Any:
    return st.control("box_in_the_way", timeout_s=60)


def first(values: Any) -> Any:
    assert len(values) > 0
    return values[0]


def seen() -> Any:
    urdf = """<robot name="r"><link name="base"><visual><geometry><box size="1 2 3"/></geometry></visual>
      <visual><geometry><mesh filename="cut_block.obj"/></geometry></visual></link></robot>"""
    return st.read_visuals(st.load_model({"robots": [{"name": "r", "urdf": urdf}]}, base=ROOT / "models"))


def last_sample() -> Any:
    samples: list[Any] = []
    st.run(task(), seed=0, duration=3, on_sample=samples.append)
    return samples[-1]


MAKE: dict[str, Callable[[], Any]] = {
    "Analytic": lambda: st.Analytic(kappa=7, self_sharpness=2),
    "BaseWrench": lambda: st.BaseWrench(force_W=[1, 2, 3], moment_W=[4, 5, 6]),
    "Body": lambda: task().model.bodies[1],
    "ByRule": lambda: st.ByRule(ratio=0.3),
    "Calibration": lambda: at_rest(payload="arm/wrist_3_link"),
    "JointFriction": rubbed,
    "Hysteresis": lambda: at_rest().hysteresis,
    "TorqueNoise": lambda: at_rest().calc_noise(),
    "Payload": lambda: at_rest(payload="arm/wrist_3_link").payload,
    "Posterior": lambda: sensed().posterior,
    "SignCheck": lambda: st.check_sign(st.load_sensing_scenario("ur5_forearm").sensor.model, np.zeros((1, 6)), np.zeros((1, 6))),
    "Candidate": lambda: first(sensed().candidates),
    "CheckItem": lambda: first(st.check_plan(planned().plan).items),
    "CheckReport": lambda: st.check_plan(planned().plan),
    "ContactForce": lambda: st.ContactForce(body="arm/link", p_WC=[1, 2, 3], force_W=[4, 5, 6], id=3, lambda_max=9.0),
    "ContactImpulse": lambda: first(stepped().contacts),
    "ContactSet": lambda: first(sets().sets),
    "ContactSets": sets,
    "ControlRunResult": controlled,
    "ControlSample": lambda: st.ControlLoop(st.load_control_scenario("box_in_the_way")).tick(),
    "ControlScenario": lambda: st.load_control_scenario("box_in_the_way"),
    "ControllerCommand": commanded,
    "ControllerState": lambda: st.ControllerState(time=1.0, q=[1.0], q_ref=[2.0], contacts=[MAKE["ContactForce"]()], tool=MAKE["ToolReference"]()),
    "CostTerms": lambda: MAKE["OptimizeResult"]().cost,
    "DetectabilityMap": lambda: (lambda s: s.calc_detectability(s.links[0].name, epsilon=0.05))(st.load_sensing_scenario("ur5_forearm").sensor),
    "Discrimination": lambda: sensed().discriminate(st.load_sensing_scenario("ur5_forearm").q[0]),
    "Dof": lambda: task().model.dofs[-1],
    "Exact": lambda: st.Exact(),
    "Finding": lambda: first(st.lint(task().with_(start=[0.0, 0.5, 0.0, 0.0, 0.3]))),
    "FixedEpsilon": lambda: st.FixedEpsilon(epsilon=0.5),
    "ForceDampingOptions": lambda: st.ForceDampingOptions(largest=3, printed=True),
    "GaussNewton": lambda: st.GaussNewton(max_steps=3),
    "Geometry": lambda: task().model.geometries[0],
    "Goal": lambda: task().goal,
    "GoalError": lambda: planned().plan.error,
    "Growth": lambda: first(told(on_growth=True)),
    "IterationLog": lambda: first(MAKE["OptimizeResult"]().history),
    "Kinematics": lambda: (lambda t: t.model.calc_kinematics(t.q_start))(task()),
    "KnownContact": lambda: st.load_sensing_scenario("ur5_forearm").contact,
    "Knot": lambda: rolled().knots[-1],
    "LocalModel": lambda: (lambda t: st.calc_local_model(t.model, t.q_start, t.q_start[3:], scheme=st.Analytic(kappa=100), with_A=True))(task()),
    "Measurement": lambda: st.Measurement(1.0, [1, 2], [3.0], 0.5),
    "ObjectInfo": lambda: task().model.objects[0],
    "OptimizeResult": lambda: st.optimize(st.load_task("impc_planar_pushing"), iterations=1),
    "Pair": lambda: task().model.pairs[0],
    "PairForce": lambda: first([force for moment in simulated().forces for force in moment]),
    "PieceError": lambda: first([piece.in_plan for piece in MAKE["TransferResult"]().pieces if piece.in_plan]),
    "PieceReport": lambda: first(MAKE["TransferResult"]().pieces),
    "Plan": lambda: planned().plan,
    "PlanContact": lambda: first([contact for contacts in planned().plan.contacts for contact in contacts]),
    "PlanResult": planned,
    "PlannerOptions": lambda: task().options.replace(goal_bias=0.125),
    "PolyhedralCone": lambda: st.PolyhedralCone(rays=7),
    "Pose": lambda: st.Pose([[0, -1, 0], [1, 0, 0], [0, 0, 1]], [1, 2, 3]),
    "Progress": lambda: first(told(on_progress=True)),
    "RandomizedFirstOrder": lambda: st.RandomizedFirstOrder(std_q=[1.0], std_u=[2.0], samples=3, seed=4),
    "RandomizedZerothOrder": lambda: st.RandomizedZerothOrder(std_q=[1.0], std_u=[2.0], samples=3, seed=4),
    "RefineResult": lambda: st.refine(planned().plan),
    "RefusedMoves": lambda: first(st.plan(st.load_task("iiwa_bimanual_planar"), seed=0, options={"max_iterations": 400, "tolerance_fraction": 0.001}).refused),
    "RejectionSampling": lambda: st.RejectionSampling(),
    "Residuals": lambda: stepped().residuals,
    "RobotLink": lambda: first(task().model.links),
    "RolloutResult": rolled,
    "RunGoal": lambda: first(MAKE["RunResult"]().goals),
    "RunPiece": lambda: first(MAKE["RunResult"]().pieces),
    "RunPlan": lambda: first(MAKE["RunResult"]().plans),
    "RunResult": lambda: st.run(task(), seed=0, duration=3),
    "RunSample": last_sample,
    "Scene": lambda: task().model.scene,
    "SecondOrderCone": lambda: st.SecondOrderCone(),
    "Segment": lambda: planned().plan[0],
    "SenseResult": sensed,
    "SensedLink": lambda: first(st.load_sensing_scenario("ur5_forearm").sensor.links),
    "SensingScenario": lambda: st.load_sensing_scenario("ur5_forearm"),
    "SetContact": lambda: first(first(sets().sets).contacts),
    "SimulationResult": simulated,
    "SolveResult": lambda: st.solve(task(), seed=0, tries=1, speed=20.0),
    "PlacedLinks": lambda: st.place_links(task().model, task().q_start, {}),
    "Visual": lambda: first(MAKE["Visuals"]().visuals),
    "Visuals": seen,
    "SolveRun": lambda: first(MAKE["SolveTry"]().runs),
    "SolveTry": lambda: MAKE["SolveResult"]().best,
    "SpeedLimits": lambda: st.SpeedLimits(revolute=0.3, pause=2),
    "SteepestDescent": lambda: st.SteepestDescent(max_steps=3),
    "StepBatch": lambda: (lambda t: st.step_batch(t.model, np.tile(t.q_start, (3, 1)), np.tile(t.q_start[3:], (3, 1)), with_A=True))(task()),
    "RolloutBatch": lambda: (lambda t: st.rollout_batch(t.model, t.q_start[None], np.tile(t.q_start[3:], (1, 4, 1))))(task()),
    "FeltContact": lambda: first(guarded().moves[0].felt),
    "GuardedMoveResult": lambda: first(guarded().moves),
    "GuardedResult": guarded,
    "StepResult": lambda: stepped(smoothing=st.Analytic(kappa=100), with_A=True, with_B=True, with_force_derivatives=True),
    "SurfaceOptions": lambda: st.SurfaceOptions(segments=9),
    "Task": lambda: task().with_(options={"goal_bias": 0.3}),
    "ToolReference": lambda: st.ToolReference(body="arm/link", X_BT=MAKE["Pose"](), X_WT=MAKE["Pose"]()),
    "Touch": lambda: first(touched().touches),
    "TouchResult": touched,
    "TouchRoute": lambda: first(touched().routes),
    "TouchScenario": lambda: st.load_touch_scenario("reach_past_pillar"),
    "Trajectory": lambda: st.make_trajectory(planned().plan),
    "ErrorSets": lambda: st.ErrorSets(friction=0.2),
    "WorldError": lambda: st.draw_world(planned().plan, index=3),
    "TubeResult": lambda: st.calc_tube(planned().plan, scenarios=2),
    "TubeRest": lambda: MAKE["TubeResult"]().rests[0],
    "TransferResult": lambda: st.transfer(planned().plan, speed=20.0, hold=0.2, alone=True),
    "TreeNode": lambda: st.plan(task(), seed=0, options={"max_iterations": 30, "thesis": {"stop_at_goal": False}}).tree[-1],
}


@pytest.mark.parametrize("name", VALUES)
def test_value_goes_through_pickle_and_copy(name: str) -> None:
    value = MAKE[name]()
    assert type(value).__name__ == name
    for again in (pickle.loads(pickle.dumps(value)), copy.deepcopy(value), copy.copy(value)):
        assert again is not value
        same(value, again)
        assert repr(again) == repr(value) and " object at 0x" not in repr(value)
        assert again == value and hash(again) == hash(value)


@pytest.mark.parametrize("name", [name for name, value in exported_classes().items() if issubclass(value, enum.Enum)])
def test_choice_goes_through_pickle_and_copy(name: str) -> None:
    for choice in getattr(st, name):
        assert pickle.loads(pickle.dumps(choice)) is choice and copy.deepcopy(choice) is choice


def test_model_is_made_anew_by_pickle_and_shared_by_copies() -> None:
    model = st.load_task("allegro_cube").model
    assert copy.copy(model) is model and copy.deepcopy(model) is model
    again = pickle.loads(pickle.dumps(model))
    assert again is not model and again.joint_names == model.joint_names and again.n_v == model.n_v
    np.testing.assert_array_equal(again.stiffness, model.stiffness)
    t = st.load_task("planar_pushing")
    results = pickle.loads(pickle.dumps([t, t.options, st.step(t.model, t.q_start, t.q_start[3:]).contacts]))
    assert results[0].model is not t.model
    st.plan(results[0], options=results[1], seed=0, timeout_s=20)  # one model, so that options fit the task


def test_sensor_is_written_once_for_all_results() -> None:
    scenario = st.load_sensing_scenario("ur5_two_pushes")
    results = [scenario.sense(scenario.q[k], scenario.tau[k]) for k in range(5)]
    one, all_five = len(pickle.dumps(results[:1])), len(pickle.dumps(results))
    assert all_five < 5 * one
    again = pickle.loads(pickle.dumps((scenario.sensor, results)))
    assert copy.deepcopy(scenario.sensor) is scenario.sensor
    assert [link.name for link in again[0].links] == [link.name for link in scenario.sensor.links]
    for a, b in zip(scenario.sensor.links, again[0].links):
        np.testing.assert_array_equal(a.p_L, b.p_L)
    again[0].sense(scenario.q[5], scenario.tau[5], again[1][4])  # a result of this sensor, as before


@pytest.mark.parametrize(
    ("make", "instead"),
    [
        (lambda: st.StepWorkspace(task().model), "a workspace made from the model"),
        (lambda: st.BatchWorkspace(task().model, 1), "a workspace made from the model"),
        (lambda: st.Plant(task().model), "the model and the options"),
        (lambda: st.DrivenPlant(st.Plant(task().model, damping_ratio=0)), "the model and the options"),
        (lambda: st.SimulatedPlant(task()), "the task"),
        (lambda: st.ContactController(st.load_control_scenario("box_in_the_way").model, lambda_max=1.0), "the model and the options"),
        (lambda: st.ControlLoop(st.load_control_scenario("box_in_the_way")), "the scenario"),
        (lambda: st.TouchOnset([0.0], [0.1], false_alarms=0.01), "the rest and the options"),
    ],
    ids=["StepWorkspace", "BatchWorkspace", "Plant", "DrivenPlant", "SimulatedPlant", "ContactController", "ControlLoop", "TouchOnset"],
)
def test_what_is_at_work_names_what_to_pass_instead(make: Callable[[], Any], instead: str) -> None:
    value = make()
    assert type(value).__name__ in AT_WORK
    for call in (pickle.dumps, copy.copy, copy.deepcopy):
        with pytest.raises(TypeError, match=f"^{type(value).__name__}: got pickle or copy, expected {instead}"):
            call(value)


def test_pickle_of_another_version_is_refused() -> None:
    pose = st.Pose(np.eye(3), [1, 2, 3])
    version, data, objects = pose.__getstate__()
    for state, message in (
        (("0.0.1", data, objects), f"a value of stiction 0.0.1, expected one of this version, {st.version()}"),
        ((version, data[:-1], objects), "a state that is cut off"),
        ((version,), "another state"),
    ):
        with pytest.raises(st.InvalidInput, match=message):
            st.Pose.__new__(st.Pose).__setstate__(state)
