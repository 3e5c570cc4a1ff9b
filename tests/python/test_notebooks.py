"""The notebooks: every code cell runs, as Python without Jupyter, in a folder of its own."""

from __future__ import annotations

import json
import os
import re
import sys
from pathlib import Path

import children
import pytest

ROOT = Path(__file__).resolve().parents[2]
NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))
sys.path.insert(0, str(ROOT / "scripts"))

import notebooks  # noqa: E402


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_cells_of_a_notebook_run(notebook: Path, program: Path, tmp_path: Path) -> None:
    outputs = tmp_path / "outputs.json"
    words = [sys.executable, ROOT / "scripts" / "notebooks.py", notebook, "--json", outputs]
    done = children.run(words, cwd=tmp_path, limit=120, env={**os.environ, "PYTHONPATH": str(program.parent / "python")})
    assert done.returncode == 0, done.stdout + done.stderr
    shown = json.loads(outputs.read_text(encoding="utf-8"))
    assert len(shown) == sum(kind == "code" for kind, _ in notebooks.cells_of(notebook))
    assert any(output["text"].strip() for output in shown), "nothing is printed"
    for output in shown:
        assert str(ROOT) not in output["text"] and "Traceback" not in output["text"]
    if "show(" in notebook.read_text(encoding="utf-8"):
        assert any("<iframe srcdoc=" in output["html"] for output in shown), "a plan is shown"


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_file_of_a_notebook_is_clean_and_links_lead_somewhere(notebook: Path) -> None:
    document = json.loads(notebook.read_text(encoding="utf-8"))
    assert document["nbformat"] == 4 and len({cell["id"] for cell in document["cells"]}) == len(document["cells"])
    assert all(not cell["outputs"] and cell["execution_count"] is None for cell in document["cells"] if cell["cell_type"] == "code"), "outputs are made when the site is"
    for kind, text in notebooks.cells_of(notebook):
        for target in re.findall(r"\]\(([^)\s]+)\)", text) if kind == "markdown" else []:
            assert (notebook.parent / target.split("#")[0]).exists(), target


def test_there_are_some_and_the_index_has_all() -> None:
    index = (ROOT / "docs" / "notebooks" / "README.md").read_text(encoding="utf-8")
    assert len(NOTEBOOKS) >= 6 and all(f"]({notebook.name})" in index for notebook in NOTEBOOKS)


def test_cell_that_fails_is_named_with_its_number(tmp_path: Path) -> None:
    cells = [{"cell_type": "code", "source": ["x = 1\n", "x"]}, {"cell_type": "code", "source": ["x / 0"]}]
    (tmp_path / "bad.ipynb").write_text(json.dumps({"cells": cells}), encoding="ascii")
    done = children.run([sys.executable, ROOT / "scripts" / "notebooks.py", tmp_path / "bad.ipynb"], cwd=tmp_path, limit=60)
    assert done.returncode == 1 and "bad.ipynb, cell 2" in done.stderr and "ZeroDivisionError" in done.stderr


def test_value_of_the_last_line_is_shown_unless_a_semicolon_hides_it() -> None:
    assert notebooks.run_cell("x = 2\nx + 1", "cell", {}) == {"text": "3\n", "html": ""}
    assert notebooks.run_cell("print(1)\n4;", "cell", {}) == {"text": "1\n", "html": ""}
    assert notebooks.run_cell("x = 2", "cell", {}) == {"text": "", "html": ""}


def test_page_of_a_notebook_has_its_text_code_outputs_and_frames(tmp_path: Path) -> None:
    cells = [{"cell_type": "markdown", "source": ["# Title"]}, {"cell_type": "code", "source": ["1 + 1"]}, {"cell_type": "code", "source": ["page"]}]
    (tmp_path / "n.ipynb").write_text(json.dumps({"cells": cells}), encoding="ascii")
    text, pages = notebooks.to_markdown(tmp_path / "n.ipynb", [{"text": "2\n", "html": ""}, {"text": "", "html": '<iframe srcdoc="&lt;p&gt;" width="1"></iframe>'}])
    assert text.startswith("# Title\n\n```python\n1 + 1\n```\n\n```text\n2\n```") and '<iframe src="n_1.html"' in text
    assert pages == {"n_1.html": "<p>"}, "the page itself, not a frame in a frame"
