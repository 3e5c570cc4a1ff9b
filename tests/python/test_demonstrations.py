"""Demonstrations: what is read, what is refused, and plans that follow them within the laws of contact."""

from __future__ import annotations

import csv
import json
import re
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
MODULE = ROOT / "build" / "release" / "python"
if not (MODULE / "stiction").is_dir():
    pytest.skip(f"{MODULE} does not exist: run `make build`", allow_module_level=True)
sys.path.insert(0, str(MODULE))

import stiction as st  # noqa: E402
from stiction._demonstration_reference import Reference, off_by  # noqa: E402
from stiction.demonstrations import Demonstration  # noqa: E402


@pytest.fixture(scope="module")
def task() -> st.Task:
    """Two arms turn a ball in a plane."""
    return st.load_task("planar_hand").with_(goal=[0.0, 0.35, 0.6])


@pytest.fixture(scope="module")
def table(task: st.Task, tmp_path_factory: pytest.TempPathFactory) -> list[list[str]]:
    """Of a plan that uses 0.8 of the friction, as exported."""
    file = tmp_path_factory.mktemp("demonstration") / "motion.csv"
    st.plan(task, seed=0, options={"friction": 0.8}).plan.export(file)
    with file.open(newline="", encoding="utf-8") as text:
        return list(csv.reader(text))


@pytest.fixture
def write(table: list[list[str]], tmp_path: Path) -> Callable[..., Path]:
    """A table with changes: names of columns, and a function of the value of each column by its name."""

    def make(change: Callable[[str, int, str], str] = lambda name, row, value: value, columns: list[str] | None = None, rename: Callable[[str], str] = lambda name: name) -> Path:
        head = table[0]
        file = tmp_path / "demo.csv"
        kept = head if columns is None else columns
        with file.open("w", newline="", encoding="utf-8") as text:
            out = csv.writer(text)
            out.writerow([rename(name) for name in kept])
            out.writerows([[change(name, k, row[head.index(name)]) for name in kept] for k, row in enumerate(table[1:])])
        return file

    return make


def noisy(demonstration: Demonstration, task: st.Task) -> Demonstration:
    """Joints and poses as a camera would have them: slow errors, no commands, and so neither contact nor rest at the start."""
    random, n = np.random.default_rng(0), len(demonstration.time)
    knots = np.linspace(0, n - 1, 12)

    def error(columns: int, size: float) -> np.ndarray:
        return np.column_stack([np.interp(np.arange(n), knots, random.normal(0, size, 12)) for _ in range(columns)])

    poses = demonstration.poses.copy()
    poses[:, 0, 1:3] += error(2, 0.003)
    joints = np.clip(demonstration.joints + error(demonstration.joints.shape[1], 0.01), task.model.lower, task.model.upper)
    return replace(demonstration, joints=joints, commands=None, poses=poses)


# ---- repair


def test_demonstration_that_breaks_contact_becomes_a_plan_that_check_accepts(task: st.Task, write: Callable[..., Path]) -> None:
    shown = noisy(st.read_demonstration(write(), task), task)
    done = st.repair(task, shown)
    assert done.complete and done.accepted and st.check_plan(done.plan).pass_, done.sentences()
    goal = task.goal
    assert done.position_error[-1] <= goal.tol_position and done.angle_error[-1] <= goal.tol_angle
    assert 0 < done.joint_change.max() < 0.3, "it changed, and not much"
    text = " ".join(done.sentences())
    assert re.search(r"joints change by up to 0\.\d+ rad", text) and "at the end it is off by" in text


def test_what_is_shown_is_followed_on_the_way(task: st.Task, write: Callable[..., Path]) -> None:
    """Of a demonstration that obeys contact little is left to repair; the object is near where it was all the time, by poses that are computed here."""
    shown = st.read_demonstration(write(), task)
    done = st.repair(task, shown)
    y = np.interp(done.times, shown.time, shown.poses[:, 0, 1])
    assert done.complete and done.position_error.max() < 0.01 and done.angle_error.max() < 0.1
    angles = done.plan.q[:, 2]
    assert abs(angles[-1] - 0.6) < 0.15 and np.ptp(y) > 0, "the ball was turned"
    assert done.start_moved[0] < 2e-3


