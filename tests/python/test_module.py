"""The Python module: values known in closed form, mistakes of the caller, threads, the stub, other libraries in the same process."""

from __future__ import annotations

import difflib
import math
import re
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
MODULE = ROOT / "build" / "release" / "python"
if not (MODULE / "stiction").is_dir():
    pytest.skip(f"{MODULE} does not exist: run `make build`", allow_module_level=True)
sys.path.insert(0, str(MODULE))

import stiction as st  # noqa: E402

WALL = """
scene:
  gravity: [0, 0, 0]
  contact_distance: 10
  robots: [{name: cart, urdf: cart.urdf, stiffness: 100}]
  fixed:
    - {name: wall, pose: {rpy: [0, 1.5707963267948966, 0]}, shapes: [{name: plane, half_space: {}}]}
"""
CART = """<robot name="cart"><link name="base"/><link name="ball">
<inertial><mass value="1"/><inertia ixx="0.004" iyy="0.004" izz="0.004" ixy="0" ixz="0" iyz="0"/></inertial>
<collision name="ball"><origin xyz="0.1 0 0"/><geometry><sphere radius="0.1"/></geometry></collision></link>
<joint name="x" type="prismatic"><parent link="base"/><child link="ball"/><axis xyz="1 0 0"/>
<limit lower="-inf" upper="inf" effort="1" velocity="1"/></joint></robot>"""


@pytest.fixture(scope="module")
def wall(tmp_path_factory: pytest.TempPathFactory) -> st.Model:
    """A cart on a spring of 100 N/m; it touches the wall at x = 0."""
    folder = tmp_path_factory.mktemp("wall")
    (folder / "cart.urdf").write_text(CART)
    (folder / "wall.yaml").write_text(WALL)
    return st.load_model(folder / "wall.yaml")


@pytest.fixture(scope="module")
def pushing() -> st.Task:
    return st.load_task("planar_pushing")


# ---- values


def test_model_has_sizes_names_and_limits(pushing: st.Task) -> None:
    model = pushing.model
    assert (model.n_q, model.n_v, model.n_vu, model.n_a) == (5, 5, 3, 2)
    assert model.joint_names == ["hand/y", "hand/z"]
    assert model.object_names == ["box"]
    assert np.array_equal(model.stiffness, [100, 100])
    assert np.isinf(model.lower).all() and np.isinf(model.upper).all()
    assert "n_v 5" in repr(model)


def test_retract_and_local_are_inverse_on_rotations() -> None:
    model = st.load_task("allegro_ball").model
    q = model.neutral()
    delta = np.linspace(-0.5, 0.5, model.n_v)
    moved = model.retract(q, delta)
    assert np.allclose(model.local(q, moved), delta, atol=1e-12)
    pose = model.object_pose(moved, model.object_names[0])
    assert np.allclose(pose.R @ pose.R.T, np.eye(3), atol=1e-12)
    assert np.allclose(model.body_poses(moved)[model.object_names[0]].p, pose.p)


@pytest.mark.parametrize("u", [-0.1, 0.0, 0.05])
def test_exact_step_stops_at_the_wall(wall: st.Model, u: float) -> None:
    result = st.step(wall, [0.02], [u], h=0.1, with_B=True)
    assert result.status == st.Status.Solved
    # At u = 0 neither gap nor impulse is positive: a complementarity of 1e-8 J·s (steps with B) leaves √(1e-8/(h K)) there.
    assert result.q_next[0] == pytest.approx(max(u, 0.0), abs=1e-6 if u != 0 else 4e-5)
    assert result.lambda_[0, 0] / result.h == pytest.approx(100 * max(-u, 0.0), abs=4e-3)
    if u != 0:
        assert result.B is not None and result.B[0, 0] == pytest.approx(float(u > 0), abs=1e-4)
        assert result.active[0] == (u < 0)


