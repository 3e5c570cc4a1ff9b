"""`stiction benchmark`: tasks on scenes of others, of which those that need no package are run here, and small scenes stand for packages."""

from __future__ import annotations

import dataclasses
import json
import math
import os
import re
import subprocess
import sys
import time
from pathlib import Path
from typing import ClassVar
from xml.etree import ElementTree

import children
import numpy as np
import prose
import pytest
import yaml
from PIL import Image

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "build" / "release" / "python"))
st = pytest.importorskip("stiction")

from stiction import _benchmark_failures as failures  # noqa: E402
from stiction import _benchmark_page as page  # noqa: E402
from stiction import _benchmark_peers as peers  # noqa: E402
from stiction import _benchmark_story as story  # noqa: E402
from stiction import _pictures as pictures  # noqa: E402
from stiction import _benchmark_tasks as tasks  # noqa: E402
from stiction import _benchmark as benchmark  # noqa: E402
from stiction._jobs import Local  # noqa: E402
from stiction.sweeps import Case, run_cases  # noqa: E402

PROGRAM = ROOT / "build" / "release" / "stiction"
# The drawer of metaworld's file, by the names that its task has: a plate on a slide of 0.16 m, before a hand that moves along y.
DRAWER = """<mujoco><worldbody>
  <body name="base"><joint name="y" type="slide" axis="0 1 0" range="-1 1"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
    <body name="hand" pos="0 0.6 0.2" quat="0.7071068 0 0.7071068 0"><geom size="0.03" mass="0.2"/></body></body>
  <body name="case" pos="0 0.9 0.2"><body name="drawer_link"><joint type="slide" axis="0 1 0" range="-0.16 0" damping="2" frictionloss="0.3"/><geom type="box" size="0.1 0.01 0.05" pos="0 -0.4 0" mass="0.5"/></body></body>
</worldbody><actuator><position joint="y" kp="400" forcerange="-40 40"/></actuator></mujoco>"""


@pytest.fixture
def scenes(tmp_path: Path) -> Path:
    folder = tmp_path / "wheels" / "metaworld" / "assets" / "sawyer_xyz"
    folder.mkdir(parents=True)
    (folder / "sawyer_drawer.xml").write_text(DRAWER)
    (folder / "sawyer_faucet.xml").write_text("<mujoco><worldbody><body><joint/></worldbody></mujoco>")
    (tmp_path / "wheels" / "metaworld-3.1.1.dist-info").mkdir()
    return tmp_path / "wheels"


def command(*words: object) -> subprocess.CompletedProcess[str]:
    return children.run([PROGRAM, "benchmark", *words])


def test_tasks_without_a_package_are_planned_and_run(tmp_path: Path) -> None:
    out = tmp_path / "out"
    words = ("push_t_planar", "planar_pushing", "-j", "1", "--duration", "30", "-o", out, "--json")
    done = command(*words)
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout)
    assert (result["runs"], result["missing"]) == (2, 0)
    rows = {row["task"]: row for row in st.sweeps.read_table(out / "results.csv")}
    assert set(rows) == {"push_t_planar", "planar_pushing"}
    for row in rows.values():
        assert (row["status"], row["stage"], row["accepted"], row["reached"], row["seed"]) == ("Reached", "run", True, True, 0)
        assert row["plan_s"] > 0 and row["tried"] >= row["regrasps"] > 0
    text = (out / "benchmark.md").read_text()
    assert "| push | 2 | 2 | 2 | 2 | 2 | 2 |" in text and "`push_t_planar`" in text
    before = (out / "results.csv").read_text()
    again = command(*words)
    assert again.returncode == 0 and (out / "results.csv").read_text() == before, "rows that are there are not run again"