def test_half_steps_lead_where_full_ones_do(task: st.Task, write: Callable[..., Path]) -> None:
    """`check` takes half steps; commands are chosen so that what was shown lies between both, which is seen here without `check`."""
    shown = noisy(st.read_demonstration(write(), task), task)
    done = st.repair(task, shown)
    plan, commands = done.plan, np.asarray(done.plan.u)
    halves = np.empty((2 * len(commands) - 2, commands.shape[1]))
    halves[0::2], halves[1::2] = 0.5 * (commands[:-1] + commands[1:]), commands[1:]
    fine = plan.task.with_(start=plan.q[0]).follow(halves, u_start=commands[0])
    assert done.planned_from is None, "it is followed all the way"
    for end in (plan, fine):
        assert end.error.position <= task.goal.tol_position and end.error.angle <= task.goal.tol_angle


def test_planner_goes_on_where_the_object_is_lost(task: st.Task, write: Callable[..., Path]) -> None:
    """Arms that close into the ball throw it out of the hand: joints have to go other ways, and the plan says from when on."""
    shown = st.read_demonstration(write(), task)
    closing = np.array([1, 0, -1, 0])
    far = np.clip(shown.joints + 0.5 * closing * np.minimum(1, shown.time / shown.time[-1] * 4)[:, None], task.model.lower, task.model.upper)
    done = st.repair(task, replace(shown, joints=far, commands=None))
    assert done.holds and st.check_plan(done.plan).pass_
    assert done.planned_from is not None and 0 <= done.planned_from < shown.time[-1]
    assert any(sentence.startswith(f"from {done.planned_from:.2f} s on joints go other ways") for sentence in done.sentences())
    assert done.position_error[-1] <= task.goal.tol_position and done.angle_error[-1] <= task.goal.tol_angle


def test_noise_of_single_frames_is_smoothed_and_a_straight_motion_stays(task: st.Task, write: Callable[..., Path]) -> None:
    from stiction._demonstration_reference import _smooth, calm

    time = np.sort(np.random.default_rng(3).uniform(0, 2, 90))
    line = np.column_stack([1 + 2 * time, -time])
    np.testing.assert_allclose(_smooth(time, line), line, atol=1e-9, err_msg="also at its ends, and between times that are not equal")
    noise = np.random.default_rng(4).normal(0, 0.01, line.shape)
    assert np.abs(_smooth(time, line + noise) - line).std() < 0.5 * noise.std()
    assert calm(st.read_demonstration(write(), task)).notes == [], "a plan does not shake"
    time = np.linspace(0, 6, 181)
    still = np.sin(time)[:, None] * [0.3, -0.2, 0.1, 0.3] + task.q_start[-4:]
    poses = np.tile([0, 0, 0.35, 0, 0, 0, 1.0], (181, 1, 1))
    smooth = calm(Demonstration(time, still + np.random.default_rng(5).normal(0, 0.01, still.shape), None, poses))
    assert smooth.notes == ["joints shake from one time to the next: everything is smoothed over 0.16 s"]
    assert np.abs(smooth.joints - still).std() < 0.005 and np.allclose(smooth.poses, poses), "less than half of the noise is left"


