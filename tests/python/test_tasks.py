"""Every built-in task that is planned for is planned to its goal, within a budget of processor time, and `check` accepts the plan."""

from __future__ import annotations

import json
import resource
import sys
from pathlib import Path

import children
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))
from search import TASKS  # noqa: E402

BUDGET = 120  # processor seconds; a plate takes 15 on average


@pytest.mark.parametrize("task", TASKS)
def test_task_is_planned_to_its_goal_and_accepted(program: Path, tmp_path: Path, task: str) -> None:
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    words = ["plan", task, "--seed", 0, "--threads", 1, "--timeout", 20 * BUDGET, "-o", tmp_path, "--json"]
    done = children.run([program, *words], limit=280)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    assert done.returncode == 0, done.stderr
    out = json.loads(done.stdout)
    assert out["status"] == "Solved" and not out["thesis_edges"]
    assert after.ru_utime - before.ru_utime < BUDGET
    checked = children.run([program, "check", tmp_path], limit=120)
    assert checked.returncode == 0, checked.stdout


@pytest.mark.parametrize("seed", [10030, 10086])
def test_a_regrasp_goes_no_deeper_than_the_checker_allows(program: Path, tmp_path: Path, seed: int) -> None:
    """With these seeds the wrist went 1.6 mm into the table in a regrasp."""
    done = children.run([program, "plan", "ur5_mesh_push", "--seed", seed, "--threads", 1, "--timeout", 20 * BUDGET, "-o", tmp_path], limit=280)
    assert done.returncode == 0, done.stderr
    checked = children.run([program, "check", tmp_path], limit=120)
    assert checked.returncode == 0, checked.stdout


def test_the_list_of_tasks_is_whole(root: Path) -> None:
    """Tasks of the tables of the thesis and of trajectory optimisation are not planned for."""
    names = {path.stem for path in (root / "tasks").glob("*.yaml")}
    assert set(TASKS) == {name for name in names if "_table_3_2" not in name and not name.startswith("impc_")}
