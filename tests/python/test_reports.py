"""`stiction report`: what is in it, and what is not."""

from __future__ import annotations

import json
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
MODULE = ROOT / "build" / "release" / "python"
if not (MODULE / "stiction").is_dir():
    pytest.skip(f"{MODULE} does not exist: run `make build`", allow_module_level=True)
sys.path.insert(0, str(MODULE))

from stiction.reports import Scrubber, names_here  # noqa: E402


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("/home/erika/secret/arm.urdf:12: joint", ".../arm.urdf:12: joint"),
        ("read '/data/customer/b.yaml' and ~/b/c.csv", "read '.../b.yaml' and .../c.csv"),
        (r"C:\Users\Erika\tasks\one.yaml", ".../one.yaml"),
        ("urdf: ../../customer/models/hand.urdf", "urdf: .../hand.urdf"),
        ("urdf: models/hand.urdf", "urdf: .../hand.urdf"),
        ("got '/media/Jane Doe/lab 3/my arm.urdf', expected", "got '.../my arm.urdf', expected"),
        ("/media/Jane Doe/scene.yaml:3: joint and ../Jane van Doe/arm.urdf", ".../scene.yaml:3: joint and .../arm.urdf"),
        (r"C:\Users\Jane Doe\one.yaml is 5 N/m", ".../one.yaml is 5 N/m"),
        ("package://customer_robots/arm/arm.xml", ".../arm.xml"),
        ("file:///srv/x/y.stl", ".../y.stl"),
        ("Erika on BOX17 wrote to erika.mustermann@example.org from 10.1.2.3", "NAME on NAME wrote to ADDRESS from ADDRESS"),
        ("stiffness 3 N m/rad, 1.5 N/m and/or, hand/link_0.0/collision, arm/link", "stiffness 3 N m/rad, 1.5 N/m and/or, hand/link_0.0/collision, arm/link"),
        ("error 1e-3/2, 50 % [m/s]", "error 1e-3/2, 50 % [m/s]"),
    ],
)
def test_scrubber_takes_paths_and_names_and_leaves_units_and_bodies(text: str, expected: str) -> None:
    assert Scrubber(["erika", "box17"])(text) == expected


@pytest.mark.parametrize("text", ["ab/" * 2000, "/a b" * 2000, "/a b/" * 2000, "a.b/" * 2000, "../" * 2000, "/" * 2000, "a b c " * 2000], ids=lambda text: repr(text[:6]))
def test_long_texts_are_scrubbed_in_no_time(text: str) -> None:
    """As base64 in a log, which has slashes and no ending."""
    assert "x" in Scrubber([])(f"{text} x"), "a pattern that tries every division of a text would take for ever"


def test_names_that_many_have_stay() -> None:
    assert Scrubber(["root", "user"])("the root of the tree, a user") == "the root of the tree, a user"
    assert Path.home().name in names_here()


def test_report_of_an_own_task_has_all_that_is_needed_and_no_path(stiction, tmp_path: Path) -> None:
    folder = tmp_path / "customer_acme"
    folder.mkdir()
    base = ROOT / "tasks" / "planar_pushing.yaml"
    task = folder / "push.yaml"
    task.write_text(base.read_text(encoding="utf-8").replace("../models", str(ROOT / "models")).replace("name: planar_pushing", "name: push"), encoding="utf-8")
    log = folder / "log.txt"
    log.write_text(f"opened {task}\nfailed\n", encoding="utf-8")
    done = stiction("report", task, "--seed", 3, "--log", log, "--note", f"it fails in {folder}/x.yaml", "-o", tmp_path / "report.zip", "--json")
    assert done.returncode == 0, done.stderr
    with zipfile.ZipFile(tmp_path / "report.zip") as packed:
        files = {name: packed.read(name).decode() for name in packed.namelist()}
    assert set(files) == {"report.json", "task.yaml", "plan.json", "log_0.txt"} == set(json.loads(done.stdout)["files"])
    about = json.loads(files["report.json"])
    assert about["tried"]["seed"] == 3 and about["tried"]["status"] == "Solved" and not about["built_in"]
    assert about["code_version"] == (ROOT / "VERSION").read_text().strip() and about["machine"]["python"].startswith("3.")
    assert json.loads(files["plan.json"])["seed"] == 3
    assert "opened .../push.yaml" in files["log_0.txt"] and "urdf: .../planar_pusher.urdf" in files["task.yaml"]
    everything = "\n".join(files.values())
    for telling in (str(ROOT), str(tmp_path), "customer_acme", *(part for part in tmp_path.parts[1:3] if len(part) > 3)):
        assert telling not in everything, telling


def test_report_of_a_plan_says_what_the_check_says(stiction, real_plan: Path, tmp_path: Path) -> None:
    done = stiction("report", real_plan, "-o", tmp_path / "r.zip")
    assert done.returncode == 0, done.stderr
    with zipfile.ZipFile(tmp_path / "r.zip") as packed:
        about = json.loads(packed.read("report.json"))
    assert about["built_in"] and about["tried"]["seed"] == 0 and "passed" in about["tried"]["check"]


def test_log_that_is_not_there_is_named(stiction, tmp_path: Path) -> None:
    done = stiction("report", "planar_pushing", "--log", tmp_path / "none.txt", "-o", tmp_path / "r.zip")
    assert done.returncode == 2 and "none.txt: cannot be read" in done.stderr and not (tmp_path / "r.zip").exists()
