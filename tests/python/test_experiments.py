"""`stiction reproduce`: every experiment passes in quick mode, and the pages are whole."""

from __future__ import annotations

import importlib.util
import json
import re
import sys
from pathlib import Path

import children
import jsonschema
import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
SCENES = sorted((ROOT / "experiments" / "scenes").glob("*.yaml"))
pytestmark = pytest.mark.limit(900)


@pytest.fixture(scope="module")
def report(stiction, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("reproduction")
    done = stiction("reproduce", "all", "--quick", "--json", "-o", folder, "--docs", folder / "chapter.md", timeout=600)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == json.loads((folder / "report.json").read_text())
    return folder


def test_every_experiment_passes_and_leaves_its_files(report: Path) -> None:
    out = json.loads((report / "report.json").read_text())
    assert out["status"] == "Done" and out["quick"] is True and out["code_version"]
    assert len(out["experiments"]) >= 7
    for experiment in out["experiments"]:
        assert experiment["passed"] and experiment["rows"], experiment["name"]
        assert any(row["passed"] for row in experiment["rows"]), experiment["name"]
        for file in experiment["files"]:
            assert (report / file).stat().st_size > 0


def test_page_holds_everything_itself(report: Path) -> None:
    page = (report / "report.html").read_text()
    pictures = len(list(report.glob("*/*.svg")))
    assert page.count("data:image/svg+xml;base64,") == pictures - len(list(report.glob("chapter/*.svg")))
    assert not re.search(r"""(src|href)=['"](?!data:)""", page)


def test_document_is_small_and_its_pictures_exist(report: Path) -> None:
    text = (report / "chapter.md").read_text()
    pictures = re.findall(r"\]\((chapter/[^)]+\.svg)\)", text)
    assert pictures and all((report / picture).exists() for picture in pictures)
    sizes = {picture: (report / picture).stat().st_size for picture in pictures}
    assert max(sizes.values()) < 75_000, sizes
    assert sum(sizes.values()) < 25_000 * len(sizes), sizes


def test_document_keeps_the_sections_of_other_experiments(stiction, report: Path, tmp_path: Path) -> None:
    page = tmp_path / "chapter.md"
    text = (report / "chapter.md").read_text()
    page.write_text(text.replace("| gap at h = 0.1 s |", "| something else |").replace("(2.26)", "(2.2.6)"))
    assert stiction("reproduce", "figure-2.1", "--quick", "-o", tmp_path, "--docs", page).returncode == 0
    assert page.read_text() == text.replace("(2.26)", "(2.2.6)")


def test_page_of_a_chapter_takes_its_experiments_only(stiction, tmp_path: Path) -> None:
    for name in ("figure-2.1", "errata-2"):
        assert stiction("reproduce", name, "--quick", "-o", tmp_path, "--docs", tmp_path / "chapter2.md").returncode == 0
    text = (tmp_path / "chapter2.md").read_text()
    assert text.startswith("# Chapter 2, reproduced\n") and text.count("\n## ") == 2
    assert stiction("reproduce", "figure-2.1", "--quick", "-o", tmp_path, "--docs", tmp_path / "chapter3.md").returncode == 0
    assert "## " not in (tmp_path / "chapter3.md").read_text()


def test_second_order_by_sap_is_shown_or_says_how_to_get_it(report: Path) -> None:
    experiments = {e["name"]: e for e in json.loads((report / "report.json").read_text())["experiments"]}
    for name in ("figure-2.7", "figure-2.10"):
        rows = [row for row in experiments[name]["rows"] if "SAP" in row["quantity"]]
        if importlib.util.find_spec("pydrake"):
            assert any(row["passed"] for row in rows)
        else:
            assert [row["note"] for row in rows] == ["Drake is not installed; `make experiments` installs it"]


def test_unknown_name_is_refused_with_the_list(stiction) -> None:
    done = stiction("reproduce", "figure-9.9")
    assert done.returncode == 2 and done.stdout == ""
    assert "figure-9.9" in done.stderr and "figure-2.1, " in done.stderr
    assert "figure-2.13" in stiction("reproduce", "--help").stdout


@pytest.mark.parametrize("path", SCENES, ids=lambda p: p.stem)
def test_every_scene_is_valid(path: Path) -> None:
    schema = json.loads((ROOT / "tasks/schema/scene.schema.json").read_text())
    jsonschema.Draft202012Validator(schema).validate(yaml.safe_load(path.read_text())["scene"])


@pytest.mark.parametrize(("name", "meshes"), [("iiwa_primitives", False), ("iiwa_meshes", True)])
def test_arm_is_what_its_script_writes(name: str, meshes: bool) -> None:
    sys.path.insert(0, str(ROOT))
    from experiments.make_iiwa import MODELS, make, make_tray

    assert (MODELS / "iiwa_tray.urdf").read_text(encoding="utf-8") == make_tray(), "run `python -m experiments.make_iiwa`"
    assert (MODELS / f"{name}.urdf").read_text(encoding="utf-8") == make(meshes), "run `python -m experiments.make_iiwa`"


def test_packages_of_the_extra_that_are_missing_are_named(program: Path, tmp_path: Path) -> None:
    (tmp_path / "sitecustomize.py").write_text("import sys\nsys.modules['matplotlib'] = None\n", encoding="ascii")
    python = tmp_path / "python"
    python.write_text(f'#!/bin/sh\nPYTHONPATH="{tmp_path}:$PYTHONPATH" exec "{sys.executable}" "$@"\n', encoding="ascii")
    python.chmod(0o755)
    words = [program, "reproduce", "figure-2.1", "--quick", "-o", tmp_path / "out"]
    done = children.run(words, limit=60, env={"STICTION_PYTHON": str(python), "PATH": "/usr/bin:/bin"})
    assert done.returncode == 70 and done.stderr == "stiction: reproduce: no Python module 'matplotlib'; `pip install 'stiction[reproduce]'` brings it\n"
