"""The Python module: values known in closed form, mistakes of the caller, threads, the stub, other libraries in the same process."""

from __future__ import annotations

import contextlib
import difflib
import json
import math
import pickle
import re
import sys
import threading
import warnings
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

WALL = {
    "gravity": [0, 0, 0],
    "contact_distance": 10,
    "robots": [{"name": "cart", "urdf": "cart.urdf", "stiffness": 100}],
    "fixed": [{"name": "wall", "pose": {"rpy": [0, math.pi / 2, 0]}, "shapes": [{"name": "plane", "half_space": {}}]}],
}
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
    return st.load_model(WALL, base=folder)


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
    result = st.step(wall, [0.02], [u], h=h, smoothing=st.Analytic(kappa=kappa, self_sharpness=1), with_B=True)
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


def test_arguments_of_earlier_steps_are_taken_and_named(wall: st.Model) -> None:
    """kappa= and epsilon= became smoothing= and regularisation=."""
    now = st.step(wall, [0.02], [0.01], smoothing=st.Analytic(kappa=50), regularisation=st.FixedEpsilon(epsilon=0.5))
    with pytest.warns(DeprecationWarning, match=r"^kappa= is deprecated, write smoothing=Analytic\(kappa=\.\.\.\)$"):
        then = st.step(wall, [0.02], [0.01], kappa=50, regularisation=st.FixedEpsilon(epsilon=0.5))
    assert np.array_equal(then.q_next, now.q_next)
    with pytest.warns(DeprecationWarning, match="regularisation=FixedEpsilon"):
        then = st.step(wall, [0.02], [0.01], smoothing=st.Analytic(kappa=50), epsilon=0.5)
    assert np.array_equal(then.epsilon, now.epsilon)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(DeprecationWarning):
            st.step(wall, [0.02], [0.01], kappa=50)


def test_rollout_cuts_the_command(wall: st.Model) -> None:
    rollout = st.rollout(wall, [0.5], [0.5], [0.4], joint_travel=0.01)
    assert rollout.status == st.Status.Solved
    assert len(rollout.knots) == 10
    assert rollout.knots[-1].q[0] == pytest.approx(0.4, abs=1e-9)


def test_simulation_comes_to_rest_where_the_springs_say(wall: st.Model) -> None:
    plant = st.Plant(wall, timestep=1e-3, time_constant=1e-2, friction_time_constant=0.1)
    result = st.simulate(plant, [0.1], [0.0, 0.5, 3.0], [[0.1], [0.3], [0.3]])
    assert result.status == st.Status.Solved
    assert result.q.shape == (len(result.times), 1) and result.v.shape == result.q.shape
    assert result.times[-1] == pytest.approx(3.0)
    assert result.q[-1, 0] == pytest.approx(0.3, abs=1e-4)


def test_plan_reaches_the_goal_and_is_accepted_by_the_check(pushing: st.Task, stiction, tmp_path: Path) -> None:
    seen: list[float] = []
    result = st.plan(pushing, seed=0, on_progress=lambda progress: seen.append(progress.fraction))
    assert result.status == st.Status.Solved
    assert result.plan.error.position <= pushing.goal.tol_position
    assert result.plan.q.shape[1] == 5 and result.plan.u.shape == (len(result.plan.q), 2)
    assert seen
    result.plan.write(tmp_path / "plan.json")
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
        (lambda m: st.step(m, [0.0], [0.0], smoothing=st.Analytic(kappa=-1.0)), "kappa"),
        (lambda m: st.step(m, [0.0], [0.0], friction_cone=st.PolyhedralCone(rays=2)), "rays"),
        (lambda m: st.calc_local_model(m, [0.0], [0.0], scheme=st.RandomizedFirstOrder(std_q=[0.0], std_u=[-1.0])), "std_u"),
        (lambda m: st.load_task("no_such_task"), "no_such_task"),
        (lambda m: m.joint_index("elbow"), "elbow"),
        (lambda m: st.load_model("no_such_file.yaml"), "no_such_file.yaml"),
        (lambda m: st.Plant(m, timestep=-1.0), "timestep"),
        (lambda m: st.step(m, [0.0], [math.inf]), "^u"),
        (lambda m: st.step(m, [0.0], [0.0], tau_ext=[math.nan]), "^tau_ext"),
        (lambda m: st.step(m, [0.0], [0.0], tau_ext=[math.inf]), "^tau_ext"),
        (lambda m: st.step(m, [0.0], [0.0], tau_ext=[0.0, 0.0]), "^tau_ext: got 2 numbers, expected 1"),
        (lambda m: st.calc_local_model(m, [0.0], [0.0], damping=[math.nan]), "^damping"),
        (lambda m: st.rollout(m, [0.0], [0.0], [math.nan]), "^u_end"),
        (lambda m: st.simulate(st.Plant(m), [0.0], [0.0, 1.0], [[0.0, 0.0]]), r"^u: got shape \(1, 2\), expected \(knots, n_a\) = \(2, 1\)"),
        (lambda m: st.Pose(np.ones((3, 3)), [0, 0, 0]), "^R: got"),
        (lambda m: st.Pose(np.diag([1.0, 1.0, -1.0]), [0, 0, 0]), "^R: got a reflection"),
        (lambda m: st.Pose(np.eye(3)[:2], [0, 0, 0]), "^R: rows: got 2"),
        (lambda m: st.Pose(np.eye(3), [0, 0, math.nan]), "^p"),
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