def test_each_task_is_a_file_that_the_schema_takes_and_that_may_be_edited(tmp_path: Path) -> None:
    names = [entry.name for entry in tasks.ENTRIES]
    assert len(names) == len(set(names)) >= 80 and {entry.set for entry in tasks.ENTRIES} == set(tasks.SETS)
    packages = {name: Path("/elsewhere") / name for name in tasks.WHEELS}
    for entry in tasks.ENTRIES:
        task = yaml.safe_load(tasks.to_yaml(entry, packages))
        assert task["name"] == entry.name
        assert "planner" not in task, "all have the same settings"
        assert (entry.wheel is None) == ("/elsewhere/" not in json.dumps(task)), entry.name
        if entry.wheel is None:
            file = tmp_path / f"{entry.name}.yaml"
            file.write_text(tasks.to_yaml(entry, packages))
            assert st.load_task(file).model.n_a > 0


def test_a_scene_of_a_package_is_found_in_a_folder(scenes: Path, tmp_path: Path) -> None:
    done = command("metaworld_drawer_open", "metaworld_faucet_open", "kitchen_kettle", "--scenes", scenes, "-j", "1", "--duration", "30", "-o", tmp_path / "out", "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["missing"] == 1
    rows = {row["task"]: row for row in st.sweeps.read_table(tmp_path / "out" / "results.csv")}
    assert rows["metaworld_drawer_open"]["status"] == "Reached"
    faucet = rows["metaworld_faucet_open"]
    assert (faucet["status"], faucet["stage"], faucet["load_s"]) == ("NotLoaded", "load", None) and "malformed XML" in faucet["message"]
    text, failed = ((tmp_path / "out" / f"{name}.md").read_text() for name in ("benchmark", "benchmark_failures"))
    assert "metaworld 3.1.1" in text and "Packages are missing for `kitchen_kettle`." in text and "the scene could not be loaded" in failed
    assert str(tmp_path) not in text + failed, "a page says nothing of where it was made"


def test_a_task_that_changed_is_run_again(scenes: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    words = ("metaworld_faucet_open", "push_t_planar", "--scenes", scenes, "-j", "1", "--duration", "30", "-o", out)
    assert command(*words).returncode == 0
    moved = scenes.with_name("moved")
    scenes.rename(moved)
    done = command("metaworld_faucet_open", "--scenes", moved, "-j", "1", "--duration", "30", "-o", out)
    assert done.returncode == 0, done.stderr
    rows = st.sweeps.read_table(out / "results.csv")
    assert sorted(row["task"] for row in rows) == ["metaworld_faucet_open", "push_t_planar"]
    assert str(moved) in (out / "tasks" / "metaworld_faucet_open.yaml").read_text()


def test_bad_input_is_named(tmp_path: Path) -> None:
    for words, message in (
        (["doors"], r"SET: got 'doors', expected 'joints', 'push', .* or the name of a task"),
        (["drawer"], r"SET: got 'drawer', .* or the name of a task, as metaworld_drawer_close,metaworld_drawer_open"),
        (["metaworld_drawer_open", "--scenes", str(tmp_path)], r"SET: got tasks of metaworld, which is not installed below .*, expected them: `pip install 'stiction\[benchmark\]'`"),
        (["--plan-budget", "0"], "--plan-budget: got '0', expected a number > 0"),
        (["--seeds", "0"], "--seeds: got '0'"),
    ):
        done = command(*words, "-o", tmp_path / "out")
        assert done.returncode == 2, (words, done.stderr)
        assert re.search(message, done.stderr), done.stderr
    assert not (tmp_path / "out" / "results.csv").exists()


def test_tasks_are_listed() -> None:
    done = command("--list", "--json")
    assert done.returncode == 0 and [task["name"] for task in json.loads(done.stdout)["tasks"]] == [entry.name for entry in tasks.ENTRIES]


@dataclasses.dataclass(frozen=True)
class Sleeps:
    """Seed 0 never ends."""

    columns: ClassVar[tuple[str, ...]] = ()

    def __call__(self, case: Case) -> list[dict[str, str]]:
        while case.seed == 0:
            time.sleep(1)
        return [{"status": "Done"}]


def test_a_process_that_does_not_end_is_ended(tmp_path: Path) -> None:
    (late,) = run_cases(tmp_path / "late.csv", {}, Sleeps(), [Case("a", {}, 0)], lambda: Local(1, limit_s=0.5))
    assert (late["status"], late["attempts"], late["message"]) == ("Stopped", 1, "its process was ended after 0.5 s")
    (done,) = run_cases(tmp_path / "done.csv", {}, Sleeps(), [Case("a", {}, 1)], lambda: Local(1, limit_s=600.0))
    assert (done["status"], done["attempts"], done["message"]) == ("Done", 1, None)


def row(**values: object) -> dict[str, object]:
    empty = dict.fromkeys(("task", "seed", "message", *benchmark.BenchmarkRun.columns))
    return empty | {"task": "metaworld_push", "seed": 0, "load_s": 0.1} | values


def test_causes_are_named_by_what_refused_most() -> None:
    search = row(status="NotPlanned", stage="plan", iterations=100, nodes=7, tried=50, no_posture=5, no_path=1, object_moved=30, failed_step=0)
    assert failures.cause_of(search) == "the search ran out of time; most refused contacts: the object moved while hands let go or took hold"
    start = row(status="NotPlanned", stage="plan", iterations=0, tried=0, message="the start cannot be settled: step 1 of the exact dynamics ends in Infeasible")
    assert failures.cause_of(start) == "the search did not begin, because the objects do not rest at the start"
    assert failures.tell_search(start, SETTINGS)[0] == "The planner said `the start cannot be settled: step 1 of the exact dynamics ends in Infeasible`."
    assert failures.cause_of(row(status="NotReached", stage="run", end="Dropped", message="'obj' fell")) == "an object fell during the run"
    assert failures.cause_of(row(status="Stopped", stage=None, message="its process was ended after 60 s")) == "the process did not end and was stopped"
    assert failures.cause_of(row(status="Reached", stage="run")) == ""
    lost = row(status="NotReached", stage="run", end="NoPlan", accepted=True, plan_s=2.0, reached=False)
    got = row(task="metaworld_drawer_open", status="Reached", stage="run", end="Reached", accepted=True, plan_s=1.0, reached=True)
    push, joints, everything = sorted(page.summarise([search, lost, got]), key=lambda line: ["push", "joints", "all"].index(line["set"]))
    assert (push["tasks"], push["runs"], push["planned"], push["accepted"], push["reached"], push["median_plan_s"]) == (1, 2, 1, 1, 0, 2.0)
    assert push["causes"] == {failures.cause_of(search): 1, failures.cause_of(lost): 1}
    assert joints["causes"] == {} and (everything["runs"], everything["reached"], everything["median_plan_s"]) == (3, 1, 1.5)
    three = [*[lost] * 3, *[search] * 2, *[start] * 2, row(status="NotReached", stage="run", end="TimeUp")]
    assert [count for _, count in failures.causes_by_set(three, {"metaworld_push": "push"})["push"]] == [3, 2, 2], "the three most frequent, by their counts"


SETTINGS = {"plan_budget_s": 15.0, "duration_s": 60.0}


def test_bands_are_powers_of_two_of_the_tolerance() -> None:
    assert story.band_of(np.array([0.0, 1.0, 1.001, 2.0, 2.001, 4.0, 100.0])).tolist() == [0, 0, 1, 1, 2, 2, 7]


def test_a_search_says_how_near_it_came_and_where_moves_were_refused() -> None:
    """Sums over the bands are the totals of the search; the nearest node lies in the first band that has one."""
    task = st.load_task("iiwa_bimanual_planar")
    nodes = story.Nodes()
    found = st.plan(task, seed=0, threads=1, options={"max_iterations": 400, "tolerance_fraction": 0.001}, on_growth=nodes)
    assert found.status == st.Status.MaxIterations
    q = nodes.q(task.model.n_q)
    assert len(q) == found.nodes
    told = story.tell_search(task, found, q)
    columns = [sum(column) for column in zip(*told["bands"])][1:]
    assert columns[0] == found.nodes
    assert columns[2:] == [found.regrasps[name] for name in story.REFUSALS] and sum(columns[2:]) > 0
    assert columns[1] == sum(entry.counts["tried"] for entry in found.refused) <= found.regrasps["tried"]
    nearest = story.shares(task, q).min()
    first = next(high for high, count, *_ in told["bands"] if count)
    assert (0 if first == 1 else first / 2) <= nearest <= first
    assert told["start"] == pytest.approx(task.goal_errors(task.q_start[None])[0], rel=1e-3) and told["tolerance"] == [task.goal.tol_position, task.goal.tol_angle]
    most = told["bands"][told["most"]["band"]]
    assert sum(most[3:]) == max(sum(line[3:]) for line in told["bands"])
    (place,) = told["most"]["objects"].values()
    assert len(place) == 3 and np.linalg.norm(np.array(place[:2]) - task.q_start[:2]) < 1, "a planar object has three coordinates"
    assert json.loads(json.dumps(told)) == told


def test_a_run_says_what_it_did_and_how_far_the_object_was() -> None:
    task = st.load_task("planar_pushing")
    ran = st.run(task, seed=0, threads=1, duration=4.0)
    assert not ran.reached
    told = story.tell_run(task, ran)
    assert [plan[3] for plan in told["plans"]][0] == "start" and len(told["plans"]) == len(ran.plans)
    assert sum(line[2] + line[3] for line in told["pieces"]) == len(ran.pieces)
    times = [sample[0] for sample in told["distance"]]
    assert times == sorted(times) and 2 < len(times) <= story.SAMPLES and times[-1] == pytest.approx(ran.times[-1], rel=1e-3)
    assert told["distance"][0][1:] == pytest.approx(task.goal_errors(task.q_start[None])[0], rel=1e-2)
    assert told["distance"][-1][1:] == pytest.approx(task.goal_errors(ran.q[-1:])[0], rel=1e-3)
    lost = row(task="planar_pushing", status="NotReached", stage="run", end="TimeUp", plan_s=0.1, simulated_s=4.0, goal_error_position=0.1, goal_error_angle=0.2, timeline=told)
    drawn = ElementTree.fromstring(failures.chart(lost) or "")
    points = drawn.find("{http://www.w3.org/2000/svg}polyline").attrib["points"].split()  # type: ignore[union-attr]
    assert len(points) == len(times)
    assert float(points[0].split(",")[1]) < float(points[-1].split(",")[1]), "nearer to the goal is lower"


@pytest.fixture
def told_rows() -> list[dict[str, object]]:
    search = {"start": [0.3, 0.0], "best": [0.12, 0.0], "tolerance": [0.05, 0.1], "bands": [[4, 30, 9, 1, 0, 6, 0], [8, 70, 20, 2, 3, 5, 1]], "most": {"band": 1, "objects": {"obj": [0.1, 0.7, 0.02]}}}
    times = {"tolerance": [0.05, 0.1], "plans": [[0.0, 0.4, "Solved", "start", ""], [3.0, 1.0, "MaxIterations", "a push was 3.2 tolerances off its plan", "the object is lost"]],
             "pieces": [[0.4, 2.9, 5, 4, 3.2, True]], "distance": [[0.0, 0.3, 0.0], [2.9, 0.2, 0.1], [4.0, 0.21, 0.1]]}  # fmt: skip
    message = "5 plans in a row failed: the objects do not come to rest at the start: after 100 steps one has moved by 0.0892 (m or rad); is it supported?"
    return [
        row(status="NotPlanned", stage="plan", iterations=100, nodes=100, tried=29, plan_s=15.0, no_posture=3, no_path=3, object_moved=11, failed_step=1, search=search),
        row(task="shadow_block_full", status="NotReached", stage="run", end="NoPlan", message=message, plan_s=2.0, accepted=False, refused="hold effort", reached=False,
            simulated_s=4.0, goal_error_position=0.21, goal_error_angle=0.1, replans=1, pushes=5, timeline=times),
        row(task="metaworld_drawer_open", status="Reached", stage="run", end="Reached", plan_s=1.0, accepted=True, reached=True, simulated_s=9.0, replans=0, pushes=3),
    ]  # fmt: skip


def test_pages_say_why_in_sentences_of_ordinary_length(told_rows: list[dict[str, object]], tmp_path: Path) -> None:
    report = page.Report(told_rows, {"metaworld": "3.1.1"}, SETTINGS, [entry for entry in tasks.ENTRIES if entry.wheel == "robosuite"], frozenset(["metaworld_push"]), "", peers.load_peers())
    (tmp_path / "benchmark_pictures").mkdir()
    (tmp_path / "benchmark_pictures" / "planar_pushing.0.svg").write_text("of a run that is no failure any more")
    files = page.write_pages(report, tmp_path)
    assert [file.name for file in (tmp_path / "benchmark_pictures").iterdir()] == ["shadow_block_full.0.svg"]
    for file in files:
        assert not prose.faults(file, file.name)
    first, second = (file.read_text() for file in files)
    for name in ("metaworld_push", "shadow_block_full"):
        assert f"benchmark_failures.md#{name}" in first and f"\n## {name}\n" in second
    assert "drawer_open" in first and "drawer_open" not in second
    assert '<img src="benchmark_pictures/metaworld_push.webp"' in first and '<img src="benchmark_pictures/metaworld_push.webp"' in second
    assert "The start is 300 mm from the goal, and the best node came to 120 mm. The tolerance is 50 mm." in second
    assert "Most refused moves began 4 to 8 tolerances from the goal. The middle of those places: `obj` at (0.1, 0.7, 0.02)." in second
    assert "| 2 to 4 | 200 mm | 30 | 1 | 0 | 6 | 0 |" in second and "| all |  | 100 | 3 | 3 | 11 | 1 |" in second
    events = [line for line in second.splitlines() if re.match(r"\| \d+\.\d \|", line)]
    assert events == [
        "| 0.0 | 0.4 | plans | found | 300 mm |",
        "| 0.4 | 2.9 | 5 pushes, 4 moves to new contacts | given up, 3.2 tolerances off its path | 200 mm and 0.1 rad |",
        "| 3.0 | 4.0 | plans, since a push was 3.2 tolerances off its plan | no plan: the object is lost | 210 mm and 0.1 rad |",
    ]
    assert (tmp_path / "benchmark_pictures" / "shadow_block_full.0.svg").is_file() and "shadow_block_full.0.svg" in second
    old = [{name: value for name, value in entry.items() if name not in ("search", "timeline")} for entry in told_rows]
    assert "| all |  | 100 | 3 | 3 | 11 | 1 |" in failures.write_failures(old, SETTINGS, {}), "rows of earlier versions have no story"


def test_another_program_stands_beside_with_its_source_and_what_differs() -> None:
    figures = peers.load_peers()
    assert figures is not None
    text = "\n".join(peers.write_peers(figures))
    script = figures["command"].split()[0]
    assert (ROOT / script).is_file() and figures["command"] in text
    assert "arXiv" in text and "licence" in text and len(figures["differs"]) >= 4
    for entry in figures["rows"]:
        assert 0 <= entry["theirs"] <= entry["n"] and 0 <= entry["ours"] <= entry["n"] and entry["processor_per_s"] > 0
        assert f"| {entry['scene']} | {entry['program']} | {entry['n']} | {entry['theirs']} of {entry['n']} | {entry['ours']} of {entry['n']} |" in text


def test_tests_of_both_programs_are_looked_at_over_a_motion(tmp_path: Path) -> None:
    """Its quaternion error is sin²(θ/2): 0.04 is 23.07°. Twenty steps in a row are twenty-one looks; ours counts at once."""
    sys.path.insert(0, str(ROOT / "experiments"))
    import peer_comfree as peer

    script = tmp_path / "examples/mpc/allegro/cube/test.py"
    script.parent.mkdir(parents=True)
    script.write_text("success_pos_threshold = 0.02\nsuccess_quat_threshold = 0.04\nconsecutive_success_time_threshold = 20\nmax_rollout_length = 500\nif comp_quat_error(a, b): pass\n")
    test = peer.constants(tmp_path, peer.SCENES["allegro"])
    assert test == {"position": math.inf, "quaternion": 0.04, "in_a_row": 20, "most": 500}, "a script that does not look at the position"
    assert peer.is_within((9.0, math.radians(23.0)), test) and not peer.is_within((0.0, math.radians(23.2)), test)
    assert peer.angle_between([1, 0, 0, 0], [-math.cos(0.2), 0, 0, -math.sin(0.2)]) == pytest.approx(0.4)
    judge = peer.Judge(test, 0.1)
    for step in range(1, 40):
        angle = 0.3 if step < 30 else 0.05  # ours from step 30 on; one slip at step 5
        judge.look(0.1 * step, (0.005, 0.5 if step == 5 else angle))
    assert judge.theirs_s == pytest.approx(2.6) and judge.ours_s == pytest.approx(3.0) and judge.best == (0.005, 0.05)
    resting = peer.Judge(test, 0.1)
    resting.look(0.1, (0.005, 0.05))
    resting.rest(0.1, (0.005, 0.05))
    assert resting.theirs_s == 0.1


def test_goals_in_a_row_stand_with_what_holds_for_all() -> None:
    sys.path.insert(0, str(ROOT / "experiments"))
    import goals_in_row as row

    cases = [{"reached": [4.0, 10.0, 12.0], "dropped_s": 20.0, "simulated_s": 20.0, "processor_s": 6.0}, {"reached": [], "dropped_s": None, "simulated_s": 50.0, "processor_s": 8.0}]
    line = row.summarise("LEAP hand", "`stiction run`", cases)
    assert line == {"scene": "LEAP hand", "program": "`stiction run`", "n": 2, "goals": 3, "median": 1.5, "least": 0, "most": 3, "dropped": 1, "median_s": 4.0, "simulated_s": 70.0, "processor_per_s": 0.2}
    made = row.describe(2, "d5e6b47", 0.001) | {"rows": [line]}
    for figures in filter(None, (made, peers.load_peers(peers.ROWS))):
        text = "\n".join(peers.write_rows(figures))
        assert (ROOT / figures["command"].split()[0]).is_file() and figures["command"] in text and len(figures["differs"]) >= 4
        for entry in figures["rows"]:
            assert f"| {entry['scene']} | {entry['program']} | {entry['n']} | {entry['goals']} | {entry['median']} |" in text
    report = page.Report([], {}, SETTINGS, rows_of_goals=made)
    assert "## Goals in a row" in page.write_page(report) and "## Goals in a row" not in page.write_page(dataclasses.replace(report, rows_of_goals=None))


def test_goals_turn_by_the_rule_of_the_environment_and_count_by_orientation_alone() -> None:
    sys.path.insert(0, str(ROOT / "experiments"))
    import goals_in_row as row

    goals = np.array(row.draw_goals(np.random.default_rng(3)))
    assert goals.shape == (row.GOALS, 4) and np.allclose(np.linalg.norm(goals, axis=1), 1)
    turns = np.array([row.times(a * [1, -1, -1, -1], b) for a, b in zip(goals, goals[1:])])  # in the frame of the one before
    turns *= np.sign(turns[:, 1:2])  # about axes whose parts are positive
    vectors = 2 * np.arctan2(np.linalg.norm(turns[:, 1:], axis=1), turns[:, 0])[:, None] * turns[:, 1:] / np.linalg.norm(turns[:, 1:], axis=1)[:, None]
    assert vectors.min() > 0.5 - 1e-9 and vectors.max() < 2.5 + 1e-9 and vectors.max() - vectors.min() > 1.9
    for goal in goals[:20]:
        r, p, y = row.roll_pitch_yaw(goal)
        again = row.times(row.times(row.turn_by(np.array([0, 0, y])), row.turn_by(np.array([0, p, 0]))), row.turn_by(np.array([r, 0, 0])))
        assert row.angle_between(again, goal) < 1e-6
    judge = row.Judge([[1, 0, 0, 0], row.turn_by(np.array([0.5, 0, 0])).tolist()] + goals[:2].tolist())
    assert judge.look(0.1, np.array([9.0, 0, 0]), row.turn_by(np.array([0.09, 0, 0]))) and judge.reached == [0.1]
    assert judge.look(0.2, np.zeros(3), row.turn_by(np.array([0.39, 0, 0]))) and judge.reached == [0.1], "0.11 rad from the second"
    assert judge.look(0.3, np.zeros(3), -row.turn_by(np.array([0.55, 0, 0]))) and judge.reached == [0.1, 0.3]
    assert not judge.look(0.4, np.array([0, 0, row.LOWEST - 1e-3]), goals[0]) and judge.dropped_s == 0.4


def test_without_a_renderer_a_sentence_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MUJOCO_GL", "paper")
    out = tmp_path / "out"
    done = command("planar_pushing", "-j", "1", "--duration", "30", "-o", out, "--json")
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout)
    assert result["pictures"] == 0 and "MUJOCO_GL=paper" in result["no_pictures"]
    assert "There are no pictures: MuJoCo draws nothing here with MUJOCO_GL=paper" in (out / "benchmark.md").read_text()


def can_draw() -> bool:
    code = "from stiction._pictures import start_renderer; start_renderer()"
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "build/release/python")}
    return subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True).returncode == 0


