"""`stiction run` with goals in a row: from the command line, a file and Python; what is reported, exit codes, and what is said of a wrong one."""

from __future__ import annotations

import json
import pickle
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
MODULE = ROOT / "build" / "release" / "python"
if not (MODULE / "stiction").is_dir():
    pytest.skip(f"{MODULE} does not exist: run `make build`", allow_module_level=True)
sys.path.insert(0, str(MODULE))

import stiction as st  # noqa: E402

ONE, TWO = [0, 0.35, 0.4], [0, 0.35, -0.3]  # of the ball in planar_hand
SAME = {"seed": 1, "plan_step_time_s": 1e-4}  # the same on every machine


@pytest.fixture(scope="module")
def two(stiction, tmp_path_factory: pytest.TempPathFactory) -> tuple[dict, str, Path]:
    """Two goals, one after the other."""
    folder = tmp_path_factory.mktemp("goals")
    goals = ("--goal", " ".join(map(str, ONE)), "--goal", " ".join(map(str, TWO)))
    done = stiction("run", "planar_hand", *goals, "--seed", 1, "--plan-step-time", "1e-4", "--html", "--json", "-o", folder, timeout=300)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout), done.stderr, folder


def test_goals_are_reached_one_after_another(two: tuple[dict, str, Path]) -> None:
    out, text, folder = two
    assert out["status"] == "Reached" and out["reached"]
    assert out["goals_given"] == out["goals_reached"] == 2
    first, second = out["goals"]
    assert first["reached"] and second["reached"]
    assert 0 == first["begin_s"] < first["end_s"] == second["begin_s"] < second["end_s"] <= out["duration_s"] + 0.1
    for goal in (first, second):
        assert goal["error"]["position"] <= out["tolerance"]["position"] and goal["error"]["angle"] <= out["tolerance"]["angle"]
    assert first["replans"] + second["replans"] == out["replans"]
    assert [plan["cause"] for plan in out["plans"]].count("the next goal") == 1
    assert "2 goals reached" in text and "2 of 2 reached" in text and "goal 2 reached" in text
    assert json.loads((folder / "run.json").read_text())["report"]["goals"] == out["goals"]
    assert "closed loop" in (folder / "run.html").read_text()


def test_python_does_the_same(two: tuple[dict, str, Path]) -> None:
    task = st.load_task("planar_hand")
    seen = []
    run = st.run(task, goals=[ONE, np.array(TWO)], on_sample=lambda sample: seen.append(sample.goal), **SAME)
    out, _, _ = two
    assert run.reached and run.goals_reached == len(run.goals) == 2
    assert [goal.end_s for goal in run.goals] == [goal["end_s"] for goal in out["goals"]]
    assert run.duration_s == out["duration_s"] and run.true_error.angle == pytest.approx(out["true_error"]["angle"], abs=1e-12)
    assert seen == sorted(seen) and set(seen) == {0, 1} and len(seen) == len(run.times)
    again = pickle.loads(pickle.dumps(run))
    assert again.goals[1].end_s == run.goals[1].end_s and again.goals[0].reached
    assert task.q_goal == pytest.approx(st.load_task("planar_hand").q_goal), "the task keeps its goal"


def test_goals_of_a_file(stiction, tmp_path: Path) -> None:
    file = tmp_path / "goals.yaml"
    file.write_text(f"- {ONE}\n- {{objects: {{ball: {{coordinates: [~, ~, -0.3]}}}}}}\n")
    run = st.run(st.load_task("planar_hand"), goals=file, **SAME)
    assert run.reached and run.goals_reached == 2
    file.write_text("- [0, 0.35, 0.4]\n- [0, 0.35]\n- [0, 0.35, 0]\n")
    done = stiction("run", "planar_hand", "--goals", file)
    assert done.returncode == 2 and f"goal 2 of 3 in {file}:2: got 2 numbers, expected 3" in done.stderr
    for option, words in (
        (("--goals", tmp_path / "none.yaml"), "none.yaml"),
        (("--goals", file, "--goal", "0 0 0"), "--goals: got a file beside --goal, expected one of the two"),
        (("--goal", "0 0.35 0", "--goal", "1 2"), "--goal 2 of 2: got 2 numbers, expected 3"),
        (("--hold", -1), "--hold: got '-1', expected a number ≥ 0"),
    ):
        done = stiction("run", "planar_hand", *option)
        assert done.returncode == 2 and words in done.stderr, done.stderr


