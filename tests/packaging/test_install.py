"""`cmake --install`: the program, its data, and a project of somebody else that uses the library."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from outside import BUILD, ROOT, build_consumer, run, same_step

VERSION = (ROOT / "VERSION").read_text(encoding="ascii").strip()
pytestmark = pytest.mark.limit(1200)


@pytest.fixture(scope="module")
def moved(prefix: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The installation elsewhere: whatever finds its data there looks beside itself."""
    return Path(shutil.copytree(prefix, tmp_path_factory.mktemp("moved") / "prefix"))


def test_an_installed_program_reads_the_tasks_beside_it(moved: Path, tmp_path: Path) -> None:
    program = moved / "bin" / "stiction"
    assert run(program, "--version", cwd=tmp_path).stdout.strip().endswith(VERSION)
    (moved / "share/stiction/tasks/only_here.yaml").write_text((ROOT / "tasks/planar_pushing.yaml").read_text(encoding="utf-8"), encoding="utf-8")
    names = [task["name"] for task in json.loads(run(program, "tasks", "--json", cwd=tmp_path).stdout)["tasks"]]
    assert "only_here" in names and {path.stem for path in ROOT.glob("tasks/*.yaml")} < set(names)
    run(program, "plan", "only_here", "--seed", 0, "-o", tmp_path / "out", cwd=tmp_path)
    run(program, "check", tmp_path / "out", cwd=tmp_path)


def test_a_project_finds_the_installed_library(moved: Path, tmp_path: Path) -> None:
    """The same step as that of the Python module, with the data of the installation."""
    consumer = build_consumer(tmp_path, f"-DCMAKE_PREFIX_PATH={moved}")
    version, task, scenario, status, moves = run(consumer, "planar_pushing", cwd=tmp_path).stdout.splitlines()
    assert version == VERSION and status == "Solved"
    assert Path(task) == moved / "share/stiction/tasks/planar_pushing.yaml"
    assert Path(scenario) == moved / "share/stiction/scenarios/ur5_forearm.yaml"
    same = same_step(ROOT / ".venv/bin/python", tmp_path, PYTHONPATH=str(BUILD / "python"))
    assert float(moves) == pytest.approx(same, rel=1e-6), "a step of the module of the build"
    missing = run(consumer, "no_such_task", cwd=tmp_path, expected=-6)
    assert "planar_pushing" in missing.stderr


def test_a_project_of_another_version_is_refused(prefix: Path, tmp_path: Path) -> None:
    (tmp_path / "CMakeLists.txt").write_text("cmake_minimum_required(VERSION 3.25)\nproject(old LANGUAGES NONE)\nfind_package(stiction 99.0 CONFIG REQUIRED)\n", encoding="ascii")
    done = run("cmake", "-S", tmp_path, "-B", tmp_path / "build", f"-DCMAKE_PREFIX_PATH={prefix}", cwd=tmp_path, expected=1)
    assert f"version: {VERSION}" in done.stderr
