"""Many runs on many processes: whatever ends one of them, the table has a row for each."""

from __future__ import annotations

import csv
import dataclasses
import importlib.util
import json
import os
import signal
import sys
from pathlib import Path
from types import ModuleType
from typing import ClassVar

import children
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "build" / "release" / "python"))
st = pytest.importorskip("stiction")


@dataclasses.dataclass(frozen=True)
class Writes:
    """Leaves a file for every start of a run; the seeds of `deadly` kill their own process by its id, at their first starts."""

    folder: str
    deadly: int = -1
    deaths: int = 0
    scale: float = 1.0

    columns: ClassVar[tuple[str, ...]] = ("value", "text", "items")

    def __call__(self, case):
        starts = len(list(Path(self.folder).glob(f"{case.seed}-*")))
        (Path(self.folder) / f"{case.seed}-{starts}").touch()
        if case.seed == self.deadly and starts < self.deaths:
            os.kill(os.getpid(), signal.SIGKILL)
        if case.task == "planar_hand":
            raise ValueError("this one\ncannot")
        row = {"status": "Solved", "value": self.scale * case.seed, "text": 'a "quoted", word', "items": [1, None]}
        return [row for _ in case.friction]


@pytest.fixture
def starts(tmp_path: Path):
    folder = tmp_path / "starts"
    folder.mkdir()
    return folder


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_a_row_for_each_run(starts: Path, tmp_path: Path) -> None:
    seen = []
    rows = st.sweep(
        ["planar_pushing", "planar_hand"], seeds=2, friction=[0.5, 1], options={"goal_bias": [0.3, 0.5]}, out=tmp_path / "sweep.csv",
        run=Writes(str(starts)), processes=2, on_progress=seen.append,
    )  # fmt: skip
    assert len(rows) == 16 and len({(r["task"], r["options"]["goal_bias"], r["seed"], r["friction"]) for r in rows}) == 16
    with (tmp_path / "sweep.csv").open(newline="") as file:
        assert len(list(csv.DictReader(file))) == 16
    for row in rows:
        if row["task"] == "planar_hand":
            assert (row["status"], row["message"], row["attempts"], row["value"]) == ("Failed", "ValueError: this one cannot", 1, None)
        else:
            assert (row["status"], row["value"], row["text"], row["items"]) == ("Solved", row["seed"], 'a "quoted", word', [1, None])
    assert [row for p in seen for row in p.rows] == rows, "rows that are told of have every column, as those that are returned"
    assert [p.done for p in seen] == sorted(p.done for p in seen) and seen[-1].done == seen[-1].total == 16
    assert seen[0].left_s is None and seen[-1].left_s == 0 and all(p.left_s >= 0 for p in seen[1:])


def test_a_process_that_is_killed_loses_nothing(starts: Path, tmp_path: Path) -> None:
    rows = st.sweep("planar_pushing", seeds=4, out=tmp_path / "once.csv", run=Writes(str(starts), deadly=1, deaths=1), processes=2)
    assert {r["seed"]: (r["status"], r["attempts"]) for r in rows} == {0: ("Solved", 1), 1: ("Solved", 2), 2: ("Solved", 1), 3: ("Solved", 1)}
    assert names(starts) == ["0-0", "1-0", "1-1", "2-0", "3-0"]


def test_a_run_that_always_dies_is_recorded(starts: Path, tmp_path: Path) -> None:
    rows = st.sweep("planar_pushing", seeds=3, out=tmp_path / "twice.csv", run=Writes(str(starts), deadly=0, deaths=9), processes=1)
    (died,) = [r for r in rows if r["status"] == "Died"]
    assert (died["seed"], died["attempts"], died["message"]) == (0, 2, f"its process ended with exit code {-signal.SIGKILL}")
    assert names(starts) == ["0-0", "0-1", "1-0", "2-0"]


