"""Whole scenes of others in the studio, without a browser: what is found is said, the start is a keyframe, the goal is dragged, the plan is made again in a shell."""

from __future__ import annotations

import json
import os
import shlex
import sys
from collections.abc import Iterator
from pathlib import Path

import children
import numpy as np
import pytest

PYTHON = Path(__file__).resolve().parents[2] / "build" / "release" / "python"
if not (PYTHON / "stiction").is_dir():
    pytest.skip("build/release/python/stiction does not exist: run `make build`", allow_module_level=True)
sys.path.insert(0, str(PYTHON))

import stiction as st  # noqa: E402
from studio_driven import Driven  # noqa: E402

from stiction_view.camera import make_cloud, sample_surfaces, visible  # noqa: E402
from stiction_view.studio import catalog, exporting  # noqa: E402
from stiction_view.studio.app import Studio  # noqa: E402
from stiction_view.studio.picture import Pictures, plan_drawn  # noqa: E402
from stiction_view.studio.problem import Problem  # noqa: E402
from stiction_view.studio.server import serving  # noqa: E402
from stiction_view.studio.stage import Grip  # noqa: E402

# A finger on two slides, a drawer that it opens from behind, and a puck on a table.
SCENE = """<mujoco><option gravity="0 0 -9.81"/><worldbody>
  <geom name="table" type="plane" size="1 1 1"/>
  <body name="finger" pos="0 0 0.04"><joint name="x" type="slide" axis="1 0 0" range="-0.5 0.5"/><joint name="y" type="slide" axis="0 1 0" range="-0.5 0.5"/>
    <geom size="0.03" mass="0.2"/></body>
  <body name="case" pos="0.3 0 0.2">
    <body name="drawer"><joint name="rail" type="slide" axis="1 0 0" range="0 0.25" damping="2" frictionloss="0.3"/><geom type="box" size="0.05 0.1 0.15" mass="0.5"/></body></body>
  <body name="puck" pos="0 0.2 0.02"><freejoint/><geom type="cylinder" size="0.04 0.02" mass="0.1"/></body>
</worldbody><actuator><position joint="x" kp="400" forcerange="-40 40"/><position joint="y" kp="400" forcerange="-40 40"/></actuator>
<keyframe><key name="near" qpos="0.1 0 0 0 0.2 0.02 1 0 0 0"/><key name="aside" qpos="0.1 -0.3 0.05 0 0.25 0.02 1 0 0 0"/></keyframe></mujoco>"""
ROBOT = """<mujoco><worldbody><body name="arm"><joint name="j" axis="0 0 1"/><geom size=".1"/></body></worldbody><actuator><position joint="j" kp="5"/></actuator></mujoco>"""


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    (tmp_path / "kitchen.xml").write_text(SCENE)
    return tmp_path / "kitchen.xml"


@pytest.fixture
def driven(scene: Path, tmp_path: Path) -> Iterator[Driven]:
    (folder := tmp_path / "studio").mkdir()
    entries, first = catalog.find(str(scene))
    with serving("127.0.0.1", 0) as server:
        made = Driven(Studio(server, entries, first, folder))
        made.panel.search.budget.value = 200.0
        yield made


def test_what_was_found_is_said(driven: Driven) -> None:
    head, pose = driven.panel.head, driven.panel.pose
    assert driven.said == []
    for words in ("Found in kitchen.xml", "Robot: 2 joints (x, y)", "drawer (slider [0, 0.25])", "puck (free)", "near", "aside"):
        assert words in head.about.content
    assert "*" not in head.about.content.replace("**", ""), "notes are not in the way"
    assert head.notes_folder.visible == bool(driven.studio.posing.problem.model.notes)
    assert pose.keyframe.visible and pose.keyframe.options == ("as given", "near", "aside")
    assert pose.goal_of.visible and pose.goal_of.options == ("drawer", "puck") and pose.goal_of.value == "drawer"


