"""Programs that are run as if there were no clone."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "python"))

import children  # noqa: E402

ROOT = Path(__file__).resolve().parents[2]
BUILD = ROOT / "build" / "release"


def run(*words: object, cwd: Path, expected: int = 0, timeout: float = 300, **variables: str) -> subprocess.CompletedProcess[str]:
    """Runs a program that is told nothing about the clone."""
    env = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "VIRTUAL_ENV", "LD_LIBRARY_PATH")}
    done = children.run(words, cwd=cwd, env={**env, **variables}, limit=timeout)
    assert done.returncode == expected, f"{words}: {done.returncode}\n{done.stdout[-4000:]}{done.stderr[-4000:]}"
    return done


LIMIT_BYTES = 25e6


def check_wheel(wheel: Path) -> list[str]:
    """Asserts that a wheel is small and names nothing of this machine; its files."""
    assert wheel.stat().st_size < LIMIT_BYTES
    here = [f"{folder}/".encode() for folder in {ROOT, ROOT.resolve(), Path(sys.prefix).resolve()}]
    with zipfile.ZipFile(wheel) as archive:
        names = [name for name in archive.namelist() if not name.endswith("/")]
        told = [(name, folder) for name in names for folder in here if folder in archive.read(name)]
    assert not told
    return names


def build_consumer(folder: Path, *options: str) -> Path:
    """The program of a project of somebody else that finds the library by these options of CMake."""
    source = Path(shutil.copytree(ROOT / "tests/packaging/consumer", folder / "consumer"))
    build = folder / "build"
    run("cmake", "-G", "Ninja", "-S", source, "-B", build, "-DCMAKE_BUILD_TYPE=Release", *options, cwd=folder)
    flags = (build / "build.ninja").read_text(encoding="utf-8")
    assert f"{ROOT}/src" not in flags and "-Werror" not in flags
    run("cmake", "--build", build, cwd=folder)
    return build / "consumer"


def same_step(python: Path, cwd: Path, **variables: str) -> float:
    """Largest change of a coordinate in the consumer's step, by the Python module."""
    script = (
        "import numpy as np, stiction as st; t = st.load_task('planar_pushing'); q = np.array(t.q_start)\n"
        "print(abs(st.step(t.model, q, q[len(q) - t.model.n_a:]).q_next - q).max())"
    )
    return float(run(python, "-c", script, cwd=cwd, **variables).stdout)