drawn = pytest.mark.skipif(not can_draw(), reason="MuJoCo draws nothing here: no PyOpenGL, or no libEGL")


@drawn
def test_a_part_in_the_middle_is_drawn_in_its_colour() -> None:
    """A red plate that faces the camera fills the middle of the picture, as large as its size and distance say; around it is sky."""
    mujoco = pictures.start_renderer()
    corners = 0.1 * np.array([[-1, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1], [0, 0.05, 0]])
    plate = pictures.Part(corners, np.array([[0, 1, 2], [0, 2, 3], [1, 0, 4], [2, 1, 4], [3, 2, 4], [0, 3, 4]]), (220, 20, 20))
    camera = pictures.Camera(np.zeros(3), np.array([0.0, -1.0, 0.0]), 2 * math.atan(0.2), 0.15)  # the height of the picture is 0.4 m at the plate
    shot = pictures.draw(mujoco, pictures.Picture([plate], [], camera), (160, 120)).astype(int)
    red = (shot[:, :, 0] > 2 * shot[:, :, 1]) & (shot[:, :, 0] > 2 * shot[:, :, 2])
    rows, columns = np.flatnonzero(red.any(axis=1)), np.flatnonzero(red.any(axis=0))
    assert abs(len(rows) - 60) <= 2 and abs(len(columns) - 60) <= 2, "0.2 m of 0.4 m"
    assert abs(rows.mean() - 59.5) <= 1 and abs(columns.mean() - 79.5) <= 1
    assert np.abs(shot[:8, :8] - 255 * np.array(pictures.SKY)).max() < 12