def test_start_is_a_keyframe(driven: Driven) -> None:
    studio, pose = driven.studio, driven.panel.pose
    np.testing.assert_allclose([handle.value for handle in pose.joints], [0.1, 0.0], atol=1e-9)
    pose.keyframe.value = "aside"
    driven.until(lambda: abs(pose.joints[1].value + 0.3) < 1e-9)
    problem = studio.posing.problem
    assert problem.task().q_start[0] == pytest.approx(0.05) and not problem.in_file()
    pose.keyframe.value = "as given"
    driven.until(lambda: abs(pose.joints[1].value) < 1e-9)
    assert problem.in_file() and driven.said == []


def test_list_says_where_the_start_is_after_undo_and_for_another_object(driven: Driven) -> None:
    studio, pose = driven.studio, driven.panel.pose
    pose.keyframe.value = "aside"
    driven.until(lambda: studio.posing.problem.start_moved)
    driven.press("undo")
    driven.until(lambda: pose.keyframe.value == "as given")
    assert studio.posing.problem.in_file()
    pose.keyframe.value = "aside"
    driven.until(lambda: abs(pose.joints[1].value + 0.3) < 1e-9)
    pose.goal_of.value = "puck"
    driven.until(lambda: studio.posing.problem.goal_object == 1)
    assert pose.keyframe.value == "aside" and pose.joints[1].value == pytest.approx(-0.3)
    pose.keyframe.value = "as given"
    driven.until(lambda: abs(pose.joints[1].value) < 1e-9)
    assert driven.said == []


def test_scene_that_cannot_be_read_leaves_no_task_and_no_advice_on_objects(tmp_path: Path) -> None:
    (tmp_path / "kitchen.xml").write_text('<mujoco><include file="gone.xml"/></mujoco>')
    entries, first = catalog.find(str(tmp_path / "kitchen.xml"))
    with serving("127.0.0.1", 0) as server:
        driven = Driven(Studio(server, entries, first, tmp_path))
        message = driven.panel.head.message
        assert "gone.xml" in message.content and "Own" not in message.content
        driven.press("plan")
        assert driven.said == ["plan: no task is open; open one"]


def test_keyframes_are_told_apart_from_the_start_as_given(scene: Path, driven: Driven) -> None:
    scene.write_text(SCENE.replace('name="near"', 'name="as given"'))
    driven.press("pick")
    driven.studio.open(driven.studio.entries[0])
    assert driven.panel.pose.keyframe.options == ("as given", "aside"), "a list with two of the same leaves the page empty"


def test_another_object_gets_the_goal_and_keeps_the_start(driven: Driven) -> None:
    studio, pose = driven.studio, driven.panel.pose
    pose.keyframe.value = "aside"
    driven.until(lambda: studio.posing.problem.start_moved)
    pose.goal_of.value = "puck"
    driven.until(lambda: studio.posing.problem.goal_object == 1)
    assert len(pose.goal) == 6 and pose.any_turn.visible and pose.any_turn.value and pose.handle.value == "goal"
    np.testing.assert_allclose([handle.value for handle in pose.goal[:3]], [0.1, 0.2, 0.02], atol=1e-6)
    np.testing.assert_allclose(studio.posing.problem.task().q_start[-2:], [0.1, -0.3], atol=1e-9)
    studio.posing.drag(Grip(1, at_goal=True), st.Pose(np.eye(3), [0.2, 0.25, 0.02]), True)
    driven.until(lambda: abs(pose.goal[0].value - 0.2) < 1e-9)
    assert "'0.2 0.25 0.02 ~ ~ ~'" in driven.panel.export.command.content
    assert all(studio.posing.problem.task().goal.open[4:7]), "after the drawer and the place of the puck"
    pose.any_turn.value = False
    driven.until(lambda: "~" not in driven.panel.export.command.content)
    assert not any(studio.posing.problem.task().goal.open)
    driven.press("reset")
    assert pose.any_turn.value and driven.said == []


