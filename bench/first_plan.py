#!/usr/bin/env python3
"""How long a newcomer waits: an empty environment, `pip install WHEEL` with what it depends on, and three lines that give a checked plan.

    bench/first_plan.py dist/stiction-*.whl [--task allegro_cube] [--limit 120] [--json]

Nothing is taken from pip's cache. Exit code 1: the plan is not accepted, or all of it took longer than the limit [s].
"""

import argparse
import json
import pathlib
import subprocess
import sys
import tempfile
import time

LINES = """import stiction as st
plan = st.plan(st.load_task({task!r}), seed=0, timeout_s=60).plan
print(st.check_plan(plan).pass_)
"""


def timed(*words):
    start = time.monotonic()
    done = subprocess.run([str(word) for word in words], stdin=subprocess.DEVNULL, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"first_plan: {words[0]} ended with {done.returncode}: {done.stderr[-2000:]}")
    return time.monotonic() - start, done.stdout


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("wheel", type=pathlib.Path)
    parser.add_argument("--task", default="allegro_cube")
    parser.add_argument("--limit", type=float, default=120.0)
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        venv = pathlib.Path(name) / "venv"
        made, _ = timed(sys.executable, "-m", "venv", venv)
        installed, _ = timed(venv / "bin/python", "-m", "pip", "install", "--quiet", "--no-cache-dir", "--disable-pip-version-check", arguments.wheel.resolve())
        planned, printed = timed(venv / "bin/python", "-I", "-c", LINES.format(task=arguments.task))
    accepted = printed.split()[-1] == "True"
    total = made + installed + planned
    out = {"task": arguments.task, "venv_s": made, "install_s": installed, "plan_s": planned, "total_s": total, "accepted": accepted}
    if arguments.json:
        print(json.dumps(out))
    else:
        print(f"{arguments.task}: {'accepted' if accepted else 'not accepted'} after {total:.0f} s: environment {made:.0f}, installation {installed:.0f}, three lines {planned:.0f}")
    sys.exit(0 if accepted and total < arguments.limit else 1)


if __name__ == "__main__":
    main()
