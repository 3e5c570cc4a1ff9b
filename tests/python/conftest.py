from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import children
import pytest
from limits import pytest_runtest_call, pytest_runtest_setup, pytest_runtest_teardown  # noqa: F401  # each test has a limit

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "python"))
os.environ.setdefault("STICTION_CACHE", str(ROOT / "build" / "cache"))  # tests write nothing to the cache of who runs them


@pytest.fixture(scope="session")
def root() -> Path:
    return ROOT


@pytest.fixture(scope="session")
def program(root: Path) -> Path:
    """The Release build of the command line; its tests are skipped where it was not built."""
    path = root / "build" / "release" / "stiction"
    if not path.exists():
        pytest.skip("build/release/stiction does not exist: run `make build`")
    return path


@pytest.fixture(scope="session")
def stiction(program: Path, root: Path):
    """Runs the program and returns its CompletedProcess."""

    def run(*arguments: object, timeout: float = children.LIMIT, cwd: Path = root) -> subprocess.CompletedProcess[str]:
        return children.run([program, *arguments], cwd=cwd, limit=timeout, env={**os.environ, "PYTHONPATH": str(root / "python")})

    return run


@pytest.fixture(scope="session")
def interrupted(program: Path):
    """Runs the program, sends it a signal after some seconds and returns its CompletedProcess."""

    def run(*arguments: object, after: float = 2, number: signal.Signals = signal.SIGINT) -> subprocess.CompletedProcess[str]:
        with children.Child([program, *arguments]) as child:
            with pytest.raises(subprocess.TimeoutExpired):
                child.communicate(timeout=after)
            return child.stop(number)

    return run


def _plan(stiction, folder: Path, task: str, seed: int) -> Path:
    done = stiction("plan", task, "--seed", seed, "-o", folder)
    assert done.returncode == 0, done.stderr
    return folder / "plan.json"


@pytest.fixture(scope="session")
def real_plan(stiction, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A plan file of the smallest built-in task."""
    return _plan(stiction, tmp_path_factory.mktemp("plan"), "planar_pushing", 0)


@pytest.fixture(scope="session")
def plan_file(stiction, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A plan file of two robots, regrasps and patches of contact."""
    return _plan(stiction, tmp_path_factory.mktemp("hand"), "planar_hand", 3)


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "limit(seconds): another limit than limits.LIMIT for a test that takes longer")
