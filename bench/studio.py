#!/usr/bin/env python3
"""How soon `stiction studio` shows something: from the start of the program to the first picture, from a new goal to its plan on the page.

    .venv/bin/python bench/studio.py [TASK] [--runs N] [--size 1280x800]
    .venv/bin/python bench/studio.py TASK --drag LINK

Needs Chromium. The browser draws in software: its part is that of a machine without a graphics card. `program` is the time until the address is printed,
`page` from then on until the object is seen, `empty` the same of a page of viser with one box; `searched` is the time of the search itself, `shown` from the new goal until its plan is on the page.
`sent` and `made` are processor time of the program until the first picture, and from a new goal to its plan: they hardly depend on what else runs.
With --drag no browser is needed: a link goes round in a circle of 80 mm and then ten times as far, out of reach. `tick` is the time from a new place of the handle until all that is drawn
and all numbers have followed, `own` its processor time, which hardly depends on what else runs, `solver` the part of it in which the joints are looked for, in milliseconds.
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


def drag(name: str, link: str) -> None:
    """One link, tick by tick, as the page posts it."""
    sys.path[:0] = [str(ROOT / "build" / "release" / "python"), str(ROOT / "python")]
    import numpy as np
    import stiction as st

    from stiction_view.studio import catalog
    from stiction_view.studio.app import Studio
    from stiction_view.studio.server import serving

    entries, first = catalog.find(name)
    with tempfile.TemporaryDirectory() as folder, serving("127.0.0.1", 0) as server:
        studio = Studio(server, entries, first, Path(folder))
        posing = studio.posing
        problem = posing.problem
        posing.pick(link)
        studio.step(0.1)
        grip = posing.grips()[0]
        if grip.link != link:
            sys.exit(f"--drag: got {link!r}, expected one of {', '.join(k.name for k in problem.model.links)}")
        X = problem.model.body_poses(problem.start)[grip.link]
        for words, radius in (("in reach", 0.08), ("out of reach", 0.8)):
            ticks, own, solver = [], [], []
            for angle in np.linspace(0, 2 * np.pi, 60):
                wanted = st.Pose(X.R, X.p + radius * np.array([np.sin(angle), 1 - np.cos(angle), 0.3 * np.sin(2 * angle)]))
                begin = time.perf_counter()
                st.place_links(problem.model, problem.start, {grip.link: wanted if grip.turns else wanted.p}, postures=1, overlap=True)
                solver.append(1e3 * (time.perf_counter() - begin))
                posing.drag(grip, wanted, False)
                begin, used = time.perf_counter(), time.thread_time()
                studio.desk.do_all(0.0)
                ticks.append(1e3 * (time.perf_counter() - begin))
                own.append(1e3 * (time.thread_time() - used))
            figures = "  ".join(f"{what} {statistics.median(ms):.1f} (longest {max(ms):.1f})" for what, ms in (("tick", ticks), ("own", own), ("solver", solver)))
            print(f"{words}: {figures} ms  processors {share_of_processor():.2f}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("task", nargs="?", default="allegro_cube")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--goal", type=float, default=1.2, help="yaw of the new goal [rad]")
    parser.add_argument("--size", default="1280x800")
    parser.add_argument("--drag", metavar="LINK", help="drag a link, without a browser")
    args = parser.parse_args()
    if args.drag is not None:
        return drag(args.task, args.drag)
    width, height = map(int, args.size.split("x"))
    runs = []
    for _ in range(args.runs):
        runs.append(one(args.task, (width, height), args.goal))
        print("  ".join(f"{name} {value:.2f}" for name, value in runs[-1].items()), flush=True)
    print("median [s]: " + "  ".join(f"{name} {statistics.median(r[name] for r in runs):.2f}" for name in runs[0]))


if __name__ == "__main__":
    main()
