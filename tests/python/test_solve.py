"""`stiction solve`: a plan that reaches its goal in the second-order simulation, or the best one with the reason."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import yaml



def test_solved_plan_is_accepted_and_reaches_its_goal_when_simulated_by_itself(stiction, tmp_path: Path) -> None:
    done = stiction("solve", "planar_pushing", "--seed", 3, "-o", tmp_path, "--json")
    assert done.returncode == 0, done.stderr
    out = json.loads(done.stdout)
    assert out["status"] == "Held"
    assert [t["seed"] for t in out["tries"]] == list(range(3, out["seed"] + 1)), "seeds in turn, up to the first that holds"
    assert all(run["reached"] for run in out["tries"][-1]["runs"])
    assert stiction("check", tmp_path).returncode == 0
    again = stiction("simulate", tmp_path, "--whole-only", "--json")
    assert again.returncode == 0, again.stderr
    assert json.loads(again.stdout)["error"]["position"] == pytest.approx(out["tries"][-1]["runs"][0]["error"]["position"], abs=1e-9)
    assert (tmp_path / "trajectory.csv").read_text().startswith("time_s,")


def test_tries_side_by_side_give_the_plan_of_one_after_the_other(stiction, tmp_path: Path) -> None:
    plans, seeds = [], []
    for threads in (1, 3):
        out = tmp_path / str(threads)
        done = stiction("solve", "iiwa_bimanual_planar", "--seed", 3, "--threads", threads, "--tries", 5, "-o", out, "--json")
        assert done.returncode == 0, done.stderr
        report = json.loads(done.stdout)
        seeds.append((report["seed"], [t["seed"] for t in report["tries"]]))
        plans.append([knot["u"] for segment in json.loads((out / "plan.json").read_text())["segments"] for knot in segment["knots"]])
    assert seeds[0] == seeds[1]
    assert plans[0] == plans[1]


def test_plan_that_does_not_hold_is_kept_and_said_so(stiction, tmp_path: Path) -> None:
    """Without friction no finger carries a ball round."""
    done = stiction("solve", "planar_hand", "--friction", "1,0", "--tries", 4, "--speed", 0.3, "-o", tmp_path, "--json")
    assert done.returncode == 3, done.stderr
    out = json.loads(done.stdout)
    assert out["status"] == "NotHeld" and len(out["tries"]) == 4
    assert any(len(t["runs"]) == 2 and t["runs"][0]["reached"] and not t["runs"][1]["reached"] for t in out["tries"])
    assert all(set(run) == {"friction", "reached", "dropped", "lost", "duration_s", "error"} for t in out["tries"] for run in t["runs"])
    assert stiction("check", tmp_path).returncode == 0
    assert "friction × 0: " in done.stderr, "beside JSON the text for people is on stderr"


def test_interrupted_run_keeps_the_best_plan(interrupted, root: Path, tmp_path: Path) -> None:
    endless = tmp_path / "task.yaml"
    out_of_reach = {"goal": {"objects": {"ball": {"coordinates": [0, 3, 0]}}}, "planner": {"max_iterations": 2**31 - 1}}
    endless.write_text(yaml.safe_dump({"base": str(root / "tasks/planar_hand.yaml"), **out_of_reach}))
    done = interrupted("solve", endless, "--timeout", 60, "-o", tmp_path, "--json")
    assert done.returncode == 130, done.stderr
    assert json.loads(done.stdout)["status"] == "Cancelled"
    assert json.loads((tmp_path / "plan.json").read_text())["status"] == "Cancelled"


@pytest.mark.parametrize(
    "arguments, parts",
    [
        (("no_task",), ("no_task",)),
        (("planar_pushing", "--tries", "0"), ("--tries",)),
        (("planar_pushing", "--friction", "-1"), ("--friction",)),
        (("planar_pushing", "--friction", "1,x"), ("--friction", "x")),
        (("planar_pushing", "--goal", "1"), ("goal", "1 numbers")),
    ],
)
def test_mistakes_have_one_clear_message(stiction, tmp_path: Path, arguments: tuple, parts: tuple) -> None:
    done = stiction("solve", *arguments, "-o", tmp_path / "out")
    assert done.returncode == 2 and done.stdout == ""
    assert all(part in done.stderr for part in parts), done.stderr
    assert not (tmp_path / "out/plan.json").exists()
