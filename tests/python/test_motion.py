"""Motion that is written for a robot of one's own: within its speeds, on its frames, and said where the plan ends elsewhere."""

from __future__ import annotations

import json
import shutil
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

FOLLOWER = """<link name="follower"><collision><geometry><sphere radius="0.01"/></geometry></collision></link>
<joint name="follow" type="prismatic"><parent link="{root}"/><child link="follower"/><origin xyz="0 -5 0"/><axis xyz="1 0 0"/>
<limit lower="-9" upper="9" effort="1" velocity="{velocity}"/><mimic joint="jx" multiplier="-2"/></joint>"""


def rail(velocity: str = "1", root: str = "rail_base", more: str = "") -> str:
    """A ball on two sliders."""
    return f"""<robot name="hand"><link name="{root}"/><link name="rail"/><link name="ball"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>
<link name="tip"/><joint name="jx" type="prismatic"><parent link="{root}"/><child link="rail"/><axis xyz="1 0 0"/><limit lower="-2" upper="2" effort="1000" velocity="{velocity}"/></joint>
<joint name="jy" type="prismatic"><parent link="rail"/><child link="ball"/><axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="1000" velocity="{velocity}"/></joint>
<joint name="tool" type="fixed"><parent link="ball"/><child link="tip"/><origin xyz="0 0 0.05"/></joint>{more}</robot>"""


