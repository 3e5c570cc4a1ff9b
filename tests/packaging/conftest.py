from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "python"))

import pytest  # noqa: E402
from limits import pytest_runtest_call, pytest_runtest_setup, pytest_runtest_teardown  # noqa: E402, F401  # each test has a limit
from outside import BUILD, run  # noqa: E402


@pytest.fixture(scope="session")
def prefix(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An installation of the Release build."""
    if not (BUILD / "stiction").exists():
        pytest.skip("build/release/stiction does not exist: run `make build`")
    out = tmp_path_factory.mktemp("prefix")
    for component in ("program", "development"):
        run("cmake", "--install", BUILD, "--prefix", out, "--component", component, cwd=out)
    return out


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "limit(seconds): another limit than limits.LIMIT for a test that takes longer")
