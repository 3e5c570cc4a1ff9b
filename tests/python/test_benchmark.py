"""`stiction benchmark`: tasks on scenes of others, of which those that need no package are run here, and small scenes stand for packages."""

from __future__ import annotations

import dataclasses
import json
import re
import subprocess
import sys
import time
from pathlib import Path
from typing import ClassVar

import children
import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "build" / "release" / "python"))
st = pytest.importorskip("stiction")

from stiction import _benchmark_page as page  # noqa: E402
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
    words = ("push_t_planar", "planar_pushing", "-j", "1", "--run-budget", "10", "-o", out, "--json")
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
    done = command("metaworld_drawer_open", "metaworld_faucet_open", "kitchen_kettle", "--scenes", scenes, "-j", "1", "--run-budget", "10", "-o", tmp_path / "out", "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["missing"] == 1
    rows = {row["task"]: row for row in st.sweeps.read_table(tmp_path / "out" / "results.csv")}
    assert rows["metaworld_drawer_open"]["status"] == "Reached"
    faucet = rows["metaworld_faucet_open"]
    assert (faucet["status"], faucet["stage"], faucet["load_s"]) == ("NotLoaded", "load", None) and "malformed XML" in faucet["message"]
    text = (tmp_path / "out" / "benchmark.md").read_text()
    assert "metaworld 3.1.1" in text and "Packages are missing for kitchen_kettle." in text and "not loaded: N: scene.file" in text
    assert str(tmp_path) not in text, "a page says nothing of where it was made"


def test_a_task_that_changed_is_run_again(scenes: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    words = ("metaworld_faucet_open", "push_t_planar", "--scenes", scenes, "-j", "1", "--run-budget", "10", "-o", out)
    assert command(*words).returncode == 0
    moved = scenes.with_name("moved")
    scenes.rename(moved)
    done = command("metaworld_faucet_open", "--scenes", moved, "-j", "1", "--run-budget", "10", "-o", out)
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
    assert page.cause_of(search) == "budget of the search; new contacts are mostly refused since the object moved"
    assert page.detail_of(search) == "7 nodes; of 50 moves to new contacts: no posture in contact 5, no path to it 1, the object moved 30."
    start = row(status="NotPlanned", stage="plan", iterations=0, tried=0, message="the start cannot be settled: step 1 of the exact dynamics ends in Infeasible")
    assert page.cause_of(start) == "no search: the start cannot be settled: step N of the exact dynamics ends in Infeasible"
    assert page.detail_of(start) == "no search: the start cannot be settled: step 1 of the exact dynamics ends in Infeasible."
    fell = row(status="NotReached", stage="run", end="Dropped", message="'obj' fell")
    assert (page.cause_of(fell), page.detail_of(fell)) == ("run: an object fell", "an object fell; 'obj' fell.")
    assert page.cause_of(row(status="Stopped", stage=None, message="its process was ended after 60 s")) == "stopped: its process was ended after N s"
    assert page.cause_of(row(status="Reached", stage="run")) == ""
    lost = row(status="NotReached", stage="run", end="NoPlan", accepted=True, plan_s=2.0, reached=False)
    got = row(task="metaworld_drawer_open", status="Reached", stage="run", end="Reached", accepted=True, plan_s=1.0, reached=True)
    push, joints, everything = sorted(page.summarise([search, lost, got]), key=lambda line: ["push", "joints", "all"].index(line["set"]))
    assert (push["tasks"], push["runs"], push["planned"], push["accepted"], push["reached"], push["median_plan_s"]) == (1, 2, 1, 1, 0, 2.0)
    assert push["causes"] == {page.cause_of(search): 1, "run: no plan from where it got to": 1}
    assert joints["causes"] == {} and (everything["runs"], everything["reached"], everything["median_plan_s"]) == (3, 1, 1.5)
