"""Whether the compiled files of this package can run here. Also read, without the package, by the command `stiction` of the wheel."""

from __future__ import annotations

import os
import platform
import sys
import sysconfig
from pathlib import Path

# What x86-64-v3 adds, by the names of the kernel.
V3_FLAGS = ("avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "abm", "movbe", "xsave")


def _is_for(python: str) -> bool:
    """Whether `3.11`, or `3.12+` of the stable interface, is this Python. The interface of one without a global lock is another."""
    if sysconfig.get_config_var("Py_GIL_DISABLED"):
        return False
    wanted = tuple(int(part) for part in python.rstrip("+").split("."))
    return sys.version_info[:2] >= wanted if python.endswith("+") else sys.version_info[:2] == wanted


def _has_glibc() -> bool:
    try:
        return (os.confstr("CS_GNU_LIBC_VERSION") or "").startswith("glibc")
    except (ValueError, OSError):  # a name that another C library does not know
        return False


def what_does_not_fit(package: Path, cpuinfo: Path = Path("/proc/cpuinfo")) -> str | None:
    """Why the compiled files of a package cannot run here; None where they can."""
    built = dict(line.split("=", 1) for line in (package / "built_for.txt").read_text(encoding="ascii").splitlines())
    python = f"{sys.version_info.major}.{sys.version_info.minor}"
    if not _is_for(built["python"]):
        kind = " without a global lock" if sysconfig.get_config_var("Py_GIL_DISABLED") else ""
        return f"stiction was built for Python {built['python']}, this is Python {python}{kind}: install the wheel for it"
    if built["processor"] != platform.machine():
        return f"stiction was built for {built['processor']} processors, this is {platform.machine()}: install the wheel for it"
    if built["libc"] == "glibc" and not _has_glibc():
        return "stiction was built for the C library glibc, which this system (musl?) does not have: use a Debian, Ubuntu, Fedora or another system with it, or build from source"
    if built["march"] == "x86-64-v3" and cpuinfo.exists():
        lines = [line for line in cpuinfo.read_text(encoding="utf-8", errors="replace").splitlines() if line.startswith("flags")]
        missing = [flag for flag in V3_FLAGS if lines and flag not in lines[0].split()]
        if missing:
            return (
                f"stiction was built for x86-64-v3 processors, this one has no {', '.join(missing)}: "
                "build the wheel here, or with --config-settings=cmake.define.STICTION_ARCH="
            )
    return None