@pytest.mark.parametrize("u", [np.array([1 + 1j]), [1j], ["1"], np.array(["1"])])
def test_what_is_no_real_number_is_refused(wall: st.Model, u) -> None:
    with pytest.raises(TypeError):
        st.step(wall, [0.0], u)


def test_quaternion_of_length_0_is_refused() -> None:
    task = st.load_task("allegro_ball")
    q = task.q_start
    q[3:7] = 0
    with pytest.raises(st.InvalidInput, match=r"^q\[3..6\]: got a quaternion of length 0"):
        st.step(task.model, q, q[task.model.n_qu :])


@pytest.mark.parametrize("flag", [np.bool_(True), np.array([True])[0], np.ones(1) > 0.5], ids=["scalar", "element", "comparison"])
def test_flags_of_numpy_are_flags(wall: st.Model, flag) -> None:
    flag = flag if isinstance(flag, np.bool_) else flag[0]
    assert st.step(wall, [0.0], [0.1], with_B=flag, smoothing=st.Analytic(kappa=100)).B is not None
    assert st.step(wall, [0.0], [0.1], with_B=~flag, smoothing=st.Analytic(kappa=100)).B is None
    assert st.ForceDampingOptions(printed=flag).printed is True
    task = st.Task({"base": "planar_pushing.yaml", "planner": {"anytime": flag}}, base=st.load_task("planar_pushing").file.parent)
    assert task.options.anytime is True and task.options.replace(anytime=~flag).anytime is False
    assert st.plan(task, seed=0, on_progress=lambda progress: ~flag).status == st.Status.Cancelled


@pytest.mark.parametrize("flag", [1, 0, None, "yes", 1.0, np.float64(1), np.array([True])])
def test_what_is_no_flag_is_refused(wall: st.Model, flag) -> None:
    with pytest.raises(TypeError):
        st.step(wall, [0.0], [0.1], with_B=flag)


def test_numbers_of_numpy_are_numbers(wall: st.Model) -> None:
    plain = st.step(wall, [0.0], [0.1], h=0.5, smoothing=st.Analytic(kappa=100)).q_next
    for h in (np.float32(0.5), np.float64(0.5), np.longdouble(0.5)):
        np.testing.assert_array_equal(st.step(wall, [0.0], [0.1], h=h, smoothing=st.Analytic(kappa=np.int64(100))).q_next, plain)
    task = st.load_task("planar_pushing")
    assert st.plan(task, seed=np.int64(3), timeout_s=np.float32(20)).seed == 3
    assert st.plan(task, seed=np.uint64(2**64 - 1), threads=np.int8(1), options={"goal_bias": np.float32(0.25)}).seed == 2**64 - 1
    assert task.options.replace(goal_bias=np.float16(0.25)).goal_bias == 0.25


