from __future__ import annotations

from pathlib import Path

import pytest
from outside import BUILD, run  # the first to be imported: it finds the tools of the other tests

from limits import pytest_runtest_call, pytest_runtest_setup, pytest_runtest_teardown  # noqa: F401  # each test has a limit


@pytest.fixture(scope="session")
def prefix(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An installation of the Release build."""
    if not (BUILD / "stiction").exists():
        pytest.skip("build/release/stiction does not exist: run `make build`")
    out = tmp_path_factory.mktemp("prefix")
    for component in ("program", "development"):
        run("cmake", "--install", BUILD, "--prefix", out, "--component", component, cwd=out)
    return out


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--wheels", metavar="FOLDER", help="where the wheels are that the tests with the mark 'release' install")


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "limit(seconds): another limit than limits.LIMIT for a test that takes longer")
    config.addinivalue_line("markers", "release: fetches packages; `make release` runs it")
