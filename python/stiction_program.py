"""The command `stiction` of the wheel: starts the program that lies inside the package `stiction`, and says which Python draws its pages."""

from __future__ import annotations

import os
import runpy
import sys
from pathlib import Path


def main() -> None:
    package = Path(__file__).resolve().parent / "stiction"
    fits = runpy.run_path(str(package / "_fits.py"))  # importing the package would load its libraries
    if fault := fits["what_does_not_fit"](package):
        raise SystemExit(fault)
    program = str(package / "bin" / "stiction")
    os.environ.setdefault("STICTION_PYTHON", sys.executable)
    os.execv(program, [program, *sys.argv[1:]])