def test_goal_is_dragged_planned_and_planned_again_in_a_shell(driven: Driven, tmp_path: Path, program: Path) -> None:
    studio, pose = driven.studio, driven.panel.pose
    pose.goal[0].value = 0.12
    driven.until(lambda: studio.posing.problem.goal_moved)
    driven.plan()
    result = studio.showing.result
    assert result.plan.status == st.Status.Solved, result.reason
    (elsewhere := tmp_path / "elsewhere").mkdir()
    done = children.run(["bash", "-e"], input=exporting.reproduce(result), cwd=elsewhere, limit=120, env={**os.environ, "PATH": f"{program.parent}:{os.environ['PATH']}"})
    assert done.returncode == 0, done.stdout + done.stderr
    np.testing.assert_array_equal(st.read_plan(elsewhere / "out" / "plan.json").q, result.plan.q)
    assert driven.said == []


def test_changed_start_is_in_what_reproduces_it(driven: Driven) -> None:
    problem = driven.studio.posing.problem
    problem.set_joint(1, -0.2)
    first, second = problem.command(5).splitlines()
    assert shlex.split(second)[:3] == ["stiction", "plan", "task.yaml"] and "stiction import" in first
    assert '"base": "kitchen.yaml"' in problem.task_file() and str(driven.studio.folder) not in problem.task_file()


def test_slider_is_dragged_along_its_way_and_inside_its_limits(driven: Driven) -> None:
    pose, stage, grip = driven.panel.pose, driven.studio.stage, Grip(0, at_goal=True)
    assert pose.handle.value == "goal"
    gizmo, X_BG = stage._gizmos[grip]
    np.testing.assert_allclose(X_BG.R[:, 2], [1, 0, 0], atol=1e-12)
    assert gizmo.active_axes == (False, False, True) and gizmo.disable_rotations, "one arrow along the rail"
    assert (pose.goal[0].min, pose.goal[0].max) == (0, 0.25), "and a slider"
    driven.studio.posing.drag(grip, st.Pose(np.eye(3), [0.42, 0.3, 0.7]), True)
    driven.until(lambda: pose.goal[0].value == pytest.approx(0.12, abs=1e-9))
    driven.studio.posing.drag(grip, st.Pose(np.eye(3), [9.0, 0.0, 0.2]), True)
    driven.until(lambda: pose.goal[0].value == pytest.approx(0.25, abs=1e-9))
    np.testing.assert_allclose(gizmo.position, [0.55, 0, 0.2], atol=1e-9)


# A finger behind a door that hides it from most sides, whose hinge points down.
DOOR = """<mujoco><compiler angle="radian"/><worldbody>
  <body name="finger" pos="0.5 0.1 0.3"><joint name="x" type="slide" axis="1 0 0" range="-0.2 0.2"/><geom size="0.03" mass="0.2"/></body>
  <body name="door" pos="0 0 0.5"><joint name="hinge" axis="0 0 -1" range="-1.5 1.5" damping="2" frictionloss="0.3"/><geom type="box" size="0.5 0.02 0.5" pos="0.5 0 0" mass="2"/></body>
</worldbody><actuator><position joint="x" kp="400" forcerange="-40 40"/></actuator></mujoco>"""


def test_door_has_a_ring_before_it_and_is_looked_at_from_where_the_robot_is_seen(tmp_path: Path) -> None:
    (tmp_path / "door.xml").write_text(DOOR)
    (folder := tmp_path / "studio").mkdir()
    entries, first = catalog.find(str(tmp_path / "door.xml"))
    with serving("127.0.0.1", 0) as server:
        driven = Driven(Studio(server, entries, first, folder))
        stage, pose, grip = driven.studio.stage, driven.panel.pose, Grip(0, at_goal=True)
        drawing = stage.posed
        cloud = make_cloud(drawing.plan, sample_surfaces(drawing.plan, drawing.parts), 0)
        away = drawing.view.position - drawing.view.look_at
        assert visible(cloud, away / np.linalg.norm(away), cloud.is_robot) > 0.5 and visible(cloud, np.array([0.0, -0.8, 0.6]), cloud.is_robot) == 0
        gizmo, X_BG = stage._gizmos[grip]
        np.testing.assert_allclose(X_BG.R @ [0.5**0.5, 0.5**0.5, 0], [1, 0, 0], atol=1e-9, err_msg="the middle of the ring is before the door")
        np.testing.assert_allclose(X_BG.R[:, 2], [0, 0, -1], atol=1e-9)
        assert gizmo.active_axes == (True, True, False) and gizmo.disable_axes and gizmo.disable_sliders and not gizmo.disable_rotations
        c, s = np.cos(0.4), np.sin(0.4)
        driven.studio.posing.drag(grip, st.Pose(np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]), [0.2, 0.1, 0.7]), True)
        driven.until(lambda: pose.goal[0].value == pytest.approx(0.4, abs=1e-9))
        assert driven.said == []