def own_task(folder: Path, urdf: str, robots: tuple[dict[str, Any], ...] = (), **changes: Any) -> Path:
    """The ball pushes a box in a plane; written to a folder. robots: further ones."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "hand.urdf").write_text(urdf)
    task = {
        "name": "own_push",
        "scene": {
            "gravity": [0, 0, 0],
            "contact_distance": 1.0,
            "robots": [{"name": "hand", "urdf": "hand.urdf", "stiffness": 500}, *robots],
            "objects": [{"name": "box", "joint": "planar_xy", "mass": 1.0, "friction": 0.5, "shapes": [{"box": {"size": [0.3, 0.3, 0.3]}}]}],
        },
        "start": {"objects": {"box": {"coordinates": [0.4, 0, 0]}}, "joints": [0, 0] * (1 + len(robots))},
        "goal": {"objects": {"box": {"coordinates": [0.6, 0, 0.2]}}},
        "tolerance": {"position": 0.02, "angle": 0.1},
    }
    (folder / "task.yaml").write_text(json.dumps(task | changes))
    return folder / "task.yaml"


@pytest.fixture(scope="module")
def st(program: Path):
    sys.path.insert(0, str(program.parent / "python"))
    return pytest.importorskip("stiction")


def solve(st: Any, task: Any) -> Any:
    found = st.plan(task, seed=0, timeout_s=60)
    assert found.status == st.Status.Solved
    return found.plan


@pytest.mark.parametrize("velocity", ["0.05", "0.005", "0.5", "0"])
@pytest.mark.parametrize("follower", [None, "0.01"])
def test_commands_are_within_the_speeds_of_the_urdf(st, tmp_path: Path, velocity: str, follower: str | None) -> None:
    more = FOLLOWER.format(root="rail_base", velocity=follower) if follower else ""
    plan = solve(st, st.load_task(own_task(tmp_path, rail(velocity, more=more))))
    limits = np.full(2, float(velocity) or np.inf)
    if follower:
        limits[0] = min(limits[0], float(follower) / 2)
    for speed in (0.1, 1.0, 1000.0):
        trajectory = st.make_trajectory(plan, speed=speed)
        (file,) = plan.export(tmp_path / "motion.npz", trajectory=trajectory)
        with np.load(file) as motion:
            fastest = np.abs(np.diff(motion["q_cmd"], axis=0) / np.diff(motion["time"])[:, None]).max(axis=0)
            assert motion["speed"] == speed
        assert (fastest <= limits * (1 + 1e-6)).all(), (speed, fastest, limits)
        assert fastest.max() > 0


def read_mcap(file: Path) -> dict[str, list[Any]]:
    out: dict[str, list[Any]] = {}
    with file.open("rb") as stream:
        for _, channel, _, message in make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages():
            out.setdefault(channel.topic, []).append(message)
    return out


def frames(messages: list[Any]) -> dict[str, tuple[str, np.ndarray]]:
    """Parent and position of each frame."""
    return {t.child_frame_id: (t.header.frame_id, np.array([getattr(t.transform.translation, axis) for axis in "xyz"])) for m in messages for t in m.transforms}


def position(tree: dict[str, tuple[str, np.ndarray]], frame: str) -> np.ndarray:
    """In the world, of frames that do not turn."""
    parent, p = tree[frame]
    return p if parent == "world" else p + position(tree, parent)


def test_links_of_a_robot_are_frames_that_hang_on_the_world(st, tmp_path: Path) -> None:
    task = json.loads(own_task(tmp_path, rail()).read_text())
    task["scene"]["robots"][0]["base"] = {"position": [0.01, 0.02, 0.1]}
    plan = solve(st, st.Task(task, base=tmp_path))
    messages = read_mcap(plan.export(tmp_path / "motion.mcap")[0])
    fixed = frames(messages["/tf_static"])
    assert {name: parent for name, (parent, _) in fixed.items()} == {"rail_base": "world", "tip": "ball"}
    np.testing.assert_allclose(fixed["rail_base"][1], [0.01, 0.02, 0.1])
    states = messages["/hand/joint_states"]
    assert len(states) == len(messages["/tf"]) > 10
    for state, moving in zip(states, messages["/tf"], strict=True):
        tree = fixed | frames([moving])
        assert tree["rail"][0] == "rail_base" and tree["ball"][0] == "rail"
        x, y = state.position
        np.testing.assert_allclose(position(tree, "tip"), [0.01 + x, 0.02 + y, 0.15], atol=1e-12)


def test_robots_of_one_file_have_topics_and_frames_of_their_own(st, tmp_path: Path) -> None:
    """Names that differ only in letters that topics do not allow, and links of one name."""
    others = tuple({"name": name, "urdf": "hand.urdf", "stiffness": 500, "base": {"position": [0, y, 0]}} for name, y in (("a-b", 3), ("a.b", -3)))
    plan = solve(st, st.load_task(own_task(tmp_path, rail(), others)))
    messages = read_mcap(plan.export(tmp_path / "motion.mcap")[0])
    for topic in ("joint_trajectory", "joint_states"):
        robots = [name.split("/")[1] for name in messages if name.endswith(topic)]
        assert len(robots) == len(set(robots)) == 3
    knots = len(messages["/tf"])
    assert all(len(messages[name]) == knots for name in messages if name.endswith("joint_states"))
    fixed = frames(messages["/tf_static"])
    assert {"hand/rail_base", "a-b/rail_base", "a.b/rail_base"} <= fixed.keys() and "rail_base" not in fixed
    assert fixed["a-b/rail_base"][1][1] == 3 and fixed["a.b/tip"][0] == "a.b/ball"


def test_a_root_link_that_is_called_world_is_the_world_where_it_stands_there(st, tmp_path: Path) -> None:
    plan = solve(st, st.load_task(own_task(tmp_path, rail(root="world"))))
    messages = read_mcap(plan.export(tmp_path / "motion.mcap")[0])
    assert frames(messages["/tf_static"]).keys() == {"tip"} and frames(messages["/tf"])["rail"][0] == "world"
    task = json.loads((tmp_path / "task.yaml").read_text())
    task["scene"]["robots"][0]["base"] = {"position": [0, 0, 0.1]}
    moved = solve(st, st.Task(task, base=tmp_path))
    messages = read_mcap(moved.export(tmp_path / "motion.mcap")[0])
    fixed = frames(messages["/tf_static"])
    assert fixed["hand/world"][0] == "world" and fixed["hand/world"][1][2] == 0.1 and frames(messages["/tf"])["hand/rail"][0] == "hand/world"


@pytest.fixture(scope="module")
def unsolved(stiction, st, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A plan that moves and stops before its goal, whose tolerances nothing reaches in 60 extensions."""
    folder = tmp_path_factory.mktemp("unsolved")
    goal = {"objects": {"box": {"coordinates": [0.9, 0.6, 2.5]}}}
    task = own_task(folder, rail(), goal=goal, tolerance={"position": 1e-5, "angle": 1e-5}, planner={"max_iterations": 60})
    done = stiction("plan", task, "--seed", 0, "-o", folder / "plan", "--timeout", 60)
    assert done.returncode == 3, done.stderr
    assert sum(len(s["knots"]) for s in json.loads((folder / "plan/plan.json").read_text())["segments"]) > 5
    return folder / "plan"


def test_export_of_a_plan_that_misses_its_goal_warns_and_has_a_code_of_its_own(stiction, st, unsolved: Path, tmp_path: Path) -> None:
    done = stiction("export", unsolved, "-o", tmp_path / "motion.json", "--json")
    assert done.returncode == 3
    out = json.loads(done.stdout)
    assert (out["status"], out["plan_status"], out["speed"]) == ("NotSolved", "MaxIterations", 0.1)
    assert "stiction: warning: " in done.stderr and "the plan does not reach its goal (status MaxIterations): it ends " in done.stderr
    written = json.loads((tmp_path / "motion.json").read_text())
    assert written["status"] == "MaxIterations" and written["speed"] == 0.1 and len(written["knots"]) > 5
    with pytest.warns(UserWarning, match="the plan does not reach its goal"):
        st.read_plan(unsolved / "plan.json").export(tmp_path / "motion.csv")
    assert (tmp_path / "motion.csv").exists()