def test_rows_that_are_there_are_not_run_again(starts: Path, tmp_path: Path) -> None:
    file, run = tmp_path / "sweep.csv", Writes(str(starts))
    whole = st.sweep("planar_pushing", seeds=4, out=file, run=run, processes=2)
    text = file.read_bytes()
    lines = text.splitlines(keepends=True)
    kept = next(i for i, row in enumerate(whole) if row["seed"] == 2)
    file.write_bytes(lines[0] + lines[1 + kept] + lines[1 + (kept + 1) % 4][:9])  # one row, and one that was cut off
    for path in starts.iterdir():
        path.unlink()
    again = st.sweep("planar_pushing", seeds=4, out=file, run=run, processes=2)
    assert names(starts) == ["0-0", "1-0", "3-0"]
    assert sorted(again, key=lambda r: r["seed"]) == sorted(whole, key=lambda r: r["seed"])
    assert sorted(file.read_bytes().splitlines()) == sorted(text.splitlines())
    assert st.sweep("planar_pushing", seeds=4, out=file, run=run) == again and len(names(starts)) == 3


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.replace(b"\n", b"\r\n"),
        lambda text: b"\xef\xbb\xbf" + text.replace(b"\n", b"\r\n").replace(b",1.0,", b",1,"),
        lambda text: text[:-1],
    ],
    ids=["CRLF", "spreadsheet", "without its last line end"],
)
def test_a_table_that_another_program_has_saved_goes_on(change, starts: Path, tmp_path: Path) -> None:
    file, run = tmp_path / "sweep.csv", Writes(str(starts))
    arguments = {"seeds": 2, "out": file, "run": run, "processes": 1, "friction": [1.0], "options": {"anytime": [True]}}
    whole = st.sweep("planar_pushing", **arguments)
    file.write_bytes(change(file.read_bytes()))
    assert st.sweeps.read_table(file) == whole[: len(st.sweeps.read_table(file))]
    again = st.sweep("planar_pushing", **arguments | {"seeds": 2})
    assert again == whole and again[0]["options"] == {"anytime": True}
    assert b"\r" not in file.read_bytes() and file.read_bytes().startswith(b"task,") and file.read_bytes().endswith(b"\n")


def test_truth_values_of_a_spreadsheet_are_read(tmp_path: Path) -> None:
    (tmp_path / "sweep.csv").write_text("reached,accepted\r\nTRUE,FALSE\r\n")
    assert st.sweeps.read_table(tmp_path / "sweep.csv") == [{"reached": True, "accepted": False}]


def test_a_file_that_is_no_table_is_left_as_it_is(starts: Path, tmp_path: Path) -> None:
    file, run = tmp_path / "notes.csv", Writes(str(starts))
    for content in (b"one line", b"one line\nand a half", b"task,seed\nplanar_pushing,0,1\n", b"\xff\n"):
        file.write_bytes(content)
        with pytest.raises(st.InvalidInput, match="notes.csv"):
            st.sweep("planar_pushing", out=file, run=run)
        assert file.read_bytes() == content
    with pytest.raises(st.InvalidInput, match="got a folder, expected a file to write"):
        st.sweep("planar_pushing", out=".", run=run)
    st.sweep("planar_pushing", out=tmp_path / "sweep.csv", run=run)
    (tmp_path / "sweep.csv").write_bytes(b"a,b\n1,2\nhalf")
    with pytest.raises(st.InvalidInput, match="sweep.csv: got other columns"):
        st.sweep("planar_pushing", out=tmp_path / "sweep.csv", run=run)
    assert (tmp_path / "sweep.csv").read_bytes() == b"a,b\n1,2\nhalf"


