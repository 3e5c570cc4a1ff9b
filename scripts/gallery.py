#!/usr/bin/env python3
"""scripts/gallery.py: plans of the gallery of the site in build/docs/plans, each a page and a picture of it. What is unchanged since the last time is kept.

Needs build/release/stiction and Chromium (`make setup`).
"""

from __future__ import annotations

import hashlib
import html
import json
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PROGRAM = ROOT / "build/release/stiction"
OUT = ROOT / "build/docs"
SIZE, BUDGET = (480, 320), 120  # of a picture [px]; of a search [s]
PATIENCE = 120  # [s] for a page to be drawn
# Tasks in the order of the gallery: what a visitor sees, and the moment of the picture as a share of the motion.
TASKS = {
    "allegro_cube": ("A hand turns a cube by a quarter turn", 0.6),
    "allegro_cube_roll": ("A hand rolls a cube onto its next face", 0.6),
    "allegro_ball": ("A hand turns a ball by half a turn", 0.5),
    "allegro_pen": ("A hand lifts a pen and turns it", 0.7),
    "allegro_plate": ("A hand picks up a plate against a wall", 0.8),
    "allegro_door": ("A hand turns a handle and pushes a door open", 0.8),
    "iiwa_bimanual": ("Two arms turn a bucket with all of their links", 0.5),
    "iiwa_bimanual_box": ("Two arms tip a large box over its edge", 0.6),
    "iiwa_bimanual_planar": ("The same arms in a plane", 0.5),
    "ur5_mesh_push": ("A UR5 pushes a block given as a mesh", 0.6),
    "planar_hand": ("Two planar arms turn a ball", 0.5),
    "planar_pushing": ("A ball pushes a box: the smallest task", 0.5),
}


def fingerprint(task: str) -> str:
    """Of what a page is made of."""
    files = [PROGRAM, ROOT / f"tasks/{task}.yaml", Path(__file__), *sorted((ROOT / "python/stiction_view").glob("*.*"))]
    return hashlib.sha256(b"".join(hashlib.sha256(file.read_bytes()).digest() for file in files)).hexdigest()


def make_page(task: str) -> Path:
    """Plans it. Raises SystemExit: no plan in time."""
    folder = OUT / task
    done = subprocess.run([PROGRAM, "plan", task, "--seed", "0", "--timeout", str(BUDGET), "-o", folder, "--html"], capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"gallery: no plan of {task} in {BUDGET} s: {done.stdout}{done.stderr}")
    return next(folder.glob("*.html"))


def take_picture(page: Path, share: float, to: Path) -> None:
    """What a page shows at a moment, as a small picture."""
    sys.path.insert(0, str(ROOT / "tests/python"))
    import browser
    from PIL import Image

    quiet = "<style>#stiction, [class*=Notification], [class*=mantine-Paper], [class*=mantine-Box] > [class*=mantine-ActionIcon] {visibility: hidden !important}</style>"
    with browser.Browser() as window:
        window.call("Emulation.setDeviceMetricsOverride", width=SIZE[0], height=SIZE[1] + 40, deviceScaleFactor=1, mobile=False)
        window.open(page)
        window.wait_for(lambda: window.evaluate("!!document.querySelector('.mantine-Slider-track')"), PATIENCE, f"the time bar of {page}")
        time.sleep(1)  # until the first picture is drawn
        window.scrub(share)
        window.evaluate(f"document.head.insertAdjacentHTML('beforeend', {json.dumps(quiet)})")
        window.call("Runtime.evaluate", expression="new Promise((done) => setTimeout(() => requestAnimationFrame(() => requestAnimationFrame(() => done(true))), 1500))", awaitPromise=True)
        Image.fromarray(window.screenshot()[: SIZE[1]]).save(to, quality=70, method=6)


def make(task: str) -> None:
    plans, known = OUT / "plans", OUT / f"{task}.made_of"
    page, picture = plans / f"{task}.html", plans / f"{task}.webp"
    made_of = fingerprint(task)
    if page.exists() and picture.exists() and known.exists() and known.read_text() == made_of:
        return
    plans.mkdir(parents=True, exist_ok=True)
    page.write_bytes(make_page(task).read_bytes())
    take_picture(page, TASKS[task][1], picture)
    known.write_text(made_of)


def markup() -> str:
    """The gallery as HTML, for a page at the top of the site."""
    cards = [
        f'<a href="plans/{task}.html"><img src="plans/{task}.webp" alt="{html.escape(words)}" width="{SIZE[0]}" height="{SIZE[1]}" loading="lazy"><span>{html.escape(words)}</span></a>'
        for task, (words, _) in TASKS.items()
    ]
    return '<div class="gallery">\n' + "\n".join(cards) + "\n</div>\n"


if __name__ == "__main__":
    for name in sys.argv[1:] or TASKS:
        make(name)
