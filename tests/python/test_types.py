"""Types: the stub fits what users write, and the Python of the packages fits the stub (mypy, as pyproject.toml sets it)."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import children
import pytest

ROOT = Path(__file__).resolve().parents[2]
pytest.importorskip("mypy")
pytestmark = pytest.mark.limit(900)


def mypy(*files: object) -> subprocess.CompletedProcess[str]:
    return children.run([sys.executable, "-m", "mypy", *files], cwd=ROOT, limit=600)


def test_packages_examples_and_what_users_write_have_types() -> None:
    module = sorted((ROOT / "python" / "module" / "stiction").glob("*.py"))
    viewer = sorted((ROOT / "python" / "stiction_view").glob("*.py"))
    others = [ROOT / "python" / "stiction_program.py", ROOT / "tests" / "python" / "whole_api.py", *sorted((ROOT / "python" / "examples").glob("*.py"))]
    done = mypy(*module, *viewer, *others)
    assert done.returncode == 0, done.stdout + done.stderr


def test_mistakes_of_users_are_seen(tmp_path: Path) -> None:
    """The check above says nothing where the stub takes everything."""
    file = tmp_path / "wrong.py"
    file.write_text(
        "import stiction as st\n"
        "task = st.load_task('planar_pushing')\n"
        "st.plan(task, sed=0)\n"
        "st.plan(task, seed='0')\n"
        "n: str = len(st.plan(task).plan)\n"
        "st.plan(task).plan.qq\n",
        encoding="ascii",
    )
    done = mypy(file)
    assert [line.split(":")[1] for line in done.stdout.splitlines() if "error:" in line] == ["3", "4", "5", "6"], done.stdout