def test_another_sweep_is_refused_with_what_differs(starts: Path, tmp_path: Path) -> None:
    file = tmp_path / "sweep.csv"
    st.sweep("planar_pushing", seeds=2, out=file, run=Writes(str(starts)), processes=1)
    before = file.read_bytes()
    with pytest.raises(st.InvalidInput, match=r"sweep.csv: holds the rows of another sweep: seeds: got \[0, 1, 2\], expected \[0, 1\]; run.scale: got 2.0, expected 1.0"):
        st.sweep("planar_pushing", seeds=3, out=file, run=Writes(str(starts), scale=2.0))
    with pytest.raises(st.InvalidInput, match=r"tasks.planar_hand: got \".*\", expected null"):
        st.sweep(["planar_pushing", "planar_hand"], seeds=2, out=file, run=Writes(str(starts)))
    (tmp_path / "sweep.csv.json").unlink()
    with pytest.raises(st.InvalidInput, match="got rows without a readable sweep.csv.json"):
        st.sweep("planar_pushing", seeds=2, out=file, run=Writes(str(starts)))
    assert file.read_bytes() == before


@pytest.mark.parametrize(
    ("scene", "before", "after"),
    [
        ("planar_pushing", "tolerance: {position: 0.02, angle: 0.1}", "tolerance: {position: 0.03, angle: 0.1}"),
        ("planar_pushing", "goal: {objects: {box: {coordinates: [0, -0.5, 0]}}}", "goal: {objects: {box: {coordinates: [0, -0.5, ~]}}}"),
        ("planar_pushing", "goal: {objects: {box: {coordinates: [0, -0.5, [-1, 1]]}}}", "goal: {objects: {box: {coordinates: [0, -0.5, [-2, 2]]}}}"),
        ("two_boxes", "goal: {objects: {left: {coordinates: [-0.6, 1, 0]}, right: {coordinates: [1, 0.5, ~]}}}", "goal: {objects: {left: {coordinates: [-0.6, 1, 0]}, right: {coordinates: [1, 0.6, ~]}}}"),
        ("careful_clutter", "bystanders: {may_move: 0.05}", "bystanders: {may_move: 0.1}"),
    ],
    ids=["tolerance", "open", "bounds", "second_object", "bystanders"],
)
def test_a_task_that_changed_is_another_one(scene: str, before: str, after: str, starts: Path, tmp_path: Path) -> None:
    task, base = tmp_path / "mine.yaml", next(path for path in (ROOT / "tasks" / f"{scene}.yaml", ROOT / "tests" / "tasks" / "data" / f"{scene}.yaml") if path.exists())
    task.write_text(f"base: {base}\nname: mine\n{before}\n", encoding="utf-8")
    st.sweep(task, out=tmp_path / "sweep.csv", run=Writes(str(starts)))
    task.write_text(f"base: {base}\nname: mine\n{after}\n", encoding="utf-8")
    with pytest.raises(st.InvalidInput, match="tasks.*mine.yaml: got"):
        st.sweep(task, out=tmp_path / "sweep.csv", run=Writes(str(starts)))