def test_links_that_nothing_can_touch_are_drawn_between_their_joints(tmp_path: Path) -> None:
    """An upper arm of 0.4 m without a shape, and a forearm of 0.3 m with one at its end."""
    (tmp_path / "arm.xml").write_text("""<mujoco><worldbody><body name="upper" pos="0 0 1"><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><joint name="a" axis="0 0 1"/>
      <body name="lower" pos="0.4 0 0"><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><joint name="b" axis="0 0 1"/><body name="tip" pos="0.3 0 0"><geom size=".02"/></body></body></body>
      <body name="puck" pos="0 .5 1"><joint type="slide" axis="1 0 0"/><geom size=".05"/></body></worldbody>
      <actuator><position joint="a" kp="50"/><position joint="b" kp="50"/></actuator></mujoco>""")
    made = Problem.of_scene(tmp_path / "arm.xml", tmp_path)
    pictures = Pictures(made.model)
    names = [body.name for body in pictures.bodies]
    loose = {(names[rod.parent].split("/")[-1], names[rod.child].split("/")[-1]): rod.length for rod in pictures.rods()[1]}
    assert loose[("upper", "lower")] == pytest.approx(0.4) and loose[("lower", "tip")] == pytest.approx(0.3)
    plan = made.task().follow([made.start[-2:] + [0.1, 0.0]])
    drawn = pictures.with_bare_links(plan_drawn(plan), plan.q[1:])
    np.testing.assert_allclose(drawn.poses, pictures.poses(plan.q[1:]), atol=1e-5)


def test_robot_alone_is_sent_to_where_it_gets_an_object(tmp_path: Path) -> None:
    (tmp_path / "arm.xml").write_text(ROBOT)
    entries, first = catalog.find(str(tmp_path / "arm.xml"))
    assert first.kind == catalog.SCENE
    with serving("127.0.0.1", 0) as server:
        studio = Studio(server, entries, first, tmp_path)
        assert "without an object" in studio.panel.head.message.content and "'Own'" in studio.panel.head.message.content
        assert studio.posing.problem is None


def several_goals(scene: Path) -> dict[str, object]:
    goal = {"objects": {"drawer": {"coordinates": [0.1]}, "puck": {"position": [0.1, 0.2, 0.02], "rpy": None}}}
    return {"scene": {"file": scene.name}, "start": {"keyframe": "near"}, "goal": goal, "tolerance": {"position": 0.01, "angle": 0.1}}


def test_goal_of_several_objects_stays_theirs(scene: Path) -> None:
    made = Problem.of_dict(several_goals(scene), scene.parent)
    assert len(made.task().goal_objects) == 2 and made.movable() == []
    names = made.model.object_names
    assert names[made.goal_object] == "puck" and made.any_turn, "the smaller one"
    assert made.goal_names()[0].startswith("drawer") and len(made.goal_numbers()) == 7
    made.set_goal_numbers([0.1, 0.15, 0.2, 0.02, 0.0, 0.0, 0.0])
    assert made.moved_goals == {names.index("puck")}
    after = made.task()
    q = dict(zip(names, np.split(after.q_goal, [made.model.objects[1].q_begin])))
    assert q["drawer"] == pytest.approx(0.1)
    np.testing.assert_allclose(q["puck"][:3], [0.15, 0.2, 0.02], atol=1e-9)
    assert after.goal.open == made.given.goal.open and made.command(5).count("~") == 3
    made.set_goal(st.Pose(np.eye(3), [0.5, 0.3, 0.1]), names.index("drawer"))
    assert made.task().q_goal[0] == pytest.approx(0.2), "along its rail"
    assert made.command(5).count("~") == 3


