"""Control from Python: closed forms of one joint, bounded forces, ticks that are held, scenarios, mistakes."""

from __future__ import annotations

import json
import math
import re
import signal
import sys
from pathlib import Path

import children
import numpy as np
import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
MODULE = ROOT / "build" / "release" / "python"
if not (MODULE / "stiction").is_dir():
    pytest.skip(f"{MODULE} does not exist: run `make build`", allow_module_level=True)
sys.path.insert(0, str(MODULE))

import stiction as st  # noqa: E402

DT = 0.005  # [s]
STIFFNESS = 1000.0  # [N/m]
CART = """<robot name="cart"><link name="base"/><link name="ball">
<inertial><mass value="1"/><inertia ixx="0.004" iyy="0.004" izz="0.004" ixy="0" ixz="0" iyz="0"/></inertial>
<collision name="ball"><geometry><sphere radius="0.1"/></geometry></collision></link>
<joint name="x" type="prismatic"><parent link="base"/><child link="ball"/><axis xyz="1 0 0"/>
<limit lower="-1" upper="1" effort="1000" velocity="1"/></joint></robot>"""
BALL = "cart/ball"


@pytest.fixture(scope="module")
def cart(tmp_path_factory: pytest.TempPathFactory) -> st.Model:
    folder = tmp_path_factory.mktemp("cart")
    (folder / "cart.urdf").write_text(CART)
    return st.load_model({"robots": [{"name": "cart", "urdf": "cart.urdf", "stiffness": STIFFNESS}]}, base=folder)


def make(model: st.Model, **options: object) -> st.ContactController:
    still = st.ForceDampingOptions(largest=0)
    return st.ContactController(model, **{"damping": still, "force_time_constant": 0, "prismatic_speed": 1e3, **options})


def against_wall(force: float, lambda_max: float | None = None) -> st.ContactForce:
    """The wall pushes the ball back."""
    return st.ContactForce(body=BALL, p_WC=[0.1, 0, 0], force_W=[-force, 0, 0], lambda_max=lambda_max)


# ---- values


def test_without_contact_the_command_is_the_reference(cart: st.Model) -> None:
    controller = make(cart)
    controller.configure([0.0])
    command = controller.update(st.ControllerState(time=0, q=[0.0], q_ref=[0.3]), DT)
    assert command.status == st.Status.Solved and command.q_cmd == pytest.approx([0.3], abs=1e-12)
    assert command.taken == [] and command.lambda_.shape == (0,) and not command.held


def test_command_moves_no_faster_than_its_speed(cart: st.Model) -> None:
    controller = make(cart, prismatic_speed=0.2)
    controller.configure([0.0])
    for tick in range(3):
        command = controller.update(st.ControllerState(time=tick * DT, q=[0.0], q_ref=[0.5]), DT)
        assert command.q_cmd == pytest.approx([(tick + 1) * 0.2 * DT], rel=1e-12)


@pytest.mark.parametrize("bound", [5.0, 20.0, 60.0])
def test_spring_presses_with_the_bound_at_most(cart: st.Model, bound: float) -> None:
    """One contact that stands still: its force is K (q_cmd - q), and the command the reference or where that force is the bound."""
    controller = make(cart, lambda_max=bound, force_threshold=1)
    controller.configure([0.004])
    command = controller.update(st.ControllerState(time=0, q=[0.0], q_ref=[0.04], contacts=[against_wall(4)]), DT)
    wanted = min(0.04, bound / STIFFNESS)
    # Contacts are softer than rigid by contact_compliance, which the bound may use.
    assert command.q_cmd[0] == pytest.approx(wanted, rel=0.02)
    # Of what tracking alone would break, 1/(1 + force_priority) is left.
    assert command.slack[0] == pytest.approx(max(0.0, command.lambda_[0] - bound), abs=1e-9)
    assert command.slack[0] <= max(0.0, 0.04 * STIFFNESS - bound) / 1e6 + 1e-9
    assert command.q_next == pytest.approx([0.0], abs=0.02 * wanted)


def test_own_bound_of_a_contact_goes_before_that_of_the_controller(cart: st.Model) -> None:
    commands = []
    for own in (None, 5.0):
        controller = make(cart, lambda_max=30, force_threshold=1)
        controller.configure([0.004])
        contacts = [against_wall(4, own)]
        commands.append(controller.update(st.ControllerState(time=0, q=[0.0], q_ref=[0.1], contacts=contacts), DT))
    assert commands[0].lambda_ == pytest.approx([30], abs=100e-6) and commands[1].lambda_ == pytest.approx([5], abs=100e-6)  # of 100 N, 1e-6 is left
    assert commands[1].taken[0].lambda_max == 5.0 and commands[1].taken[0].body == BALL