@drawn
def test_pictures_show_the_start_and_the_ghost_of_the_goal(tmp_path: Path) -> None:
    out = tmp_path / "out"
    words = ("planar_pushing", "push_t_table", "-j", "1", "--duration", "30", "-o", out, "--json")
    done = command(*words)
    assert done.returncode == 0, done.stderr
    assert (json.loads(done.stdout)["pictures"], json.loads(done.stdout)["no_pictures"]) == (2, "")
    for name in ("planar_pushing", "push_t_table"):
        file = out / "benchmark_pictures" / f"{name}.webp"
        assert file.stat().st_size < 20_000
        picture = np.asarray(Image.open(file)).astype(int)
        assert picture.shape == (pictures.SIZE[1], pictures.SIZE[0], 3)
        red, green, blue = np.moveaxis(picture, -1, 0)
        assert ((red > green + 30) & (green > blue)).mean() > 0.003, "orange: the object"
        assert ((green > red + 15) & (green > blue + 5)).mean() > 0.003, "green: its ghost"
    before = {file: file.stat().st_mtime_ns for file in (out / "benchmark_pictures").iterdir()}
    assert command(*words).returncode == 0
    assert {file: file.stat().st_mtime_ns for file in (out / "benchmark_pictures").glob("*.webp")} == {f: t for f, t in before.items() if f.suffix == ".webp"}, "not drawn again"


def test_goal_where_the_object_starts_has_no_ghost() -> None:
    task = st.load_task("planar_pushing")
    roles = [part.role for part in pictures.picture_of(task).parts]
    assert "goal" in roles and "object" in roles
    there = task.with_(start=np.concatenate([task.q_goal, task.q_start[len(task.q_goal) :]]))
    assert not any(part.role for part in pictures.picture_of(there).parts)