def test_numbers_that_are_masked_are_not_taken(wall: st.Model) -> None:
    st.step(wall, np.ma.array([0.0]), [0.1])
    with pytest.raises(TypeError):
        st.step(wall, np.ma.array([0.0], mask=[True]), [0.1])


class Interrupted:
    """Ctrl-C while NumPy reads an argument."""

    def __array__(self, *_: object, **__: object) -> np.ndarray:
        raise KeyboardInterrupt


def test_ctrl_c_while_an_argument_is_read_is_not_lost() -> None:
    with pytest.raises(KeyboardInterrupt):
        with contextlib.suppress(TypeError):
            st.Pose(Interrupted(), [0, 0, 0])
        for _ in range(1000):  # where Python looks for what is pending
            pass


# ---- scenes, tasks and options from memory


def test_scene_of_a_dict_is_that_of_the_file(wall: st.Model, tmp_path: Path) -> None:
    (tmp_path / "cart.urdf").write_text(CART)
    (tmp_path / "wall.yaml").write_text(yaml.safe_dump({"scene": WALL}))
    for from_file in (st.load_model(tmp_path / "wall.yaml"), st.load_model(str(tmp_path / "wall.yaml"))):
        assert from_file.joint_names == wall.joint_names
        assert np.array_equal(from_file.calc_kinematics([0.3]).X_WB[0].R, wall.calc_kinematics([0.3]).X_WB[0].R)
    assert st.load_scene({"scene": WALL}, base=tmp_path).contact_distance == 10


def test_dict_takes_arrays_poses_and_paths(tmp_path: Path) -> None:
    urdf = tmp_path / "cart.urdf"
    urdf.write_text(CART)
    X_WB = st.Pose([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], [1.0, 2.0, 3.0])
    shapes = ({"box": {"size": np.float32([1, 1, 1])}},)
    scene = {"robots": [{"name": "cart", "urdf": urdf, "stiffness": np.float64(100)}], "fixed": [{"name": "table", "pose": X_WB, "shapes": shapes}]}
    model = st.load_model(scene)
    table = model.body_poses(model.neutral())["table"]
    assert np.allclose(table.R, X_WB.R, atol=1e-15) and np.array_equal(table.p, X_WB.p)


@pytest.mark.parametrize(
    ("scene", "message"),
    [
        ({"robts": []}, "robts: got an unknown key, expected one of"),
        ({"gravity": [0, 0, math.nan]}, "gravity"),
        ({"gravity": [0, 0, 1j]}, r"gravity\[2\]: got a value of type complex"),
        ({"objects": [{"name": "box", "mass": "1"}]}, r"objects\[0\]"),
        ({1: 2}, "top level: got a key 1, expected words as keys"),
        ({"robots": [{"name": "r", "urdf": "no.urdf"}]}, "no.urdf"),
    ],
)
def test_mistakes_in_a_dict_are_named_by_their_path(scene: dict, message: str) -> None:
    with pytest.raises(st.InvalidInput, match=f"^{message}" if not message.startswith("no.") else message):
        st.load_model(scene)


def test_dict_that_holds_itself_is_refused() -> None:
    scene: dict = {}
    scene["objects"] = [scene]
    with pytest.raises(st.InvalidInput, match="nested values without end"):
        st.load_scene(scene)


def test_task_of_a_dict_takes_what_a_file_takes() -> None:
    file = st.load_task("planar_pushing").file
    mine = st.Task({"base": file.name, "name": "mine", "tolerance": {"position": 0.25}}, base=file.parent)
    assert mine.name == "mine" and mine.goal.tol_position == 0.25
    assert mine.scene_sha256 == st.load_task(file).scene_sha256
    with pytest.raises(st.InvalidInput, match="^tolerance.positon: got an unknown key"):
        st.Task({"base": file, "tolerance": {"positon": 1}})


def test_task_is_loaded_by_any_path(monkeypatch: pytest.MonkeyPatch) -> None:
    file = st.load_task("planar_pushing").file
    monkeypatch.chdir(file.parent)
    assert st.load_task(Path("planar_pushing.yaml")).scene_sha256 == st.load_task("planar_pushing").scene_sha256