def test_baseline_tracks_whatever_the_force(cart: st.Model) -> None:
    controller = make(cart, law=st.Law.Unconstrained)
    controller.configure([0.0])
    command = controller.update(st.ControllerState(time=0, q=[0.0], q_ref=[0.5], contacts=[against_wall(10)]), DT)
    assert command.q_cmd == pytest.approx([0.5]) and command.lambda_ is None and command.q_next is None


def test_tool_is_led_to_its_place() -> None:
    scenario = st.load_control_scenario("box_in_the_way")
    model, q = scenario.model, np.array(scenario.start)
    controller = make(model, posture_weight=1e-6, revolute_speed=1e3)
    controller.configure(q)
    X_WT = model.body_poses(q)[scenario.tool] @ scenario.X_BT
    wanted = st.Pose(X_WT.R, X_WT.p + [0.0, 0.02, -0.01])
    for tick in range(10):  # free: a robot goes where it is commanded
        tool = st.ToolReference(body=scenario.tool, X_BT=scenario.X_BT, X_WT=wanted)
        q = controller.update(st.ControllerState(time=tick * DT, q=q, q_ref=scenario.start, tool=tool), DT).q_cmd
    reached = model.body_poses(q)[scenario.tool] @ scenario.X_BT
    assert np.linalg.norm(reached.p - wanted.p) < 1e-4 and np.allclose(reached.R, wanted.R, atol=1e-3)


def test_old_measurement_changes_nothing_and_configure_starts_anew(cart: st.Model) -> None:
    controller = make(cart)
    controller.configure([0.0])
    first = controller.update(st.ControllerState(time=1, q=[0.0], q_ref=[0.3]), DT)
    for time in (1, 0.5):
        again = controller.update(st.ControllerState(time=time, q=[0.0], q_ref=[0.7]), DT)
        assert again.held and np.array_equal(again.q_cmd, first.q_cmd)
    controller.configure([0.1])
    anew = controller.update(st.ControllerState(time=0, q=[0.1], q_ref=[0.2]), DT)
    assert not anew.held and anew.q_cmd == pytest.approx([0.2])
    assert not first.held and first.q_cmd == pytest.approx([0.3])  # a command stays what it was


# ---- scenarios


def test_scenario_comes_to_what_the_program_says(program: Path) -> None:
    done = children.run([program, "control", ROOT / "scenarios/box_in_the_way.yaml", "--json"], limit=120)
    said = json.loads(done.stdout)
    run = st.control("box_in_the_way")
    for name in ("peak_force", "settled_peak", "mean_force", "bound_error", "rms_error_contact", "peak_speed", "slack_ticks"):
        assert getattr(run, name) == said[name], name
    n, n_a = len(run.times), 7
    assert run.q.shape == run.q_cmd.shape == (n, n_a) and run.reference.shape == (n, 6) and len(run.forces) == n
    assert run.largest_force.shape == run.bounded.shape == run.slack.shape == (n,) and run.bounded.dtype == bool
    assert run.largest_force.max() == run.peak_force and np.allclose(np.diff(run.times), DT)
    k = int(np.argmax(run.largest_force))
    assert max(np.linalg.norm(force.force_W) for force in run.forces[k]) == run.peak_force


def test_bound_and_law_are_those_asked_for() -> None:
    scenario = st.load_control_scenario(ROOT / "scenarios" / "box_in_the_way.yaml")
    soft = st.control(scenario, lambda_max=8)
    hard = st.control(scenario, law=st.Law.Unconstrained)
    assert soft.bounded_ticks > 200 and soft.bound_p95 < 1.2 * 8 and hard.mean_force > 4 * soft.mean_force
    assert scenario.lambda_max == 15 and scenario.law == st.Law.ContactAware  # a scenario is not changed by its runs
    assert np.array_equal(scenario.calc_reference(0), np.zeros(6)) and np.allclose(scenario.calc_reference(5), [0, 0.15, 0, 0, 0, 0])


