#!/usr/bin/env python3
"""How soon `stiction studio` shows something: from the start of the program to the first picture, from a new goal to its plan on the page.

    .venv/bin/python bench/studio.py [TASK] [--runs N] [--size 1280x800]

Needs Chromium. The browser draws in software: its part is that of a machine without a graphics card. `program` is the time until the address is printed,
`page` from then on until the object is seen, `empty` the same of a page of viser with one box; `searched` is the time of the search itself, `shown` from the new goal until its plan is on the page.
`sent` and `made` are processor time of the program until the first picture, and from a new goal to its plan: they hardly depend on what else runs.
`processors` is how much of one processor a busy thread got meanwhile, 1 on an idle machine: below that the times are those of a busy one.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests" / "python"))

import browser  # noqa: E402
from studio_window import Program, Window  # noqa: E402


def share_of_processor() -> float:
    """Of a thread that does nothing but count."""
    wall, used = time.monotonic(), time.process_time()
    while time.process_time() - used < 0.2:
        pass
    return (time.process_time() - used) / (time.monotonic() - wall)


def processor_time(pid: int) -> float:
    """Of a program until now, all its threads [s]."""
    words = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")


EMPTY = """
import viser
server = viser.ViserServer(port=0, verbose=False)
server.scene.configure_environment_map(None)
server.scene.add_box("/box", color=(255, 150, 40), dimensions=(1, 1, 1))
server.gui.add_button("Open")
server.gui.add_button("Export")
print(f"http://localhost:{server.get_port()}", flush=True)
server.sleep_forever()
"""


def empty(size: tuple[int, int]) -> float:
    """Until a page is seen that owes nothing to stiction [s]."""
    with browser.Browser() as chromium, tempfile.TemporaryDirectory() as folder:
        window = Window(chromium, Path(folder), size)
        with subprocess.Popen([sys.executable, "-c", EMPTY], stdout=subprocess.PIPE, text=True) as server:
            try:
                address = next(line.strip() for line in server.stdout if line.startswith("http://localhost"))
                begin = time.monotonic()
                window.visit(address)
                return time.monotonic() - begin
            finally:
                server.kill()


def one(task: str, size: tuple[int, int], goal: float) -> dict[str, float]:
    with browser.Browser() as chromium, tempfile.TemporaryDirectory() as folder:
        window = Window(chromium, Path(folder), size)
        begin = time.monotonic()
        with Program(ROOT / "build" / "release" / "stiction", task, root=ROOT) as program:
            printed = time.monotonic()
            window.visit(program.address)
            seen = time.monotonic()
            sent = processor_time(program.process.pid)
            window.wait_text("Lint finds")
            window.press("Plan anew when moved", "label")
            moved, before = time.monotonic(), processor_time(program.process.pid)
            window.fill("yaw [rad]", goal)
            found = window.wait_text(r"(?:solved|path so far) in ([\d.]+) s")
            shown, made = time.monotonic(), processor_time(program.process.pid) - before
    return {"program": printed - begin, "page": seen - printed, "empty": empty(size), "searched": float(found.group(1)), "shown": shown - moved, "sent": sent, "made": made, "processors": share_of_processor()}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("task", nargs="?", default="allegro_cube")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--goal", type=float, default=1.2, help="yaw of the new goal [rad]")
    parser.add_argument("--size", default="1280x800")
    args = parser.parse_args()
    width, height = map(int, args.size.split("x"))
    runs = []
    for _ in range(args.runs):
        runs.append(one(args.task, (width, height), args.goal))
        print("  ".join(f"{name} {value:.2f}" for name, value in runs[-1].items()), flush=True)
    print("median [s]: " + "  ".join(f"{name} {statistics.median(r[name] for r in runs):.2f}" for name in runs[0]))


if __name__ == "__main__":
    main()
