#!/usr/bin/env python3
"""Which URDF files load as they are and take a step, each beside an object far away, and why the others do not.

    .venv/bin/python bench/public_robots.py [FOLDER …] [--json FILE]

Without a folder: those of the package example-robot-data. Packages (package://) are looked for in each FOLDER and above each file.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "build" / "release" / "python"))

import stiction as st  # noqa: E402

PACKAGES = next((ROOT / ".venv").glob("lib/python3*/site-packages/cmeel.prefix/share"))
FAR = {"name": "box", "joint": "planar_xy", "mass": 1, "pose": {"position": [50, 0, 0]}, "shapes": [{"box": {"size": [0.1, 0.1, 0.1]}}]}


def urdf_files(folder: Path) -> list[Path]:
    return sorted(folder.rglob("*.urdf"))


def load(file: Path, packages: list[Path] | None = None) -> tuple[st.Model, st.Status]:
    """The model of the robot and the status of one step at rest. Raises st.InvalidInput."""
    robot = {"name": "robot", "urdf": file, "package_dirs": [str(p) for p in packages or [PACKAGES]]}
    model = st.load_model({"gravity": [0, 0, 0], "robots": [robot], "objects": [FAR]})
    q = model.neutral()
    return model, st.step(model, q, q[model.n_qu :]).status


def reason(file: Path, packages: list[Path]) -> str:
    """Why it does not, in short; empty if it does."""
    try:
        _, status = load(file, packages)
    except st.InvalidInput as error:
        first = str(error).splitlines()[0]
        return re.sub(r"^\S*:\d+: ", "", first.replace(f"{file}", file.name))
    return "" if status == st.Status.Solved else f"step: {status.name}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="*", type=Path, default=[PACKAGES / "example-robot-data" / "robots"])
    parser.add_argument("--json", type=Path, help="results by file")
    arguments = parser.parse_args()
    results = {}
    for folder in arguments.folders:
        for file in urdf_files(folder):
            results[str(file.relative_to(folder))] = reason(file, [PACKAGES, folder])
    for name, why in results.items():
        if why:
            print(f"{name}: {why}")
    kinds = Counter("loads and takes a step" if not why else "does not" for why in results.values())
    print(f"{kinds['loads and takes a step']} of {len(results)} load as they are and take a step")
    if arguments.json:
        arguments.json.write_text(json.dumps(results, indent=2) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
