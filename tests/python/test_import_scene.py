"""Scenes that are in one MJCF file: imported by the program and by Python, planned, and run from starts that overlap."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import jsonschema
import numpy as np
import pytest
import referencing
import yaml

ROOT = Path(__file__).resolve().parents[2]
PYTHON = ROOT / "build" / "release" / "python"
if not (PYTHON / "stiction").is_dir():
    pytest.skip("build/release/python/stiction does not exist: run `make build`", allow_module_level=True)
sys.path.insert(0, str(PYTHON))

import stiction as st  # noqa: E402

SCHEMAS = {path.name: json.loads(path.read_text()) for path in (ROOT / "tasks/schema").glob("*.schema.json")}
REGISTRY = referencing.Registry().with_resources((name, referencing.Resource.from_contents(schema)) for name, schema in SCHEMAS.items())
VALIDATOR = jsonschema.Draft202012Validator(SCHEMAS["task.schema.json"], registry=REGISTRY)

# A finger on two slides beside a drawer that only pushing against its back opens.
DRAWER = """<mujoco><option gravity="0 0 -9.81"/><worldbody>
  <geom name="table" type="plane" size="1 1 1"/>
  <body name="finger" pos="0 0 0.2"><joint name="x" type="slide" axis="1 0 0" range="-0.5 0.5"/><joint name="y" type="slide" axis="0 1 0" range="-0.5 0.5"/>
    <geom size="0.03" mass="0.2"/></body>
  <body name="case" pos="0.3 0 0.2">
    <body name="drawer"><joint name="rail" type="slide" axis="1 0 0" range="0 0.25" damping="2" frictionloss="0.3"/><geom type="box" size="0.05 0.1 0.1" mass="0.5"/></body></body>
  <site name="goal" pos="0.4 0 0.2"/>
</worldbody><actuator><position joint="x" kp="400" forcerange="-40 40"/><position joint="y" kp="400" forcerange="-40 40"/></actuator>
<keyframe><key name="near" qpos="0.1 0 0"/></keyframe></mujoco>"""


@pytest.fixture
def drawer(tmp_path: Path) -> Path:
    (tmp_path / "drawer.xml").write_text(DRAWER)
    return tmp_path / "drawer.xml"


def test_three_lines_plan_a_whole_scene(drawer: Path) -> None:
    task = st.import_scene(drawer)
    assert task.model.joint_names == ["robot/x", "robot/y"] and task.model.object_names == ["drawer"]
    assert task.q_start.tolist() == [0, 0.1, 0]
    task.set_goal([0.15])
    result = st.plan(task, seed=0, timeout_s=60)
    assert result.status == st.Status.Solved and st.check_plan(result.plan).pass_
    run = st.run(result.plan, seed=0, timeout_s=60)
    assert run.reached, run.message
    assert run.start_overlap == 0 and run.start_moved == 0


@pytest.mark.parametrize(
    ("finger", "pair", "friction"),
    [
        ("", '<pair geom1="tip" geom2="front" friction="0.3 0.3 0 0 0"/>', 0.3),
        ("", '<pair geom1="tip" geom2="front" condim="1"/>', 0),
        ('priority="1" friction="0.2"', "", 0.2),
    ],
)
def test_a_plan_with_the_friction_of_its_pair_is_accepted(drawer: Path, finger: str, pair: str, friction: float) -> None:
    text = DRAWER.replace('<geom size="0.03"', f'<geom name="tip" {finger} size="0.03"').replace('<geom type="box"', '<geom name="front" type="box"')
    drawer.write_text(text.replace("<keyframe>", f"<contact>{pair}</contact><keyframe>"))
    task = st.import_scene(drawer)
    task.set_goal([0.15])
    plan = st.plan(task, seed=0, timeout_s=60).plan
    assert {round(contact.friction, 12) for knot in plan.contacts for contact in knot} == {friction}
    report = st.check_plan(plan)
    assert report.pass_, [item for item in report.items if not item.pass_]


def test_program_writes_a_task_that_it_loads(drawer: Path, stiction) -> None:
    out = drawer.parent / "tasks" / "drawer.yaml"
    out.parent.mkdir()
    done = stiction("import", drawer, "-o", out)
    assert done.returncode == 0, done.stderr
    written = yaml.safe_load(out.read_text())
    assert written["scene"] == {"file": "../drawer.xml", "objects": ["drawer"]} and written["start"] == {"keyframe": "near"}
    VALIDATOR.validate(written)
    assert st.load_task(out).scene_sha256 == st.import_scene(drawer).scene_sha256
    again = stiction("import", drawer, "-o", out)
    assert again.returncode == 2 and "which is there already" in again.stderr
    shown = stiction("import", drawer)
    assert shown.returncode == 0 and "  objects: [drawer]" in shown.stdout


CELL = """<robot name="cell">
  <link name="world"/><link name="slide"><inertial><mass value="1"/></inertial></link>
  <joint name="x" type="prismatic"><parent link="world"/><child link="slide"/><origin xyz="0 0 0.2"/><axis xyz="1 0 0"/><limit lower="-0.5" upper="0.5" effort="40" velocity="1"/></joint>
  <link name="finger"><collision><geometry><sphere radius="0.03"/></geometry></collision></link>
  <joint name="y" type="prismatic"><parent link="slide"/><child link="finger"/><axis xyz="0 1 0"/><limit lower="-0.5" upper="0.5" effort="40" velocity="1"/></joint>
  <link name="case"/><joint name="stand" type="fixed"><parent link="world"/><child link="case"/><origin xyz="0.3 0 0.2"/></joint>
  <link name="drawer"><inertial><mass value="0.5"/></inertial><collision><geometry><box size="0.1 0.2 0.2"/></geometry></collision></link>
  <joint name="rail" type="prismatic"><parent link="case"/><child link="drawer"/><axis xyz="1 0 0"/><limit lower="0" upper="0.25" effort="0" velocity="0"/><dynamics damping="2" friction="0.3"/></joint>
  <transmission name="a"><joint name="x"/></transmission><transmission name="b"><joint name="y"/></transmission>
