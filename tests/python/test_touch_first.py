"""Guarded moves before a run: a table that is not where the task says is felt, and planned for where it is."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
MODULE = ROOT / "build" / "release" / "python"
if not (MODULE / "stiction").is_dir():
    pytest.skip(f"{MODULE} does not exist: run `make build`", allow_module_level=True)
sys.path.insert(0, str(MODULE))

import stiction as st  # noqa: E402

FAR = 3  # a seed whose table is 20 mm higher than the task says


def moves() -> dict:
    text = yaml.safe_load((ROOT / "scenarios" / "feel_table.yaml").read_text(encoding="utf-8"))
    return text | {"task": str(ROOT / "tasks" / "ur5_mesh_push.yaml")}


def height(model: st.Model) -> float:
    return float(model.body_poses(model.neutral())["table"].p[2])


def run(touch_first, **more) -> st.RunResult:
    return st.run(st.load_task("ur5_mesh_push"), touch_first=touch_first, seed=FAR, duration=1, replans=0, plan_step_time_s=2e-5, **more)


def test_run_plans_for_the_table_that_was_felt_and_not_for_the_one_of_the_task(tmp_path: Path) -> None:
    felt = run("feel_table")
    really = height(felt.touch.world)
    assert really > 0.015, "the height was right: the test would say nothing"
    assert felt.touch.reached and abs(height(felt.touch.model) - really) < 3e-3 and abs(felt.touch.places["table"].p[2] - really) < 3e-3
    assert felt.plans[0].status == st.Status.Solved, felt.plans[0].reason
    task = st.load_task("ur5_mesh_push")
    stands = task.model.object_pose(task.q_start, "block").p[2]
    assert abs(task.model.object_pose(felt.q[0], "block").p[2] - stands - really) < 1e-3
    assert abs(felt.touch.moves[2].late_peak) <= 1.2 * 5

    (tmp_path / "blind.yaml").write_text(yaml.safe_dump({key: value for key, value in moves().items() if key != "moves"}), encoding="utf-8")
    blind = run(tmp_path / "blind.yaml")
    assert blind.touch.places == {} and height(blind.touch.world) == really and height(blind.touch.model) == 0


def test_run_does_not_begin_where_nothing_is_felt() -> None:
    text = moves()
    text["moves"][2] |= {"travel": 0.002}
    done = run(st.load_touch_scenario(text, base=ROOT))
    assert done.end == st.RunEnd.Unfelt and not done.reached and done.status == st.Status.MaxIterations
    assert done.message == "before the run: feel: nothing was felt within 0.002 m"
    assert done.plans == [] and [move.outcome for move in done.touch.moves][-1] == st.MoveOutcome.NotFelt


def test_moves_that_cannot_go_before_the_run_are_refused() -> None:
    task = st.load_task("ur5_mesh_push")
    with pytest.raises(st.InvalidInput, match="touch_first: got moves beside a plant of one's own"):
        st.run(task, touch_first="feel_table", plant=st.SimulatedPlant(task))
    with pytest.raises(st.InvalidInput, match="touch_first: got a scenario with another scene than that of task 'ur5_mesh_push'"):
        st.run(task, touch_first=st.load_touch_scenario("lower_until_touch"))
    with pytest.raises(st.InvalidInput, match="scene: got a scene of its own, expected `task: ur5_mesh_push`"):
        st.run(task, touch_first="lower_until_touch")


def test_command_tells_of_the_moves_and_its_plan_knows_the_place(stiction, tmp_path: Path) -> None:
    done = stiction("run", "ur5_mesh_push", "--touch-first", "feel_table", "--seed", FAR, "--duration", 1, "--replans", 0, "--json", "-o", tmp_path)
    assert done.returncode == 3, done.stderr
    out = json.loads(done.stdout)
    feel = out["touch"]["moves"][2]
    assert out["touch"]["status"] == "Passed" and feel["outcome"] == "Felt" and abs(feel["correction_error"]) < 3e-3
    plan = st.read_plan(tmp_path / "plan.json")
    assert abs(height(plan.task.model) + feel["correction"]) < 1e-12, "the move goes down, and the table is higher"


def test_a_given_plan_is_planned_anew_for_the_table_that_was_felt(stiction, tmp_path: Path) -> None:
    given = st.plan(st.load_task("ur5_mesh_push"), seed=1, threads=1).plan
    given.write(tmp_path / "plan.json")
    before = (tmp_path / "plan.json").read_bytes()
    felt = st.run(given, touch_first="feel_table", seed=FAR, duration=3, replans=0, threads=1)
    assert len(felt.plans) == 1, "the given one is for another table"

    done = stiction("run", tmp_path / "plan.json", "--touch-first", "feel_table", "--seed", FAR, "--duration", 3, "--replans", 0, "--json", "-o", tmp_path)
    out = json.loads(done.stdout)
    assert len(out["plans"]) == 1
    plan = st.read_plan(tmp_path / "felt_plan.json")
    assert abs(height(plan.task.model) - height(felt.touch.model)) < 1e-12, "the plan that is written is on the table that was felt"
    assert (tmp_path / "plan.json").read_bytes() == before, "the given one stays"
