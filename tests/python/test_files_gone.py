"""What is loaded stays loaded: tasks and plans work on when their files are gone, or the working folder is another one."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import stiction as st

HAND = """<robot name="hand"><link name="world"/><link name="rail"/><link name="ball"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>
<joint name="jx" type="prismatic"><parent link="world"/><child link="rail"/><axis xyz="1 0 0"/><limit lower="-2" upper="2" effort="1000" velocity="0.5"/></joint>
<joint name="jy" type="prismatic"><parent link="rail"/><child link="ball"/><axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="1000" velocity="1"/></joint></robot>"""


def push_task() -> dict[str, Any]:
    """A ball on two springs pushes a box in the plane."""
    return {
        "name": "own_push",
        "scene": {
            "gravity": [0, 0, 0],
            "contact_distance": 1.0,
            "robots": [{"name": "hand", "urdf": "hand.urdf", "stiffness": 500}],
            "objects": [{"name": "box", "joint": "planar_xy", "mass": 1.0, "friction": 0.5, "shapes": [{"box": {"size": [0.3, 0.3, 0.3]}}]}],
        },
        "start": {"objects": {"box": {"coordinates": [0.4, 0, 0]}}, "joints": [0, 0]},
        "goal": {"objects": {"box": {"coordinates": [0.6, 0, 0.2]}}},
        "tolerance": {"position": 0.02, "angle": 0.1},
    }


@pytest.fixture
def elsewhere(tmp_path: Path) -> Iterator[Path]:
    """A folder to work in and to leave; the working folder is the same afterwards."""
    before = Path.cwd()
    folder = tmp_path / "work"
    folder.mkdir()
    (folder / "hand.urdf").write_text(HAND, encoding="utf-8")
    yield folder
    os.chdir(before)


def use(task: st.Task, out: Path) -> None:
    """Everything that follows from a task."""
    assert st.lint(task) == []
    assert np.array_equal(task.model.speed_limit, [0.5, 1.0])
    assert task.with_(goal=[0.5, 0, 0]).q_goal[0] == 0.5
    plan = st.plan(task, seed=0, timeout_s=60).plan
    assert plan.status == st.Status.Solved
    assert st.check_plan(plan).pass_
    trajectory = st.make_trajectory(plan)
    assert len(trajectory.times) == len(trajectory.u)
    plan.export(out / "motion.csv")
    assert (out / "motion.csv").stat().st_size > 0
    assert st.transfer(plan, alone=False) is not None
    assert st.view(plan, html=out / "plan.html") == out / "plan.html"


def test_task_works_on_when_its_folder_is_deleted(elsewhere: Path, tmp_path: Path) -> None:
    (elsewhere / "task.yaml").write_text(json.dumps(push_task()), encoding="utf-8")
    task = st.load_task(elsewhere / "task.yaml")
    shutil.rmtree(elsewhere)
    use(task, tmp_path)


@pytest.mark.parametrize("load", [lambda: st.load_task("./task.yaml"), lambda: st.Task(push_task())], ids=["file", "dict"])
def test_task_works_on_from_another_folder(load: Any, elsewhere: Path, tmp_path: Path) -> None:
    (elsewhere / "task.yaml").write_text(json.dumps(push_task()), encoding="utf-8")
    os.chdir(elsewhere)
    task = load()
    os.chdir("/")
    use(task, tmp_path)


def test_task_is_not_changed_by_an_edit_of_the_robot(elsewhere: Path, tmp_path: Path) -> None:
    task = st.Task(push_task(), base=elsewhere)
    (elsewhere / "hand.urdf").write_text(HAND.replace("0.5", "0.01"), encoding="utf-8")
    use(task, tmp_path)
