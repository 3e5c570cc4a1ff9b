"""Paths that the system refuses, and things that are no files where files are written: one message, exit code 2, and nothing is removed."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

import children
import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "build" / "release" / "python"))
st = pytest.importorskip("stiction")

READERS = [["check"], ["simulate"], ["refine"], ["run"], ["view"], ["import"], ["export", "--format", "csv"], ["report"], ["stream", "--rerun", "x.rrd"]]


@pytest.mark.parametrize("name", ["n" * 300, "loop.json"], ids=["too long", "a loop of links"])
@pytest.mark.parametrize("words", READERS, ids=lambda words: words[0])
def test_path_that_cannot_be_used_is_a_mistake_in_the_input(stiction, words: list[str], name: str, tmp_path: Path) -> None:
    (tmp_path / "loop.json").symlink_to("loop.json")
    done = stiction(words[0], name, *words[1:], cwd=tmp_path)
    assert done.returncode == 2 and done.stderr.startswith("stiction: ") and done.stderr.count("\n") == 1, done.stderr
    assert name in done.stderr


def test_module_says_the_same(tmp_path: Path) -> None:
    with pytest.raises(st.InvalidInput, match="nnn: got a path that cannot be used .File name too long., expected a file or folder"):
        st.read_plan("n" * 300)
    with pytest.raises(st.InvalidInput, match="cannot be made or written .File name too long."):
        st.read_plan(_plan(tmp_path)).export(tmp_path / ("n" * 300 + ".csv"))


@pytest.mark.parametrize(
    "words",
    [["export", "PLAN", "--format", "csv", "-o", "pipe"], ["report", "PLAN", "-o", "pipe"], ["sweep", "planar_pushing", "-o", "pipe"], ["grasps", "planar_pushing", "-o", "pipe"], ["view", "PLAN", "--html", "pipe"]],
    ids=lambda words: words[0],
)
def test_pipe_or_device_is_not_replaced_by_a_file(stiction, words: list[str], tmp_path: Path) -> None:
    """As root it would be /dev/null."""
    os.mkfifo(tmp_path / "pipe")
    done = stiction(*(_plan(tmp_path) if word == "PLAN" else word for word in words), cwd=tmp_path)
    assert done.returncode == 2 and "pipe" in done.stderr and "expected a file to write" in done.stderr, done.stderr
    assert (tmp_path / "pipe").is_fifo()


def test_link_is_followed_and_stays(stiction, tmp_path: Path) -> None:
    (tmp_path / "disk").mkdir()
    names = ("motion.csv", "plan.json", "page.html")
    for name in names:
        (tmp_path / name).symlink_to(f"disk/{name}")
    plan = stiction("plan", "planar_pushing", "-o", tmp_path)
    export = stiction("export", tmp_path, "--format", "csv")
    page = stiction("view", tmp_path, "--html", tmp_path / "page.html")
    assert [plan.returncode, export.returncode, page.returncode] == [0, 0, 0], plan.stderr + export.stderr + page.stderr
    assert all((tmp_path / name).is_symlink() and (tmp_path / "disk" / name).stat().st_size > 0 for name in names)


def test_working_folder_that_is_gone_and_no_temporary_folder_are_named(stiction, program: Path, tmp_path: Path) -> None:
    gone, plan = tmp_path / "gone", _plan(tmp_path)
    for words, code, message in (
        (["export", plan, "-o", "motion.csv"], 2, "cannot be made or written (No such file or directory)"),
        (["import", "scene.xml"], 2, "working folder: got a path that cannot be used (No such file or directory)"),
        (["view", "planar_pushing", "--html", tmp_path / "page.html"], 70, "cannot make a folder in TMPDIR"),
    ):
        gone.mkdir()
        enter = ["sh", "-c", 'cd "$1" && rmdir "$1" && shift && exec "$@"', "sh", gone, "env", "TMPDIR=/nowhere", program]
        done = children.run([*enter, *words])
        assert done.returncode == code and message in done.stderr and done.stderr.count("\n") == 1, done.stderr


@pytest.mark.parametrize("words", [["grasps", "planar_hand", "-o", "/proc/grasps.npz"], ["report", "planar_hand", "-o", "/proc/report.zip"]], ids=lambda words: words[0])
def test_folder_that_cannot_be_written_is_named_before_the_work(stiction, words: list[str]) -> None:
    done = stiction(*words, "--timeout", "1e6", "--json", timeout=60)
    assert done.returncode == 2 and json.loads(done.stdout)["message"].startswith(f"{words[-1]}: cannot be written"), done.stderr


def _plan(folder: Path) -> Path:
    file = folder / "a_plan.json"
    st.plan(st.load_task("planar_pushing"), seed=0).plan.write(file)
    return file
