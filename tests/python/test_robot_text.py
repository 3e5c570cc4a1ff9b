"""Robots that a task has as a text: planned, written, pickled, read and checked where there is no file of theirs."""

from __future__ import annotations

import os
import pickle
import shutil
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PYTHON = ROOT / "build" / "release" / "python"
if not (PYTHON / "stiction").is_dir():
    pytest.skip("build/release/python/stiction does not exist: run `make build`", allow_module_level=True)
sys.path.insert(0, str(PYTHON))

import stiction as st  # noqa: E402

PUSHER = (ROOT / "models" / "planar_pusher.urdf").read_text()
PUSHER_MJCF = """<mujoco model="pusher"><worldbody>
  <body name="ball"><joint name="y" type="slide" axis="0 1 0"/><joint name="z" type="slide" axis="0 0 1"/><geom size="0.05" friction="0.8"/></body>
</worldbody></mujoco>"""


def task_of(**robot: object) -> dict:
    return {
        "name": "push",
        "scene": {
            "gravity": [0, 0, 0],
            "contact_distance": 1.0,
            "robots": [{"name": "hand", "stiffness": 200, **robot}],
            "objects": [{"name": "box", "joint": "planar_yz", "mass": 2.0, "shapes": [{"box": {"size": [0.4, 0.4, 0.4]}, "friction": 0.6}]}],
        },
        "start": {"objects": {"box": {"coordinates": [0.5, 0.0, 0.0]}}, "joints": [0.0, 0.0]},
        "goal": {"objects": {"box": {"coordinates": [0.6, 0.0, 0.0]}}},
        "tolerance": {"position": 0.02, "angle": 0.1},
    }


@pytest.mark.parametrize("robot", [{"urdf": PUSHER}, {"mjcf": PUSHER_MJCF}], ids=["urdf", "mjcf"])
def test_plan_is_read_back_and_checked_elsewhere(robot: dict, tmp_path: Path, stiction) -> None:
    made, away = tmp_path / "made", tmp_path / "away"
    made.mkdir()
    task = st.Task(task_of(**robot), base=made)
    result = st.plan(task, seed=0, timeout_s=30)
    assert result.status == st.Status.Solved
    result.plan.write(made / "plan.json")
    away.mkdir()
    shutil.move(made / "plan.json", away)
    made.rmdir()  # nothing of the robot is on the disk but in the plan
    again = st.read_plan(away / "plan.json")
    assert again.task.scene_sha256 == task.scene_sha256
    assert st.check_plan(again).pass_ and st.check_plan(pickle.loads(pickle.dumps(again))).pass_
    told = stiction("check", away / "plan.json")
    assert told.returncode == 0, told.stdout + told.stderr


def test_another_text_is_another_scene(tmp_path: Path) -> None:
    first = st.Task(task_of(urdf=PUSHER), base=tmp_path)
    assert st.Task(task_of(urdf=PUSHER + "\n"), base=tmp_path).scene_sha256 != first.scene_sha256


@pytest.mark.parametrize(
    ("urdf", "message"),
    [
        ("<robot><link name='a'/></robot", r"^scene\.robots\[0\]\.urdf: text:1: urdf: got malformed XML"),
        (PUSHER.replace('radius="', 'radius="-'), r"^scene\.robots\[0\]\.urdf: text:\d+: sphere radius: got -"),
        ("no robot\nbut lines", r"^scene\.robots\[0\]\.urdf: got 'no robot…', which does not exist, expected a URDF file, or its text$"),
    ],
)
def test_mistakes_name_field_and_line(urdf: str, message: str) -> None:
    with pytest.raises(st.InvalidInput, match=message):
        st.Task(task_of(urdf=urdf))


def test_messages_quote_names_in_any_encoding(tmp_path: Path) -> None:
    """A folder of an old system, in Latin-1."""
    folder = Path(os.fsdecode(os.fsencode(tmp_path) + b"/gr\xfcn"))
    folder.mkdir()
    (folder / "r.urdf").write_text("<robot name='r'/>")
    (folder / "scene.yaml").write_text("robots: [{name: r, urdf: r.urdf}]")
    with pytest.raises(st.InvalidInput, match=r"gr\\xfcn/r.urdf:1: robot: got no link, expected at least one"):
        st.load_model(folder / "scene.yaml")
    with pytest.raises(st.InvalidInput, match=r"robots\[0\].urdf: got '.*', which has no UTF-8, expected text in UTF-8"):
        st.load_model({"robots": [{"name": "r", "urdf": folder / "r.urdf"}]})