def test_planner_options_are_those_of_a_task_file(pushing: st.Task) -> None:
    options = pushing.options
    assert options == st.PlannerOptions(pushing.model, **options.to_dict())
    changed = options.replace(goal_bias=0.25, threads=1)
    assert changed.goal_bias == 0.25 and options.goal_bias != 0.25 and changed != options
    assert changed.to_dict() | {"goal_bias": options.goal_bias, "threads": options.threads} == options.to_dict()
    assert "goal_bias" in dir(options) and "goal_bias=0.25" in repr(changed)
    assert changed.replace(goal_bias=None).goal_bias == st.PlannerOptions(pushing.model, sample_box=options.sample_box).goal_bias
    assert options != 3
    with pytest.raises(AttributeError, match="goal_biass"):
        _ = options.goal_biass


@pytest.mark.parametrize(("changes", "message"), [({"goal_bias": 2}, "^goal_bias: got 2"), ({"goal_biass": 0}, "^goal_biass: got an unknown key.*'goal_bias'")])
def test_mistakes_in_planner_options_are_named(pushing: st.Task, changes: dict, message: str) -> None:
    for call in (lambda: pushing.options.replace(**changes), lambda: st.plan(pushing, options=changes)):
        with pytest.raises(st.InvalidInput, match=message):
            call()


@pytest.fixture(scope="module")
def solved(pushing: st.Task) -> st.Plan:
    result = st.plan(pushing, seed=0)
    assert result.status == st.Status.Solved and result.reason == ""
    return result.plan


def test_plan_is_its_segments_one_after_the_other(solved: st.Plan) -> None:
    assert np.array_equal(solved.q, np.vstack([solved.q[:1], *(segment.q for segment in solved.segments)]))
    assert np.array_equal(solved.u, np.vstack([solved.u[:1], *(segment.u for segment in solved.segments)]))
    assert {segment.kind for segment in solved.segments} <= set(st.SegmentKind)
    assert np.array_equal(solved.q[0], solved.task.q_start)
    model = solved.task.model
    end = model.object_pose(solved.q[-1], "box")
    assert np.linalg.norm(end.p - solved.task.goal.X_WG.p) == pytest.approx(solved.error.position, abs=1e-12)


def test_plan_is_the_same_from_its_file_its_text_and_a_pickle(solved: st.Plan, tmp_path: Path) -> None:
    solved.write(tmp_path / "plan.json")
    text = solved.to_text(tmp_path)
    assert (tmp_path / "plan.json").read_text() == text
    for again in (st.read_plan(tmp_path), st.read_plan(tmp_path / "plan.json"), st.parse_plan(text, tmp_path), pickle.loads(pickle.dumps(solved))):
        assert again.to_text(tmp_path) == text
        assert np.array_equal(again.q, solved.q) and np.array_equal(again.u, solved.u) and again.options == solved.options


def test_plan_of_a_task_made_in_memory_is_read_again_from_another_folder(pushing: st.Task, stiction, tmp_path: Path) -> None:
    task = st.Task({"base": pushing.file.name, "tolerance": {"position": 0.05, "angle": 0.2}}, base=pushing.file.parent)
    plan = st.plan(task, seed=1).plan
    (tmp_path / "a").mkdir()
    plan.write(tmp_path / "a" / "plan.json")
    again = st.read_plan(tmp_path / "a")
    assert again.task.goal.tol_position == 0.05
    done = stiction("check", tmp_path / "a", "--json")
    assert (done.returncode == 0) == st.check_plan(again).pass_


