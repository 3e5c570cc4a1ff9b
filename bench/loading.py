#!/usr/bin/env python3
"""Processor seconds that a robot takes to load: with an empty cache of hulls, and again.

    .venv/bin/python bench/loading.py [--robots FOLDER] [--program FILE] [--only TEXT] [--json FILE]

Runs `stiction lint` on a task that places each URDF file beside a box far away: lint does least besides loading. The folder of the cache is
a temporary one, empty for each robot. The second load is the fastest of three. Refused robots are listed with the reason.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = next((ROOT / ".venv").glob("lib/python3*/site-packages/cmeel.prefix/share"), Path())
REFUSED = 2  # exit code of the program
AGAIN = 3

TASK = """scene:
  robots: [{{name: robot, urdf: {urdf}, package_dirs: [{packages}]}}]
  objects: [{{name: box, joint: planar_xy, mass: 1, pose: {{position: [50, 0, 0]}}, shapes: [{{box: {{size: [0.1, 0.1, 0.1]}}}}]}}]
start: {{objects: {{box: {{coordinates: [0, 0, 0]}}}}}}
goal: {{objects: {{box: {{coordinates: [0.1, 0, 0]}}}}}}
tolerance: {{position: 0.02, angle: 0.1}}
"""


def lint(program: Path, task: Path, cache: Path) -> tuple[float, str]:
    """Processor seconds, and why the task is refused; empty where it is not."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([program, "lint", task], env={**os.environ, "STICTION_CACHE": str(cache)}, capture_output=True, text=True, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    if done.returncode == REFUSED:
        return seconds, done.stderr.splitlines()[0]
    if done.returncode not in (0, 1):
        raise RuntimeError(f"{program} lint ended with {done.returncode}: {done.stderr}")
    return seconds, ""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robots", type=Path, default=PACKAGES / "example-robot-data" / "robots", help="folder of URDF files")
    parser.add_argument("--program", type=Path, default=ROOT / "build" / "release" / "stiction")
    parser.add_argument("--only", default="", help="part of the paths of the files that are loaded")
    parser.add_argument("--json", type=Path, help="results by file")
    arguments = parser.parse_args()
    results: dict[str, dict[str, float]] = {}
    print("first  second  [s]")
    for urdf in sorted(arguments.robots.rglob("*.urdf")):
        name = str(urdf.relative_to(arguments.robots))
        if arguments.only not in name:
            continue
        with tempfile.TemporaryDirectory() as folder:
            task = Path(folder) / "task.yaml"
            task.write_text(TASK.format(urdf=json.dumps(str(urdf)), packages=json.dumps(str(PACKAGES))), encoding="utf-8")
            first, refused = lint(arguments.program, task, Path(folder) / "cache")
            if refused:
                print(f"               {name}: {refused.replace(str(urdf), urdf.name)}")
                continue
            second = min(lint(arguments.program, task, Path(folder) / "cache")[0] for _ in range(AGAIN))
        results[name] = {"first": round(first, 3), "second": round(second, 3)}
        print(f"{first:5.2f}  {second:6.2f}  {name}", flush=True)
    if results:
        for load in ("first", "second"):
            seconds = [result[load] for result in results.values()]
            print(f"{load} load of {len(seconds)} robots: {sum(seconds):.2f} s in all, {max(seconds):.2f} s at most")
    if arguments.json:
        arguments.json.write_text(json.dumps(results, indent=2) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