def test_demonstration_without_a_hold_is_not_called_complete() -> None:
    """A ball that floats away from the hand: no command makes it."""
    ball = st.load_task("allegro_ball")
    time = np.linspace(0, 2, 21)
    poses = np.zeros((21, 1, 7))
    poses[:, 0, :3] = ball.q_start[:3] if ball.model.objects[0].q_begin == 0 else 0
    X = ball.model.object_pose(ball.q_start, "ball")
    poses[:, 0, :3] = X.p + np.outer(time, [0, 0, 0.25])
    poses[:, 0, 6] = 1
    joints = np.tile(ball.q_start[-16:], (21, 1)) + 0.05 * time[:, None]
    done = st.repair(ball, Demonstration(time, np.clip(joints, ball.model.lower, ball.model.upper), None, poses), timeout_s=10)
    assert not done.holds and done.position_error[-1] > ball.goal.tol_position
    assert any("does not accept" in sentence or "is lost" in sentence for sentence in done.sentences())


@pytest.mark.parametrize("scene", ["tasks/allegro_door.yaml", "tests/tasks/data/two_boxes.yaml"], ids=["on_another_object", "two_objects"])
def test_goal_of_a_repair_is_where_all_its_objects_were_shown(scene: str, tmp_path: Path) -> None:
    task = st.load_task(ROOT / scene)
    plan = st.plan(task, seed=1).plan
    (file,) = plan.export(tmp_path / "motion.npz")
    reference = Reference(task, st.read_demonstration(file, task), 1)
    assert reference.task.goal_objects == task.goal_objects
    assert reference.task.q_goal == pytest.approx(plan.q[-1][: task.model.n_qu], abs=1e-9)
    aside = reference.q[-1].copy()
    aside[task.model.objects[task.goal_objects[-1]].q_begin] += 0.04  # the last of them
    for off, expected in zip(off_by(task, aside[None], reference.q[-1:]), task.with_(goal=reference.task.q_goal).goal_errors(aside[None])[0], strict=True):
        assert off[0] == pytest.approx(expected, abs=1e-7)
    assert max(off[0] for off in off_by(task, aside[None], reference.q[-1:])) > 0.03


def test_command_repairs_a_file(stiction, write: Callable[..., Path], tmp_path: Path) -> None:
    done = stiction("repair", "planar_hand", write(), "-o", tmp_path / "out", "--json")
    assert done.returncode == 0, done.stdout + done.stderr
    out = json.loads(done.stdout)
    assert out["complete"] and out["accepted"] and out["changes"] and st.check_plan(st.read_plan(out["plan"])).pass_


# ---- reading


def test_joints_are_found_by_their_names_in_any_order(task: st.Task, table: list[list[str]], write: Callable[..., Path]) -> None:
    plain = st.read_demonstration(write(), task)
    poses = [name for name in table[0] if name.startswith("ball_")]
    joints = [f"q_{name}" for name in ("right/joint_2", "left/joint_1", "right/joint_1", "left/joint_2")]
    other = st.read_demonstration(write(columns=[*joints, *poses, "time_s"], rename=lambda name: name.removeprefix("q_")), task)
    np.testing.assert_array_equal(other.joints, plain.joints)
    assert other.commands is None and plain.commands is not None
    assert other.notes == ["joints are taken by their names, which stand in another order than in the model: right/joint_2, left/joint_1, right/joint_1, left/joint_2"]
    assert not plain.notes


def test_arrays_are_read_as_the_table_is(task: st.Task, write: Callable[..., Path], tmp_path: Path) -> None:
    from_table = st.read_demonstration(write(), task)
    (file,) = st.plan(task, seed=0, options={"friction": 0.8}).plan.export(tmp_path / "motion.npz")
    from_arrays = st.read_demonstration(file, task)
    for name in ("time", "joints", "commands", "poses"):
        np.testing.assert_allclose(getattr(from_arrays, name), getattr(from_table, name), atol=1e-12)
    with np.load(file) as data:
        arrays = {name: data[name] for name in data.files}
    np.savez(tmp_path / "short.npz", **{name: value for name, value in arrays.items() if name != "poses"})
    with pytest.raises(st.InvalidInput, match="short.npz: poses: got no such array among .* expected arrays of a demonstration with time, q, joints, poses, objects"):
        st.read_demonstration(tmp_path / "short.npz", task)
    np.savez(tmp_path / "wide.npz", **arrays | {"q": arrays["q"][:, :2]})
    with pytest.raises(st.InvalidInput, match=r"wide.npz: q: got the shape"):
        st.read_demonstration(tmp_path / "wide.npz", task)


