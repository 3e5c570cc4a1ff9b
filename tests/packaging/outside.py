"""Programs that are run as if there were no clone."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BUILD = ROOT / "build" / "release"


def run(*words: object, cwd: Path, expected: int = 0, timeout: float = 300, **variables: str) -> subprocess.CompletedProcess[str]:
    """Runs a program that is told nothing about the clone."""
    env = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "VIRTUAL_ENV", "LD_LIBRARY_PATH")}
    done = subprocess.run(
        [str(word) for word in words], cwd=cwd, env={**env, **variables}, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=timeout
    )
    assert done.returncode == expected, f"{words}: {done.returncode}\n{done.stdout[-4000:]}{done.stderr[-4000:]}"
    return done