def test_simulate_and_refine_say_that_the_plan_misses_its_goal(stiction, unsolved: Path) -> None:
    done = stiction("simulate", unsolved, "--whole-only", "--json")
    out = json.loads(done.stdout)
    assert done.returncode == 3 and (out["status"], out["plan_status"]) == ("NotSolved", "MaxIterations")
    assert "stiction: warning: " in done.stderr and "the plan does not reach its goal (status MaxIterations)" in done.stderr
    done = stiction("refine", unsolved)
    assert done.returncode == 2 and "status: got MaxIterations, expected Solved: a plan that reaches its goal" in done.stderr


def test_speed_is_that_at_which_plans_hold_and_every_output_says_it(stiction, st, tmp_path: Path) -> None:
    assert st.OPEN_LOOP_SPEED == 0.1
    task = own_task(tmp_path, rail())
    planned = stiction("plan", task, "--seed", 0, "-o", tmp_path / "plan")
    assert planned.returncode == 0
    exported = stiction("export", tmp_path / "plan", "--format", "csv", "--json")
    simulated = stiction("simulate", tmp_path / "plan", "--whole-only", "--json")
    refined = stiction("refine", tmp_path / "plan", "--json")
    for done in (exported, simulated, refined):
        assert done.returncode == 0, done.stderr
        assert json.loads(done.stdout)["speed"] == 0.1 and "0.1 of the full speed" in done.stderr
    rows = (tmp_path / "plan/refined/trajectory.csv").read_text().splitlines()
    again = st.make_trajectory(st.read_plan(tmp_path / "plan/refined/plan.json"))
    assert len(rows) == 1 + len(again.times) and float(rows[-1].split(",")[0]) == again.duration
    fast = stiction("export", tmp_path / "plan", "--format", "csv", "--speed", 1, "--json")
    assert json.loads(fast.stdout)["speed"] == 1 and json.loads(fast.stdout)["duration_s"] < 0.5 * json.loads(exported.stdout)["duration_s"]


@pytest.mark.parametrize("format", ["csv", "npz", "json", "mcap"])
def test_a_plan_of_nothing_is_named(stiction, st, tmp_path: Path, format: str) -> None:
    """The object is at its goal from the start."""
    task = own_task(tmp_path, rail(), goal={"objects": {"box": {"coordinates": [0.4, 0, 0]}}})
    assert stiction("plan", task, "--seed", 0, "-o", tmp_path / "plan").returncode == 0
    done = stiction("export", tmp_path / "plan", "--format", format)
    assert done.returncode == 2 and "plan.segments: got nothing that moves" in done.stderr and "Traceback" not in done.stderr
    assert not (tmp_path / f"plan/motion.{format}").exists()


def use(st: Any, task: Any, folder: Path) -> None:
    """All that is done with a task once it is loaded."""
    folder.mkdir()
    plan = solve(st, task)
    assert st.make_trajectory(plan).duration > 0
    assert all(file.exists() for format in ("csv", "npz", "json", "mcap") for file in plan.export(folder / f"motion.{format}"))
    assert st.check_plan(plan).pass_
    assert st.refine(plan).status == st.Status.Solved
    assert st.transfer(plan, alone=False).status == st.Status.Solved
    assert st.run(task, seed=0, timeout_s=60).reached
    st.view(plan, html=folder / "plan.html")
    assert (folder / "plan.html").exists()
    assert task.with_(goal=[0.5, 0, 0]).goal != task.goal


def test_what_was_loaded_works_on_when_its_folder_is_gone(st, tmp_path: Path) -> None:
    task = st.load_task(own_task(tmp_path / "gone", rail()))
    shutil.rmtree(tmp_path / "gone")
    use(st, task, tmp_path / "out")


@pytest.mark.parametrize("from_dict", [False, True])
def test_what_was_loaded_by_a_relative_path_works_on_in_another_folder(st, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, from_dict: bool) -> None:
    file = own_task(tmp_path / "work", rail())
    monkeypatch.chdir(tmp_path / "work")
    task = st.Task(json.loads(file.read_text())) if from_dict else st.load_task("task.yaml")
    monkeypatch.chdir(tmp_path)
    use(st, task, tmp_path / "out")
