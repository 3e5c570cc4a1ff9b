"""Whether the compiled files of this package can run here. Also read, without the package, by the command `stiction` of the wheel."""

from __future__ import annotations

import platform
import sys
from pathlib import Path

# What x86-64-v3 adds, by the names of the kernel.
V3_FLAGS = ("avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "abm", "movbe", "xsave")


def what_does_not_fit(package: Path, cpuinfo: Path = Path("/proc/cpuinfo")) -> str | None:
    """Why the compiled files of a package cannot run here; None where they can."""
    built = dict(line.split("=", 1) for line in (package / "built_for.txt").read_text(encoding="ascii").splitlines())
    python = f"{sys.version_info.major}.{sys.version_info.minor}"
    if built["python"] != python:
        return f"stiction was built for Python {built['python']}, this is Python {python}: install the wheel for cp{python.replace('.', '')}"
    if built["processor"] != platform.machine():
        return f"stiction was built for {built['processor']} processors, this is {platform.machine()}: install the wheel for it"
    if built["march"] == "x86-64-v3" and cpuinfo.exists():
        lines = [line for line in cpuinfo.read_text(encoding="utf-8", errors="replace").splitlines() if line.startswith("flags")]
        missing = [flag for flag in V3_FLAGS if lines and flag not in lines[0].split()]
        if missing:
            return (
                f"stiction was built for x86-64-v3 processors, this one has no {', '.join(missing)}: "
                "build the wheel here, or with --config-settings=cmake.define.STICTION_ARCH="
            )
    return None