@pytest.mark.parametrize("u", [-0.1, 0.0, 0.05])
@pytest.mark.parametrize("h", [0.01, 0.1])
def test_smoothed_step_matches_the_closed_form(wall: st.Model, u: float, h: float) -> None:
    """q+ = (u + √(u² + 4θ/(κk)))/2 whatever h is. θ = 2: a contact in space is a second-order cone."""
    kappa = 100.0
    result = st.step(wall, [0.02], [u], h=h, kappa=kappa, self_sharpness=1, with_B=True)
    root = math.sqrt(u * u + 4 * 2 / (kappa * 100))
    assert result.q_next[0] == pytest.approx((u + root) / 2, abs=1e-8)
    assert result.B is not None and result.B[0, 0] == pytest.approx((1 + u / root) / 2, abs=1e-6)
    (contact,) = result.contacts
    assert (contact.a, contact.b) == ("cart/ball/ball", "wall/plane")
    assert contact.force[0] * contact.anitescu_gap == pytest.approx(2 / kappa, rel=1e-6)
    assert np.allclose(contact.nhat_BA_W, [1, 0, 0], atol=1e-12)


def test_local_models_of_all_schemes_agree_away_from_contact(wall: st.Model) -> None:
    sampling = {"std_q": [0.0], "std_u": [0.01], "samples": 1000}
    schemes = [st.Exact(), st.Analytic(kappa=1e6), st.RandomizedFirstOrder(**sampling), st.RandomizedZerothOrder(**sampling)]
    for scheme in schemes:
        local = st.calc_local_model(wall, [1.0], [1.0], scheme=scheme)
        assert local.status == st.Status.Solved and local.failed == 0 and local.A is None
        # (2.23) fits no offset, so the mean of N samples turns the slope by as much as its square over their variance: some 1/N.
        assert local.B[0, 0] == pytest.approx(1.0, abs=0.02 if isinstance(scheme, st.RandomizedZerothOrder) else 1e-4)
        assert local.c[0] == pytest.approx(1.0, abs=0.02)


def test_rollout_cuts_the_command(wall: st.Model) -> None:
    rollout = st.rollout(wall, [0.5], [0.5], [0.4], joint_travel=0.01)
    assert rollout.status == st.Status.Solved
    assert len(rollout.knots) == 10
    assert rollout.knots[-1].q[0] == pytest.approx(0.4, abs=1e-9)


def test_simulation_comes_to_rest_where_the_springs_say(wall: st.Model) -> None:
    plant = st.Plant(wall, timestep=1e-3, time_constant=1e-2, friction_time_constant=0.1)
    result = st.simulate(plant, [0.1], [0.0, 0.5, 3.0], [[0.1, 0.3, 0.3]])
    assert result.status == st.Status.Solved
    assert result.q.shape == (1, len(result.times))
    assert result.times[-1] == pytest.approx(3.0)
    assert result.q[0, -1] == pytest.approx(0.3, abs=1e-4)


def test_plan_reaches_the_goal_and_is_accepted_by_the_check(pushing: st.Task, stiction, tmp_path: Path) -> None:
    seen: list[float] = []
    result = st.plan(pushing, seed=0, on_progress=lambda progress: seen.append(progress.fraction))
    assert result.status == st.Status.Solved
    assert result.error.position <= pushing.goal.tol_position
    assert result.q.shape[0] == 5 and result.u.shape[1] == result.q.shape[1]
    assert seen
    result.write(tmp_path / "plan.json")
    assert stiction("check", tmp_path / "plan.json").returncode == 0


# ---- arguments


def test_arrays_of_any_kind_are_taken(wall: st.Model) -> None:
    expected = st.step(wall, [0.5], [0.25]).q_next
    for u in (np.float32([0.25]), np.array([[0.25, 1.0]])[0, :1], (0.25,), np.array([0.25, 7.0])[::2]):
        assert np.array_equal(st.step(wall, np.array([0.5]), u).q_next, expected)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda m: st.step(m, [0.0, 1.0], [0.0]), "q: got 2 numbers, expected 1"),
        (lambda m: st.step(m, [0.0], []), "u: got 0 numbers, expected 1"),
        (lambda m: st.step(m, [math.nan], [0.0]), "q"),
        (lambda m: st.step(m, [0.0], [0.0], h=0.0), "h"),
        (lambda m: st.step(m, [0.0], [0.0], kappa=-1.0), "kappa"),
        (lambda m: st.step(m, [0.0], [0.0], rays=2), "rays"),
        (lambda m: st.calc_local_model(m, [0.0], [0.0], scheme=st.RandomizedFirstOrder(std_q=[0.0], std_u=[-1.0])), "std_u"),
        (lambda m: st.load_task("no_such_task"), "no_such_task"),
        (lambda m: m.joint_index("elbow"), "elbow"),
        (lambda m: st.load_model("no_such_file.yaml"), "no_such_file.yaml"),
        (lambda m: st.Plant(m, timestep=-1.0), "timestep"),
    ],
)
def test_mistakes_are_value_errors_that_say_what_was_expected(wall: st.Model, call, message: str) -> None:
    with pytest.raises(ValueError, match=message) as error:
        call(wall)
    assert error.type is st.InvalidInput
    assert "expected" in str(error.value)