def scaled(names: str, factor: float) -> Callable[[str, int, str], str]:
    return lambda name, row, value: repr(float(value) * factor) if re.search(names, name) else value


def test_millimetres_and_degrees_are_seen_and_read_when_asked(task: st.Task, write: Callable[..., Path]) -> None:
    plain = st.read_demonstration(write(), task)
    file = write(scaled("_[xyz]$", 1000))
    with pytest.raises(st.InvalidInput, match=r"demo.csv: got positions of \d+ m, where the task has 1 m; are they millimetres\? --unit mm"):
        st.read_demonstration(file, task)
    np.testing.assert_allclose(st.read_demonstration(file, task, unit="mm").poses, plain.poses, atol=1e-12)
    file = write(scaled("^q_", 180 / np.pi))
    with pytest.raises(st.InvalidInput, match=r"demo.csv: got joint angles of \d+ rad; are they degrees\? --angle deg"):
        st.read_demonstration(file, task)
    np.testing.assert_allclose(st.read_demonstration(file, task, angle="deg").joints, plain.joints, atol=1e-12)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda name, row, value: repr(float(value) + 0.5) if name == "ball_y" and row >= 10 else value, r"ball: got a jump by 0.5\d\d m .* was the object lost from sight\?"),
        (lambda name, row, value: repr(float(value) + 4) if name == "q_left/joint_1" and row >= 30 else value, r"left/joint_1: got a jump by [34]\.\d+ between"),
        (lambda name, row, value: "0" if name == "time_s" and row == 5 else value, r"time_s: got 0 after"),
        (lambda name, row, value: "nan" if name == "q_left/joint_1" and row == 5 else value, "joints: got a number that is not finite at time 5"),
        (lambda name, row, value: "none" if name == "ball_x" and row == 5 else value, "demo.csv:7: ball_x: got 'none', expected a number"),
        (lambda name, row, value: repr(2 * float(value)) if name == "ball_qw" else value, r"quaternion of object 0: got length"),
    ],
)
def test_series_that_are_none_are_refused_with_their_place(task: st.Task, write: Callable[..., Path], change: Callable[[str, int, str], str], message: str) -> None:
    with pytest.raises(st.InvalidInput, match=message):
        st.read_demonstration(write(change), task)