def test_bad_input_is_named_before_anything_runs(starts: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "sweep.csv"
    if not _ray_is_there():
        monkeypatch.setitem(sys.modules, "ray", ModuleType("ray"))  # an address is looked at before Ray is asked
    for arguments, message in (
        ({"tasks": "no_such_task"}, "no_such_task"),
        ({"tasks": []}, "tasks: got \\[\\], expected at least one"),
        ({"seeds": [1, 1]}, "seeds: got \\[1, 1\\], expected at least one, each once"),
        ({"seeds": [-1]}, "seeds: got \\[-1\\], expected integers"),
        ({"friction": [-1]}, "friction: got \\[-1.0\\], expected factors"),
        ({"options": {"goal_bias": 0.3}}, "options: goal_bias: got 0.3, expected a list"),
        ({"friction": 0.8}, "friction: got 0.8, expected a list of factors"),
        ({"friction": ["a"]}, "friction: got \\['a'\\], expected factors"),
        ({"seeds": 1.5}, "seeds: got 1.5, expected a list of seeds, or the number of seeds"),
        ({"tasks": st.load_task("planar_pushing")}, "tasks: got a Task, expected a list of names or files"),
        ({"tasks": [st.load_task("planar_pushing")]}, "tasks: got a Task, expected names or files"),
        ({"options": ["goal_bias"]}, "options: got \\['goal_bias'\\], expected a dict of lists"),
        ({"options": {"goal_bias": [2.0]}}, "goal_bias"),
        ({"options": {"goal_bais": [0.3]}}, "goal_bais"),
        ({"options": {"sampler.no_such": [0.3]}}, "sampler.no_such"),
        ({"processes": 0}, "processes: got 0, expected at least 1"),
        ({"ray": "127.0.0.1:9"}, "ray: got '127.0.0.1:9', where nothing answers .*, expected HOST:PORT of a cluster, auto or local"),
    ):
        with pytest.raises(st.InvalidInput, match=message):
            st.sweep(**({"tasks": "planar_pushing", "out": file, "run": Writes(str(starts))} | arguments))
    (tmp_path / "file").touch()
    with pytest.raises(st.InvalidInput, match="file: cannot be made .*, expected a folder"):
        st.sweep("planar_pushing", out=tmp_path / "file/sweep.csv", run=Writes(str(starts)))
    assert names(starts) == []


def test_values_may_be_arrays(starts: Path, tmp_path: Path) -> None:
    """np.linspace for an option and np.arange for seeds are what users write; the table goes on with lists as well."""
    file, run = tmp_path / "sweep.csv", Writes(str(starts))
    rows = st.sweep("planar_pushing", seeds=np.arange(2), friction=np.array([0.5, 1.0]), options={"goal_bias": np.linspace(0.25, 0.5, 2)}, out=file, run=run, processes=1)
    assert len(rows) == 8 and {row["options"]["goal_bias"] for row in rows} == {0.25, 0.5} and {row["seed"] for row in rows} == {0, 1}
    again = st.sweep("planar_pushing", seeds=np.int64(2), friction=[0.5, 1.0], options={"goal_bias": [0.25, 0.5]}, out=file, run=run, processes=1)
    assert again == rows


def test_optional_packages_are_named(starts: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for module in ("ray", "pyarrow", "pyarrow.parquet"):
        monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(st.MissingExtra, match=r"ray: no Python module 'ray'; `pip install 'stiction\[ray\]'` brings it"):
        st.sweep("planar_pushing", out=tmp_path / "a.csv", run=Writes(str(starts)), ray="local")
    with pytest.raises(st.MissingExtra, match=r"Parquet: no Python module 'pyarrow.parquet'; `pip install 'stiction\[parquet\]'` brings it"):
        st.sweep("planar_pushing", out=tmp_path / "a.parquet", run=Writes(str(starts)))


def test_parquet_holds_the_rows(starts: Path, tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    rows = st.sweep("planar_pushing", seeds=2, out=tmp_path / "sweep.parquet", run=Writes(str(starts)))
    table = parquet.read_table(tmp_path / "sweep.parquet").to_pylist()
    assert [(r["seed"], r["value"]) for r in table] == [(r["seed"], r["value"]) for r in rows]
    from stiction.sweeps import read_table

    assert read_table(tmp_path / "sweep.parquet") == rows, "lists, dicts and empty cells too"


def test_the_program_sweeps_as_the_library_does(stiction, tmp_path: Path) -> None:
    """Plans are those of one call of plan(), whatever the number of processes; friction is that of the simulation."""
    words = ["sweep", "planar_pushing", "--seeds", "1:3", "--friction", "1", "--speed", "20", "--timeout", "300", "--option", "friction=0.8", "-o", tmp_path / "sweep.csv", "--json"]
    done = stiction(*words)
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout)
    assert (result["runs"], result["died"], len(result["results"])) == (2, 0, 1)
    assert all(group["solved"] == group["accepted"] == 2 for group in result["results"])
    assert "0 of 2" in done.stderr and "2 of 2, 0 s left: planar_pushing seed" in done.stderr
    from stiction.sweeps import read_table

    rows = read_table(tmp_path / "sweep.csv")
    assert all(r["processor_s"] > 0 and r["peak_mb"] > 10 and r["plan_s"] > 0 and r["reached"] is not None for r in rows)
    row = next(r for r in rows if (r["options"], r["seed"], r["friction"]) == ({"friction": 0.8}, 1, 1.0))
    task = st.load_task("planar_pushing")
    best = st.refine(st.plan(task, options={"friction": 0.8}, seed=1, threads=1).plan).plan
    run = st.transfer(best, speed=20, alone=False)
    assert (row["knots"], row["error_position"], row["goal_error_position"], row["reached"]) == (len(best.q) - 1, best.error.position, run.error.position, run.reached)
    again = stiction(*words)
    assert json.loads(again.stdout) == result and "2 of 2" in again.stderr and "seed" not in again.stderr.splitlines()[0]


def test_a_file_says_the_same(stiction, tmp_path: Path) -> None:
    spec = tmp_path / "spec.toml"
    spec.write_text('tasks = ["planar_pushing"]\nseeds = 2\nrefine = false\n[options]\n"goal_bias" = [0.3]\n', encoding="utf-8")
    done = stiction("sweep", spec, "-o", tmp_path / "sweep.csv", "--json")
    assert done.returncode == 0, done.stderr
    (group,) = json.loads(done.stdout)["results"]
    assert group["options"] == {"goal_bias": 0.3} and group["solved"] == 2
    for text, message in (
        ("seeds = 2\n", "tasks: got none"),
        ('tasks = "planar_pushing"\n', "tasks: got 'planar_pushing', expected list"),
        ('tasks = ["planar_pushing"]\ncolour = 1\n', "got the field 'colour', expected some of"),
        ("tasks = [\n", "got no TOML"),
    ):
        spec.write_text(text, encoding="utf-8")
        done = stiction("sweep", spec, "-o", tmp_path / "other.csv", "--json")
        assert done.returncode == 2 and message in done.stderr and f"{spec}" in done.stderr, done.stderr
        assert json.loads(done.stdout)["status"] == "InvalidInput"
    for words, message in ((["--seeds", "a"], "--seeds: got 'a'"), (["--friction", "x"], "--friction: got 'x'"), (["--option", "x"], "--option: got 'x'"), (["--option", "goal_bias=0.3,0.3"], "options: goal_bias: got [0.3, 0.3], expected at least one, each once"), (["--option", "goal_bias=0.3", "--option", "goal_bias=0.4"], "--option: got 'goal_bias' more than once"), (["--speed", "0"], "--speed: got '0'"), (["--nothing"], "--nothing")):
        done = stiction("sweep", "planar_pushing", *words, "-o", tmp_path / "other.csv")
        assert done.returncode == 2 and message in done.stderr, done.stderr


def test_ctrl_c_keeps_what_is_there(program: Path, tmp_path: Path) -> None:
    file = tmp_path / "sweep.csv"
    words = [program, "sweep", "planar_pushing", "--seeds", "1000", "-j", "2", "--no-refine", "-o", file]
    with children.Child(words) as process:
        for line in process.stderr:
            if line.startswith("3 of 1000"):
                process.send_group(signal.SIGINT)  # as a terminal does
                break
        err = process.finish().stderr
    assert process.returncode == 130 and "the same command goes on" in err, err
    assert "Traceback" not in err
    rows = file.read_text(encoding="utf-8").splitlines()
    assert 4 <= len(rows) < 1000 and all(row.count(",") >= rows[0].count(",") for row in rows)


def _ray_is_there() -> bool:
    return importlib.util.find_spec("ray") is not None


@pytest.mark.skipif(not _ray_is_there(), reason="ray is not installed: `make release-check` runs this")
def test_a_worker_of_ray_that_is_killed_loses_nothing(starts: Path, tmp_path: Path) -> None:
    rows = st.sweep("planar_pushing", seeds=4, out=tmp_path / "ray.csv", run=Writes(str(starts), deadly=1, deaths=1), processes=2, ray="local")
    assert {r["seed"]: (r["status"], r["attempts"]) for r in rows} == {0: ("Solved", 1), 1: ("Solved", 2), 2: ("Solved", 1), 3: ("Solved", 1)}
    assert names(starts) == ["0-0", "1-0", "1-1", "2-0", "3-0"]