def test_each_of_several_goals_has_a_handle_a_ghost_and_numbers(scene: Path, tmp_path: Path) -> None:
    file = tmp_path / "both.yaml"
    file.write_text(json.dumps(several_goals(scene)))
    entries, first = catalog.find(str(file))
    with serving("127.0.0.1", 0) as server:
        driven = Driven(Studio(server, entries, first, tmp_path))
        studio, pose = driven.studio, driven.panel.pose
        drawer, puck = (Grip(studio.posing.problem.model.object_names.index(name), at_goal=True) for name in ("drawer", "puck"))
        assert pose.handle.value == "all goals" and set(studio.stage._gizmos) == {drawer, puck}
        assert len(studio.stage.posed.goal_nodes) == 2
        studio.posing.drag(drawer, st.Pose(np.eye(3), [0.5, 0.3, 0.7]), False)
        studio.posing.drag(puck, st.Pose(np.eye(3), [0.3, 0.25, 0.02]), True)
        driven.until(lambda: pose.goal[0].value == pytest.approx(0.2) and pose.goal[1].value == pytest.approx(0.3))
        ghosts = {studio.stage.posed.plan.bodies[body].name: node.position for body, node in studio.stage.posed.goal_nodes.items()}
        np.testing.assert_allclose(ghosts["drawer"], [0.5, 0, 0.2], atol=1e-9)
        np.testing.assert_allclose(ghosts["puck"], [0.3, 0.25, 0.02], atol=1e-9)
        pose.handle.value = "goal of puck"
        driven.until(lambda: set(studio.stage._gizmos) == {puck})
        np.testing.assert_allclose(studio.posing.problem.task().q_goal[:4], [0.2, 0.3, 0.25, 0.02], atol=1e-9)
        driven.press("undo")
        driven.press("undo")
        assert not studio.posing.problem.goal_moved and pose.goal[0].value == pytest.approx(0.1) and pose.undo.disabled and driven.said == []


def test_a_task_that_leaves_the_start_to_its_scene_is_linted(scene: Path) -> None:
    given = {key: value for key, value in several_goals(scene).items() if key != "start"}
    assert st.lint(Problem.of_dict(given, scene.parent).task()) == []


# ---- links that are dragged ----

ARM = """<mujoco><compiler angle="radian"/><worldbody><body name="upper" pos="0 0 .1"><joint name="a" axis="0 0 1" range="-2 2"/><geom type="capsule" fromto=".05 0 0 .25 0 0" size=".03"/>
  <body name="lower" pos="0.3 0 0"><joint name="b" axis="0 0 1" range="-2 2"/><geom type="capsule" fromto=".05 0 0 .2 0 0" size=".02"/><body name="hand" pos="0.25 0 0"><geom size=".02"/></body></body></body>
  <body name="puck" pos="0.2 .3 .1"><joint name="way" type="slide" axis="1 0 0" range="-1 1" frictionloss=".1"/><geom size=".03" mass=".1"/></body></worldbody>
  <actuator><position joint="a" kp="50"/><position joint="b" kp="50"/></actuator>
  <keyframe><key name="bent" qpos="0.4 -1 0"/></keyframe></mujoco>"""


@pytest.fixture
def arm(tmp_path: Path) -> Iterator[Driven]:
    (tmp_path / "arm.xml").write_text(ARM)
    (folder := tmp_path / "studio").mkdir()
    entries, first = catalog.find(str(tmp_path / "arm.xml"))
    with serving("127.0.0.1", 0) as server:
        yield Driven(Studio(server, entries, first, folder))