</robot>"""


def test_a_urdf_is_a_whole_scene_too(tmp_path: Path, stiction) -> None:
    (tmp_path / "cell.urdf").write_text(CELL)
    task = st.import_scene(tmp_path / "cell.urdf")
    assert task.model.joint_names == ["robot/x", "robot/y"] and task.model.object_names == ["drawer"]
    task.set_goal([0.15])
    result = st.plan(task, seed=0, timeout_s=60)
    assert result.status == st.Status.Solved and st.check_plan(result.plan).pass_
    assert result.regrasps["tried"] >= result.regrasps["accepted"] >= 1
    run = st.run(result.plan, seed=0, timeout_s=60)
    assert run.reached, run.message
    written = yaml.safe_load(stiction("import", tmp_path / "cell.urdf").stdout)
    VALIDATOR.validate(written)
    assert written["scene"]["objects"] == ["drawer"]


def test_import_to_a_file_is_that_task(drawer: Path) -> None:
    out = drawer.parent / "drawer.yaml"
    task = st.import_scene(drawer, out=out)
    assert task.file == out and task.text == ""
    assert "  objects: [drawer]\n" in out.read_text()
    with pytest.raises(st.InvalidInput, match="which cannot be written"):
        st.import_scene(drawer, out=drawer.parent / "nowhere" / "drawer.yaml")
    with pytest.raises(st.InvalidInput, match="a file that does not exist"):
        st.import_scene(drawer.parent / "nowhere.xml")


@pytest.mark.parametrize(
    "start, goal, valid",
    [
        ({"poses": {"finger": {"position": [0.2, 0.1, 0.2]}}}, {"objects": {"drawer": {"coordinates": [[0.1, None]]}}}, True),
        ({"keyframe": "near", "joints": {"x": 0.05}}, {"objects": {"drawer": {"coordinates": [0.1]}}}, True),
        ({"keyframe": 3}, {"objects": {"drawer": {"coordinates": [0.1]}}}, False),
        ({"poses": {"finger": {"rpy": [0, 0, 0]}}}, {"objects": {"drawer": {"coordinates": [0.1]}}}, False),
        ({}, {"object": "drawer"}, False),
        ({}, {"object": "drawer", "at": "goal", "objects": {}}, False),
    ],
    ids=str,
)
def test_schema_and_program_agree(drawer: Path, start: dict, goal: dict, valid: bool) -> None:
    task = {"scene": {"file": "drawer.xml"}, "start": start, "goal": goal, "tolerance": {"position": 0.01, "angle": 0.1}}
    assert VALIDATOR.is_valid(task) == valid
    if valid:
        made = st.Task(task, base=drawer.parent)
        if "poses" in start:
            np.testing.assert_allclose(made.q_start[1:], [0.2, 0.1], atol=1e-6)
    else:
        with pytest.raises(st.InvalidInput):
            st.Task(task, base=drawer.parent)


@pytest.mark.parametrize(
    "scene, valid",
    [
        ({"file": "drawer.xml", "robot": {"name": "hand", "stiffness": 100}, "objects": ["drawer"]}, True),
        ({"file": "drawer.xml", "robot": {"mjcf": "drawer.xml"}}, False),
        ({"robot": {"name": "hand"}}, False),
        ({"objects": ["drawer"]}, False),
        ({"robots": [{"name": "r", "mjcf": "drawer.xml", "mount": {"file": "drawer.xml"}}]}, False),
    ],
    ids=str,
)
def test_schema_of_scenes_and_program_agree(drawer: Path, scene: dict, valid: bool) -> None:
    assert jsonschema.Draft202012Validator(SCHEMAS["scene.schema.json"]).is_valid(scene) == valid
    if valid:
        st.load_scene(scene, base=drawer.parent)
    else:
        with pytest.raises(st.InvalidInput):
            st.load_scene(scene, base=drawer.parent)


def test_run_moves_a_start_apart_that_overlaps(drawer: Path) -> None:
    task = st.Task(
        {
            "scene": {"file": "drawer.xml"},
            "start": {"joints": {"x": 0.24}, "objects": {"drawer": {"coordinates": [0.01]}}},
            "goal": {"objects": {"drawer": {"coordinates": [0.1]}}},
            "tolerance": {"position": 0.01, "angle": 0.1},
        },
        base=drawer.parent,
    )
    run = st.run(task, seed=0, duration=0.05, timeout_s=60)
    np.testing.assert_allclose(run.start_overlap, 0.01, atol=1e-6)
    assert 0 < run.start_moved <= 0.012