def test_contacts_may_be_estimated_and_late() -> None:
    scenario = st.load_control_scenario("push_along_arm")
    assert scenario.contacts == st.ContactSource.Simulated and scenario.delay == 0
    runs = [st.control(scenario, contacts=st.ContactSource.Estimated, seed=seed) for seed in (1, 1)]
    assert np.array_equal(runs[0].q, runs[1].q) and runs[0].sense_median_s > 0
    felt = st.control(scenario)
    assert felt.sense_median_s == 0 and not np.array_equal(runs[0].q, felt.q)
    late = st.control(scenario, delay=0.1)
    k = int(np.argmax(felt.bounded))
    assert np.array_equal(felt.q[:k], late.q[:k]) and not late.bounded[k]
    assert len(st.control(scenario, period=0.01).times) == len(felt.times) // 2


def test_scenario_of_a_dict_is_that_of_its_file() -> None:
    file = ROOT / "scenarios" / "push_along_arm.yaml"
    values = yaml.safe_load(file.read_text())
    values["hand"]["knots"][1]["time"] = np.float64(values["hand"]["knots"][1]["time"])
    mine, built_in = st.load_control_scenario(values, base=file.parent), st.load_control_scenario("push_along_arm")
    assert mine.name == built_in.name and mine.duration == built_in.duration and np.array_equal(mine.start, built_in.start)
    assert st.control(mine).peak_force == st.control(built_in).peak_force
    del values["name"]
    assert st.load_control_scenario(values, base=file.parent).name == "scenario"
    values["hand"]["stiffness"] = -1
    with pytest.raises(st.InvalidInput, match="^hand.stiffness: got -1, expected a number > 0"):
        st.load_control_scenario(values, base=file.parent)


def test_time_that_is_used_up_is_a_status() -> None:
    assert st.control("box_in_the_way", timeout_s=1e-9).status == st.Status.MaxIterations


def test_loop_over_a_simulated_arm_keeps_its_force_bounded() -> None:
    """The loop of a user: contacts of the simulation to the controller, its command to the simulation, in the way of the reference a box."""
    scenario = st.load_control_scenario("box_in_the_way")
    model, start = scenario.model, np.array(scenario.start)
    last: dict[st.Law, float] = {}
    for law in (st.Law.ContactAware, st.Law.Unconstrained):
        plant, controller = st.DrivenPlant(st.Plant(model, damping_ratio=0)), st.ContactController(model, law=law, lambda_max=15)
        plant.reset(start)
        controller.configure(start)
        for tick in range(1000):
            contacts = []
            for force in plant.forces:
                a, b = (model.bodies[model.geometries[g].body] for g in (model.pairs[force.pair].geometry_a, model.pairs[force.pair].geometry_b))
                if st.BodyKind.Fixed in (a.kind, b.kind):
                    sign, body = (1, a) if a.kind == st.BodyKind.Robot else (-1, b)
                    contacts.append(st.ContactForce(body=body.name, p_WC=force.p_WC, force_W=sign * force.force_W, id=force.pair))
            q_ref = start + [0.3 * min(1.0, tick * DT / 3), 0, 0, 0, 0, 0, 0]
            command = controller.update(st.ControllerState(time=tick * DT, q=plant.q, q_ref=q_ref, contacts=contacts), DT)
            assert plant.advance(command.q_cmd, DT) == st.Status.Solved
        last[law] = max(np.linalg.norm(contact.force_W) for contact in contacts)
    assert last[st.Law.ContactAware] == pytest.approx(15, rel=0.1) and last[st.Law.Unconstrained] > 3 * 15


def test_signal_stops_a_run() -> None:
    scenario = st.load_control_scenario("box_in_the_way")

    def stop(number: int, frame: object) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, stop)
    try:
        with pytest.raises(KeyboardInterrupt):
            signal.setitimer(signal.ITIMER_REAL, 0.02)
            st.control(scenario)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


# ---- mistakes


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"lambda_max": 0}, "^lambda_max: got 0, expected a finite number > 0"),
        ({"lambda_max": math.nan}, "^lambda_max: got nan"),
        ({"force_threshold": 20}, "^force_threshold: got 20"),
        ({"max_contacts": -1}, "^max_contacts: got -1"),
        ({"torque": [1, 2]}, "^torque: got 2 numbers, expected 1"),
        ({"damping": st.ForceDampingOptions(forget_rate=2)}, "forget_rate"),
        ({"force_priority": 1}, "^force_priority"),
        ({"release_time": 0}, "^release_time: got 0"),
        ({"damping": st.ForceDampingOptions(period=0)}, "^damping.period: got 0"),
    ],
)
def test_mistakes_of_a_controller_are_named(cart: st.Model, options: dict, message: str) -> None:
    with pytest.raises(st.InvalidInput, match=message):
        st.ContactController(cart, **options)