def test_options_are_keyword_only(wall: st.Model) -> None:
    with pytest.raises(TypeError):
        st.step(wall, [0.0], [0.0], 0.1)
    with pytest.raises(TypeError):
        st.step(wall, [0.0], "abc")


def test_results_outlive_what_they_were_made_from() -> None:
    contacts = st.step(st.load_task("planar_pushing").model, [0, 0.5, 0, 0, -0.1], [0, 0.1]).contacts
    assert contacts[0].a == "box/box" or contacts[0].b == "box/box"


# ---- threads


def test_workspace_of_two_threads_is_refused_and_own_ones_agree(pushing: st.Task) -> None:
    model, q, u = pushing.model, pushing.q_start, np.array([0.0, 0.2])
    expected = st.step(model, q, u).q_next
    results: list[np.ndarray] = []
    refused: list[str] = []

    def own() -> None:
        work = st.StepWorkspace(model)
        results.extend(st.step(model, q, u, workspace=work, warm_start=False).q_next for _ in range(200))

    shared_workspace = st.StepWorkspace(model)

    def shared() -> None:
        for _ in range(200):
            try:
                st.step(model, q, u, workspace=shared_workspace)
            except st.InvalidInput as error:
                refused.append(str(error))

    threads = [threading.Thread(target=target) for target in (own, own, shared, shared)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(results) == 400 and all(np.array_equal(r, expected) for r in results)
    assert all("workspace" in message for message in refused)


def test_error_in_on_progress_stops_the_plan(pushing: st.Task) -> None:
    def stop(progress: st.Progress) -> None:
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        st.plan(pushing, seed=0, on_progress=stop)


# ---- package


def test_stub_is_the_committed_one() -> None:
    """After a change of the bindings: cp build/release/python/stiction/_core.pyi python/module/stiction/"""
    made = (MODULE / "stiction" / "_core.pyi").read_text().splitlines()
    committed = (ROOT / "python" / "module" / "stiction" / "_core.pyi").read_text().splitlines()
    assert made == committed, "\n".join(difflib.unified_diff(committed, made, "committed", "made", lineterm=""))


def test_example_of_the_readme_runs() -> None:
    (example,) = re.findall(r"^```python\n(.*?)^```", (ROOT / "README.md").read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
    done = subprocess.run([sys.executable, "-c", example], env={"PYTHONPATH": str(MODULE)}, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("order", ["stiction first", "stiction last"])
def test_lives_beside_coal_pinocchio_and_mujoco(order: str) -> None:
    libraries = ["coal", "pinocchio", "mujoco"]
    names = ["stiction", *libraries] if order == "stiction first" else [*libraries, "stiction"]
    script = f"""
import {", ".join(names)}
import numpy as np, stiction as st
task = st.load_task("planar_pushing")
assert st.step(task.model, task.q_start, [0, 0.1]).status == st.Status.Solved
plant = st.Plant(task.model)
assert st.simulate(plant, task.q_start, [0.0, 0.05], [[0, 0], [-0.1, -0.1]]).status == st.Status.Solved
assert abs(coal.Sphere(0.5).computeVolume() - 0.5235987755982988) < 1e-12
model = pinocchio.buildSampleModelManipulator()
pinocchio.computeJointJacobians(model, model.createData(), pinocchio.neutral(model))
data = mujoco.MjData(mujoco.MjModel.from_xml_string("<mujoco><worldbody><body><freejoint/><geom size='.1'/></body></worldbody></mujoco>"))
try:
    mujoco.MjModel.from_xml_string("<mujoco><nonsense/></mujoco>")
except ValueError:
    print("fine")
"""
    done = subprocess.run([sys.executable, "-c", script], env={"PYTHONPATH": str(MODULE)}, capture_output=True, text=True, timeout=120)
    assert done.stdout == "fine\n", done.stderr