def test_columns_that_are_missing_are_named(task: st.Task, table: list[list[str]], write: Callable[..., Path], tmp_path: Path) -> None:
    for missing, message in (
        ("time_s", "demo.csv: time_s: got no such column"),
        ("q_left/joint_2", "demo.csv: joint left/joint_2: got none, expected one of that name"),
        ("ball_qw", "demo.csv: ball_qw: got no such column"),
    ):
        with pytest.raises(st.InvalidInput, match=re.escape(message)):
            st.read_demonstration(write(columns=[name for name in table[0] if name != missing and name != f"q_cmd_{missing[2:]}"]), task)
    some = st.read_demonstration(write(columns=[name for name in table[0] if name != "q_cmd_left/joint_2"]), task)
    assert some.commands is None and some.notes == ["commands are not read, because there is no column q_cmd_left/joint_2"]
    with pytest.raises(st.InvalidInput, match="got the ending '.txt', expected .csv or .npz"):
        st.read_demonstration(tmp_path / "demo.txt", task)
    with pytest.raises(st.InvalidInput, match="none.csv: cannot be read"):
        st.read_demonstration(tmp_path / "none.csv", task)


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.replace("\n", "\r\n"),
        lambda text: "\ufeff" + text,
        lambda text: text.replace(",", ";"),
        lambda text: text.replace(",", ";").replace(".", ","),
        lambda text: text.replace(",", "\t"),
        lambda text: "# recorded\n\n" + text.replace("\n", "\n\n"),
    ],
    ids=["CRLF", "byte order mark", "semicolons", "decimal commas", "tabs", "comments and empty lines"],
)
def test_tables_of_other_programs_are_read(task: st.Task, write: Callable[..., Path], change: Callable[[str], str]) -> None:
    file = write()
    plain = st.read_demonstration(file, task)
    file.write_bytes(change(file.read_bytes().decode().replace("\r\n", "\n")).encode())
    read = st.read_demonstration(file, task)
    for name in ("time", "joints", "commands", "poses"):
        np.testing.assert_array_equal(getattr(read, name), getattr(plain, name))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda lines: [lines[0] + ",ball_x"] + [line + ",1" for line in lines[1:]], "demo.csv: got the column 'ball_x' more than once"),
        (lambda lines: [*lines[:4], "", lines[4] + ",1", *lines[5:]], r"demo.csv:6: got \d+ cells, expected \d+, one for each name"),
        (lambda lines: [lines[0], "1_0" + lines[1], *lines[2:]], "demo.csv:2: time_s: got '1_0"),
        (lambda lines: ['"' + lines[0], *lines[1:] * 9], "demo.csv: cannot be read .*field larger than field limit"),
    ],
    ids=["a column twice", "a longer row", "digits with underscores", "an open quote"],
)
def test_tables_that_can_be_read_in_two_ways_are_refused(task: st.Task, write: Callable[..., Path], change: Callable[[list[str]], list[str]], message: str) -> None:
    file = write()
    file.write_text("\n".join(change(file.read_text().splitlines())) + "\n")
    with pytest.raises(st.InvalidInput, match=message):
        st.read_demonstration(file, task)


def test_archives_that_are_damaged_or_hold_other_arrays_are_refused(task: st.Task, tmp_path: Path) -> None:
    file = tmp_path / "demo.npz"
    st.plan(task, seed=0).plan.export(file)
    whole, arrays = file.read_bytes(), dict(np.load(file))
    broken = bytearray(whole)
    broken[len(whole) // 3] ^= 0xFF
    for content in (b"", whole[:200], whole[:-100], bytes(broken)):
        file.write_bytes(content)
        for read in (st.read_demonstration, st.read_grasps):
            with pytest.raises(st.InvalidInput, match="demo.npz: cannot be read"):
                read(file, task)
    for name, value in {
        "time": arrays["time"][:, None], "q": arrays["q"].astype(complex), "joints": np.array("left"), "poses": arrays["poses"][:, 0],
        "q_cmd": arrays["q_cmd"][:3], "objects": np.array(["cup"]),
    }.items():  # fmt: skip
        np.savez(file, **arrays | {name: value})
        with pytest.raises(st.InvalidInput, match="demo.npz: "):
            st.read_demonstration(file, task)
    with file.open("wb") as out:
        np.save(out, arrays["q"])
    with pytest.raises(st.InvalidInput, match="demo.npz: cannot be read .no archive of numpy.savez."):
        st.read_demonstration(file, task)


def test_joints_beyond_their_limits_are_named(write: Callable[..., Path]) -> None:
    ball = st.load_task("allegro_ball")
    time = np.array([0.0, 1.0])
    poses = np.zeros((2, 1, 7))
    poses[:, 0, 6] = 1
    joints = np.tile(ball.q_start[-16:], (2, 1))
    joints[1, 3] = 3.0
    file = write().parent / "far.npz"
    np.savez(file, time=time, q=joints, joints=np.array(ball.model.joint_names), poses=poses, objects=np.array(["ball"]))
    name = re.escape(ball.model.joint_names[3])
    with pytest.raises(st.InvalidInput, match=rf"{name}: got 3.000 at 1.00 s, expected .* are joints in another order"):
        st.read_demonstration(file, ball)