def test_goal_that_is_not_reached_ends_the_run(stiction) -> None:
    """The ball is far out of reach of both arms."""
    goals = ("--goal", " ".join(map(str, ONE)), "--goal", "5 5 0", "--goal", " ".join(map(str, TWO)))
    done = stiction("run", "planar_hand", *goals, "--seed", 1, "--plan-step-time", "1e-4", "--replans", 1, "--duration", 60, "--json", timeout=300)
    assert done.returncode == 3, done.stderr
    out = json.loads(done.stdout)
    assert not out["reached"] and out["goals_given"] == 3 and out["goals_reached"] == 1
    assert [goal["reached"] for goal in out["goals"]] == [True, False], "the third was not begun"
    assert out["message"].startswith("goal 2 of 3: ") and out["error"]["position"] > 1
    assert "1 of 3 reached" in done.stderr and "goal 2 not reached" in done.stderr


def test_time_is_that_of_all_goals(two: tuple[dict, str, Path]) -> None:
    out, _, _ = two
    run = st.run(st.load_task("planar_hand"), goals=[ONE, TWO], duration=out["goals"][0]["end_s"] + 0.3, **SAME)
    assert run.end == st.RunEnd.TimeUp and run.goals_reached == 1 and not run.reached
    assert run.goals[0].end_s == out["goals"][0]["end_s"]


def test_object_that_falls_in_between() -> None:
    """A ball lies at the first goal; once that was held a blow throws it out of the hand."""
    task = st.load_task("allegro_ball")
    start = task.model.object_poses(task.q_start[None], task.model.object_names[0])[0][:3].tolist()
    turned = {"objects": {task.model.object_names[0]: {"position": start, "rpy": [0, 0, 1.5]}}}
    run = st.run(task, goals=[[*start, None, None, None], turned], pushes=[(1.5, 0.1, [0.3, 0, 0])], duration=20, finger_gait=False, plan_step_time_s=1e-3, seed=1)
    assert run.end == st.RunEnd.Dropped and run.goals_reached == 1, run.message
    assert run.message.startswith("goal 2 of 2: ") and run.dropped == 0


def test_goal_that_need_not_be_held_counts_at_once() -> None:
    task = st.load_task("planar_hand")
    held, at_once = (st.run(task, goals=[ONE, TWO], hold=hold, **SAME) for hold in (0.5, 0))
    assert held.reached and at_once.reached
    assert at_once.goals[0].end_s < held.goals[0].end_s - 0.4 and at_once.duration_s < held.duration_s - 0.8


TWO_BOXES = {
    "scene": {
        "robots": [{"name": "ball", "mjcf": "<mujoco><worldbody><body name='rail'><body name='ball'><joint name='x' type='slide' axis='1 0 0' range='-3 3' limited='true'/><joint name='y' type='slide' axis='0 1 0' range='-3 3' limited='true'/><geom name='tip' size='0.1' mass='1'/></body></body></worldbody>"
                    "<actuator><position joint='x' kp='500' kv='20' forcerange='-50 50'/><position joint='y' kp='500' kv='20' forcerange='-50 50'/></actuator></mujoco>"}],
        "objects": [{"name": name, "joint": "planar_xy", "mass": 1.0, "shapes": [{"box": {"size": [0.4, 0.4, 0.4]}}]} for name in "ab"],
    },
    "start": {"objects": {"a": {"coordinates": [0.6, 0.5, 0]}, "b": {"coordinates": [-0.6, 0.5, 0]}}, "joints": [0, 0]},
    "goal": {"objects": {"a": {"coordinates": [0.6, 0.7, None]}}},
    "tolerance": {"position": 0.03, "angle": 0.2},
}  # fmt: skip


def test_each_goal_may_be_about_another_object() -> None:
    task = st.Task(TWO_BOXES)
    goals = [{"objects": {"a": {"coordinates": [0.6, 0.7, None]}}}, {"objects": {"b": {"coordinates": [-0.6, 0.7, None]}}}]
    run = st.run(task, goals=goals, **SAME)
    assert run.reached, run.message
    q = run.q[-1]
    assert np.allclose(q[:2], [0.6, 0.7], atol=0.06) and np.allclose(q[3:5], [-0.6, 0.7], atol=0.03)


def test_what_are_no_goals(real_plan: Path) -> None:
    task = st.load_task("planar_hand")
    for goals, words in (
        ([], "goals: got an empty list, expected a list of goals"),
        ([ONE, [1, 2]], r"goals\[1\]: got 2 numbers, expected 3"),
        ([ONE, {"objects": {"cup": {"coordinates": [0, 0, 0]}}}], r"goals\[1\].objects.cup: got unknown object 'cup'"),
        ([ONE, [0, float("nan"), 0]], r"goals\[1\]\[1\]: got .nan"),
        ([ONE, object()], r"goals\[1\]: got a value of type object"),
    ):
        with pytest.raises(st.InvalidInput, match=words):
            st.run(task, goals=goals)
    with pytest.raises(st.InvalidInput, match="goals: got goals with a plan, expected None: a plan has its own"):
        st.run(st.read_plan(real_plan), goals=[ONE])
    with pytest.raises(st.InvalidInput, match="hold: got -1"):
        st.run(task, hold=-1)