@pytest.mark.parametrize(
    ("changes", "dt", "message"),
    [
        ({}, 0, "^dt: got 0, expected a finite number > 0"),
        ({}, math.nan, "^dt: got nan"),
        ({"q": [0.0, 1.0]}, DT, "^q: got 2 numbers, expected 1"),
        ({"q": [math.nan]}, DT, "^q: got nan"),
        ({"q_ref": []}, DT, "^q_ref: got 0 numbers, expected 1"),
        ({"time": math.inf}, DT, "^time: got inf"),
        ({"contacts": [st.ContactForce(body="cart/bal", p_WC=[0, 0, 0], force_W=[1, 0, 0])]}, DT, "^contact.body: got 'cart/bal', expected one of .*did you mean 'cart/ball'"),
        ({"tool": st.ToolReference(body="wall", X_BT=st.Pose(np.eye(3), np.zeros(3)), X_WT=st.Pose(np.eye(3), np.zeros(3)))}, DT, "^tool.body: got 'wall'"),
    ],
)
def test_mistakes_of_a_tick_are_named(cart: st.Model, changes: dict, dt: float, message: str) -> None:
    controller = make(cart)
    controller.configure([0.0])
    with pytest.raises(st.InvalidInput, match=message):
        controller.update(st.ControllerState(**{"time": 0, "q": [0.0], "q_ref": [0.0], **changes}), dt)


def test_other_mistakes_are_named(cart: st.Model) -> None:
    with pytest.raises(st.InvalidInput, match="^p_WC: got 2 numbers"):
        st.ContactForce(body=BALL, p_WC=[0, 0], force_W=[1, 0, 0])
    with pytest.raises(st.InvalidInput, match=r"^force_W\[0\]: got nan"):
        st.ContactForce(body=BALL, p_WC=[0, 0, 0], force_W=[math.nan, 0, 0])
    with pytest.raises(st.InvalidInput, match="^lambda_max: got -1"):
        st.ContactForce(body=BALL, p_WC=[0, 0, 0], force_W=[1, 0, 0], lambda_max=-1)
    with pytest.raises(st.InvalidInput, match="^q: got 2 numbers"):
        make(cart).configure([0, 0])
    with pytest.raises(st.InvalidInput, match="^plant.damping_ratio: got 1"):
        st.DrivenPlant(st.Plant(cart))
    plant = st.DrivenPlant(st.Plant(cart, damping_ratio=0))
    for call, message in (
        (lambda: plant.reset([0, 0]), "^q: got 2"),
        (lambda: plant.advance([0, 0], DT), "^command: got 2"),
        (lambda: plant.advance([0], 0), "^duration: got 0"),
        (lambda: plant.set_push("ball", [0, 0, 0], [1, 0, 0]), "^body: got 'ball', expected one of .*cart/ball"),
        (lambda: plant.set_push(BALL, [0, 0, 0], [math.inf, 0, 0]), r"^force_W\[0\]: got inf"),
    ):
        with pytest.raises(st.InvalidInput, match=message):
            call()
    for options, message in (({"lambda_max": -1}, "^lambda_max"), ({"settle": -1}, "^settle"), ({"timeout_s": 0}, "^timeout_s"), ({"friction_scale": -1}, "^friction_scale"), ({"delay": -1}, "^delay: got -1"), ({"period": 0}, "^period: got 0")):
        with pytest.raises(st.InvalidInput, match=message):
            st.control("box_in_the_way", **options)
    with pytest.raises(st.InvalidInput, match="^scenario: got 'box', expected a file ending in .yaml or one of .*box_in_the_way"):
        st.control("box")


# ---- example


def test_example_presses_with_its_bound_where_tracking_alone_presses_harder() -> None:
    example = ROOT / "python" / "examples" / "bounded_force.py"
    done = children.run([sys.executable, example], env={"PYTHONPATH": str(MODULE)}, limit=120)
    assert done.returncode == 0, done.stderr
    ours, worst, bound, tracking = (float(x) for x in re.findall(r"([0-9.]+) N", done.stdout))
    assert abs(ours - bound) < 0.02 * bound and worst < 1.05 * bound and tracking > 5 * bound
