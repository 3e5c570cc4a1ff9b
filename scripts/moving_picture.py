"""scripts/moving_picture.py PICTURE.webp: plans and runs of two tasks, side by side, drawn by the pages of plans in headless Chromium (README.md)."""

from __future__ import annotations

import dataclasses
import io
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "tests/python"), str(ROOT / "python")]
import browser  # noqa: E402
from stiction_view import overlay, scene  # noqa: E402
from stiction_view.bodies import body_meshes  # noqa: E402
from stiction_view.camera import View, choose_view  # noqa: E402
from stiction_view.drawing import Drawing  # noqa: E402
from stiction_view.links import find  # noqa: E402
from stiction_view.plan import Plan, load_plan  # noqa: E402

TASKS = {"allegro_cube": "0", "iiwa_bimanual": "0"}  # and their seeds
COLUMNS = ("plan", "run in MuJoCo, in closed loop")
WIDTH, HEIGHT = 420, 300  # of one picture
FRAMES, PER_SECOND = 60, 10
NEARER = 0.78  # the camera, since there is no panel to leave room for
HIDDEN = "<style>#stiction, [class*=Notification], a[href*=viser] {display: none !important} body > div > div > div:not(:has(canvas)) {opacity: 0 !important}</style>"


def simulate(task: str, seed: str, folder: Path) -> tuple[Plan, Plan, np.ndarray]:
    """The plan, the run as a plan whose motion is the simulated one, and the moments of the run."""
    subprocess.run([ROOT / "build/release/stiction", "run", task, "--seed", seed, "-o", folder], check=True)
    run = overlay.load_simulation(folder / "plan.json", folder / "run.json")
    return load_plan(folder / "plan.json"), run.plan, run.times


def view_of(plan: Plan) -> View:
    view = choose_view(plan, body_meshes(plan, find(plan)[0]), np.arange(len(plan.poses))).aside(-0.2)  # pages look a little aside
    return dataclasses.replace(view, position=view.look_at + NEARER * (view.position - view.look_at), label=view.look_at - 100 * view.radius * view.up)


def page(plan: Plan, knots: np.ndarray, view: View) -> str:
    """Of these knots, each as long as the others, without the search tree."""

    def draw(server: object) -> Drawing:
        drawing = Drawing(server, dataclasses.replace(plan, tree_parents=np.empty(0, dtype=int), loads=None), view=view)
        drawing.frames = knots
        drawing.times = np.arange(len(knots) + 1) / PER_SECOND
        return drawing

    return scene.record(draw).replace("</head>", HIDDEN + "</head>", 1)


def settled(window: browser.Browser) -> np.ndarray:
    """The picture, once two in a row are the same."""
    before = window.screenshot()
    for _ in range(20):
        time.sleep(0.05)
        now = window.screenshot()
        if (now == before).all():
            break
        before = now
    return before


def pictures(window: browser.Browser, file: Path) -> list[np.ndarray]:
    window.open(file)
    window.wait_for(lambda: window.evaluate("!!document.querySelector('.mantine-Slider-track')"), 60, "the time bar")
    window.scrub(0.5)
    time.sleep(3)  # the first picture
    out = []
    for k in range(FRAMES):
        window.scrub((k + 0.5) / FRAMES)
        out.append(settled(window))
    assert not window.errors, window.errors
    return out


def main(target: Path) -> None:
    font = ImageFont.load_default(size=15)
    rows = []
    with tempfile.TemporaryDirectory() as name, browser.Browser() as window:
        window.call("Emulation.setDeviceMetricsOverride", width=WIDTH, height=HEIGHT, deviceScaleFactor=1, mobile=False)
        for task, seed in TASKS.items():
            folder = Path(name) / task
            plan, run, times = simulate(task, seed, folder)
            view = view_of(plan)
            knots = (
                np.linspace(0, len(plan.poses) - 1, FRAMES).round().astype(int),
                np.searchsorted(times, np.linspace(times[0], times[-1], FRAMES)).clip(0, len(times) - 1),
            )
            row = []
            for number, motion in enumerate((plan, run)):
                file = folder / f"{number}.html"
                file.write_text(page(motion, knots[number], view), encoding="utf-8")
                row.append(pictures(window, file))
            rows.append(row)
    frames = []
    for k in range(FRAMES):
        image = Image.fromarray(np.vstack([np.hstack([column[k] for column in row]) for row in rows]))
        draw = ImageDraw.Draw(image)
        for number, text in enumerate(COLUMNS):
            draw.text((number * WIDTH + 10, 8), text, fill=(60, 64, 72), font=font)
        frames.append(image)
    hold = [1000 // PER_SECOND] * (FRAMES - 1) + [1500]
    data = io.BytesIO()
    frames[0].save(data, "WEBP", save_all=True, append_images=frames[1:], duration=hold, loop=0, quality=72, method=6)
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_bytes(data.getvalue())
    print(f"{target}: {len(data.getvalue()) / 1e6:.2f} MB")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