def test_plan_names_its_task_from_wherever_it_is_written(pushing: st.Task, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a" / "b").mkdir(parents=True)
    (tmp_path / "task.yaml").write_text(f"base: {pushing.file}\n")
    monkeypatch.chdir(tmp_path)
    plan = st.plan(st.load_task("./task.yaml"), options={"max_iterations": 1}).plan
    monkeypatch.chdir(tmp_path / "a")
    plan.write("b/plan.json")
    assert st.read_plan("b").task.file == tmp_path / "task.yaml"
    assert pickle.loads(pickle.dumps(plan)).task.file == tmp_path / "task.yaml"


def test_mistakes_in_plan_files_are_named(solved: st.Plan, tmp_path: Path) -> None:
    with pytest.raises(st.InvalidInput, match="no.json"):
        st.read_plan(tmp_path / "no.json")
    with pytest.raises(st.InvalidInput, match="seed"):
        st.parse_plan(solved.to_text().replace('"seed"', '"sed"', 1))


def test_refined_plan_is_accepted_and_not_longer(stiction, tmp_path: Path) -> None:
    found = st.plan(st.load_task("planar_pushing"), seed=1, threads=1).plan  # in small steps the box follows: nothing is planned anew
    found.write(tmp_path / "plan.json")
    refined = st.refine(found, timeout_s=60)
    assert refined.status == st.Status.Solved
    assert refined.regrasps[1] <= refined.regrasps[0] and refined.pushes[1] <= refined.pushes[0]
    assert sum(segment.kind == st.SegmentKind.Regrasp for segment in refined.plan.segments) == refined.regrasps[1]
    report = st.check_plan(refined.plan)
    assert report.status == st.Status.Solved and report.pass_, report
    assert stiction("refine", tmp_path).returncode == 0
    assert np.array_equal(st.read_plan(tmp_path / "refined").u, refined.plan.u)
    with pytest.raises(st.InvalidInput, match="^plan.status: got MaxIterations, expected Solved"):
        st.refine(st.plan(found.task, options={"max_iterations": 1}).plan)


def test_check_says_what_is_wrong(solved: st.Plan) -> None:
    data = json.loads(solved.to_text())
    knot = data["segments"][-1]["knots"][-1]
    knot["u"][0] += 0.5
    report = st.check_plan(st.parse_plan(json.dumps(data)))
    assert not report.pass_ and any(not item.pass_ for item in report.items)
    assert report.at("goal_position").limit == solved.task.goal.tol_position
    with pytest.raises(st.InvalidInput):
        report.at("beauty")


def test_trajectory_keeps_the_speeds(solved: st.Plan) -> None:
    trajectory = st.make_trajectory(solved, speed=1.0)
    assert trajectory.u.shape == (len(trajectory.times), 2) and trajectory.q.shape == (len(trajectory.times), 5)
    assert np.all(np.diff(trajectory.times) > 0) and trajectory.duration == trajectory.times[-1]
    assert st.make_trajectory(solved, speed=0.5).duration > 1.2 * trajectory.duration
    by_default = st.make_trajectory(solved)
    assert by_default.speed == st.OPEN_LOOP_SPEED == 0.1 and 5 * trajectory.duration < by_default.duration < 10.01 * trajectory.duration
    assert len(by_default.times) < 1.5 * len(trajectory.times), "a slower run has about the same knots"
    uniform = st.transfer(solved, uniform=st.SpeedLimits(prismatic=0.2, pause=0.0, load_time=0.0), hold=0.0, alone=False)
    assert uniform.duration_s < st.transfer(solved, uniform=st.SpeedLimits(prismatic=0.1, pause=0.0, load_time=0.0), hold=0.0, alone=False).duration_s
    with pytest.raises(st.InvalidInput, match="speed.prismatic"):
        st.SpeedLimits(prismatic=0)


def test_transfer_runs_a_plan_from_memory(solved: st.Plan) -> None:
    run = st.transfer(solved, hold=0.5, alone=False)
    assert run.status == st.Status.Solved
    assert run.q.shape == run.q_plan.shape == (len(run.times), 5)
    assert {piece.kind for piece in run.pieces} <= {st.SegmentKind.Contact, st.SegmentKind.Regrasp}


def test_solve_gives_a_plan_that_reaches_its_goal(pushing: st.Task) -> None:
    seen: list[st.Progress] = []
    found = st.solve(pushing, seed=3, tries=5, on_progress=seen.append)
    assert found.status == st.Status.Solved and found.best.holds and seen
    assert found.best.seed == found.tries[-1].seed and [t.seed for t in found.tries] == list(range(3, 3 + len(found.tries)))
    plan = found.best.plan
    assert plan.seed == found.best.seed and plan.options.seed == plan.seed and st.check_plan(plan).pass_
    again = st.transfer(plan, alone=False)
    assert again.reached and again.error.position == found.best.runs[0].error.position


def test_solve_says_which_argument_is_wrong_and_stops_at_an_error_of_the_caller(pushing: st.Task) -> None:
    with pytest.raises(st.InvalidInput, match="tries"):
        st.solve(pushing, tries=0)
    with pytest.raises(st.InvalidInput, match="^goal_biass"):
        st.solve(pushing, options={"goal_biass": 0})
    with pytest.raises(ZeroDivisionError):
        st.solve(pushing, on_progress=lambda progress: 1 / 0)


def test_lint_names_what_is_hardly_meant(pushing: st.Task) -> None:
    assert st.lint(pushing) == []
    box = {"objects": {"box": {"coordinates": [0.0, 0.5, 0.0]}}}
    (finding,) = st.lint(st.Task({"base": pushing.file, "goal": box}))
    assert finding.kind == "goal" and "box" in finding.message


def test_plan_goes_by_its_options(pushing: st.Task) -> None:
    result = st.plan(pushing, options={"max_iterations": 30, "thesis": {"stop_at_goal": False}}, seed=5)
    assert result.iterations == 30 and len(result.tree) == result.nodes and result.tree_errors.shape == (result.nodes, 2)
    assert result.seed == 5 and result.options.max_iterations == 30
    assert result.tree[1].edge in (st.SegmentKind.Contact, st.SegmentKind.Regrasp)
    again = st.plan(pushing, options=result.options, threads=1)
    assert again.seed == 5 and np.array_equal(again.plan.q, result.plan.q)
    with pytest.raises(st.InvalidInput, match="^options: got those of another model"):
        st.plan(st.load_task("planar_hand"), options=pushing.options)


def test_samples_of_a_task_stay_when_another_scheme_is_chosen(pushing: st.Task) -> None:
    """The table of the thesis compares schemes with the samples of the task: they are in its options whatever its scheme is."""
    plate = st.load_task("allegro_plate_table_3_2").options.thesis
    assert plate["scheme"] == "analytic" and plate["randomized"]["std_u"][:4] == [0.03, 0.03, 0.03, 0.2]
    chosen = {"max_iterations": 3, "thesis": {"scheme": "randomized-first", "randomized": {"std_u": 0.3, "samples": 5}}}
    used = st.plan(pushing, options=chosen, seed=0).options
    assert used.thesis["randomized"] == {"std_u": 0.3, "std_q": 0.0, "samples": 5}
    assert st.plan(pushing, options={"max_iterations": 3, "thesis": used.thesis}, seed=0).options.thesis == used.thesis


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


@pytest.mark.parametrize("document", ["README.md", "python/README.md"])
def test_example_of_the_readme_runs(document: str, tmp_path: Path) -> None:
    (example,) = re.findall(r"^```python\n(.*?)^```", (ROOT / document).read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
    environment = {"PYTHONPATH": str(MODULE)}
    done = children.run([sys.executable, "-c", example], env=environment, cwd=tmp_path, limit=120)
    assert done.returncode == 0, done.stderr


def test_example_makes_a_scene_and_reaches_its_goal() -> None:
    example = ROOT / "python" / "examples" / "push_box.py"
    done = children.run([sys.executable, example], env={"PYTHONPATH": str(MODULE)}, limit=120)
    assert done.returncode == 0, done.stderr
    assert "goal reached" in done.stdout and "CheckReport: passed" in done.stdout


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
assert st.simulate(plant, task.q_start, [0.0, 0.05], [[0, -0.1], [0, -0.1]]).status == st.Status.Solved
assert abs(coal.Sphere(0.5).computeVolume() - 0.5235987755982988) < 1e-12
model = pinocchio.buildSampleModelManipulator()
pinocchio.computeJointJacobians(model, model.createData(), pinocchio.neutral(model))
data = mujoco.MjData(mujoco.MjModel.from_xml_string("<mujoco><worldbody><body><freejoint/><geom size='.1'/></body></worldbody></mujoco>"))
try:
    mujoco.MjModel.from_xml_string("<mujoco><nonsense/></mujoco>")
except ValueError:
    print("fine")
"""
    done = children.run([sys.executable, "-c", script], env={"PYTHONPATH": str(MODULE)}, limit=120)
    assert done.stdout == "fine\n", done.stderr
