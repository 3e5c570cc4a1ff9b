from __future__ import annotations

from pathlib import Path

import pytest
from outside import BUILD, run


@pytest.fixture(scope="session")
def prefix(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An installation of the Release build."""
    if not (BUILD / "stiction").exists():
        pytest.skip("build/release/stiction does not exist: run `make build`")
    out = tmp_path_factory.mktemp("prefix")
    for component in ("program", "development"):
        run("cmake", "--install", BUILD, "--prefix", out, "--component", component, cwd=out)
    return out