def test_hand_is_dragged_and_its_joints_follow(arm: Driven) -> None:
    studio, pose = arm.studio, arm.panel.pose
    problem = studio.posing.problem
    pose.keyframe.value = "bent"
    arm.until(lambda: problem.start_moved)
    given = problem.start.copy()
    studio.posing.pick("robot/hand")
    arm.until(lambda: pose.handle.value == "link robot/hand")
    grip = Grip(link="robot/hand", turns=False)
    assert set(studio.stage._gizmos) == {grip} and studio.stage._gizmos[grip][0].disable_rotations, "two joints turn no hand"
    X = problem.model.body_poses(given)["robot/hand"]
    wanted = X.p + [-0.05, 0.1, 0]
    for k in range(1, 6):
        studio.posing.drag(grip, st.Pose(X.R, X.p + k / 5 * (wanted - X.p)), k == 5)
        arm.until(lambda: not studio.posing._dragged)
    np.testing.assert_allclose(problem.model.body_poses(problem.start)["robot/hand"].p, wanted, atol=1e-6)
    np.testing.assert_allclose([handle.value for handle in pose.joints], problem.start[-2:], atol=1e-9)
    np.testing.assert_allclose(problem.task().q_start, problem.start, atol=1e-8)
    assert arm.said == []

    before = problem.start.copy()
    studio.posing.drag(grip, st.Pose(X.R, [2.0, 2.0, 0.1]), False)
    arm.until(lambda: not studio.posing._dragged)
    reached = problem.model.body_poses(problem.start)["robot/hand"].p
    assert np.linalg.norm(reached - [0, 0, 0.1]) > 0.5 and np.all(np.abs(problem.start[-2:]) <= 2), "it stretches"
    assert "out of reach" in pose.posture.content and f"a {problem.start[-2]:.3f}" in pose.posture.content
    studio.posing.drag(grip, st.Pose(X.R, [2.0, 2.0, 0.1]), True)
    arm.until(lambda: not studio.posing._dragged)
    at = problem.model.body_poses(problem.start)["robot/hand"].p
    np.testing.assert_allclose(studio.stage._gizmos[grip][0].position, at, atol=1e-9, err_msg="and the handle comes back to it")

    arm.press("undo")
    np.testing.assert_allclose(problem.start, before)
    arm.press("undo")
    np.testing.assert_allclose(problem.start, given, err_msg="the five steps were one drag")
    arm.press("undo")
    assert not problem.start_moved and pose.undo.disabled


def test_hand_that_is_dragged_away_from_another_scene_moves_nothing(arm: Driven) -> None:
    problem = arm.studio.posing.problem
    arm.studio.posing.drag(Grip(link="robot/hand", turns=False), st.Pose(np.eye(3), [0.1, 0.1, 0.1]), True)
    arm.studio.posing.drag(Grip(link="robot/nobody"), st.Pose(np.eye(3), [0.1, 0.1, 0.1]), True)
    arm.until(lambda: not arm.studio.posing._dragged)
    assert not problem.start_moved and arm.said == [], "what has no handle is not dragged"


def test_links_are_placed_from_python(tmp_path: Path) -> None:
    (tmp_path / "arm.xml").write_text(ARM)
    model = Problem.of_scene(tmp_path / "arm.xml", tmp_path).model
    q = model.neutral()
    placed = st.place_links(model, q, {"hand": [0.3, 0.2, 0.1]})
    assert placed.status == st.Status.Solved and placed.position < 1e-6 and placed.pair == -1
    np.testing.assert_allclose(model.body_poses(placed.q)["robot/hand"].p, [0.3, 0.2, 0.1], atol=1e-6)
    for poses, message in (({"nobody": [0, 0, 0]}, "got 'nobody', which 0 links are"), ({"hand": [0, 0]}, r"poses\['hand'\]")):
        with pytest.raises(st.InvalidInput, match=message):
            st.place_links(model, q, poses)
