#!/usr/bin/env python3
"""scripts/pictures.py [moving] [plan] [touch] [studio]: makes the pictures in docs/images again, from the project's own pages in headless Chromium."""

from __future__ import annotations

import dataclasses
import functools
import io
import shutil
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
import studio_window  # noqa: E402
from stiction_view import drawing, overlay, scene  # noqa: E402
from stiction_view.bodies import body_meshes  # noqa: E402
from stiction_view.camera import View, choose_view  # noqa: E402
from stiction_view.drawing import Drawing, light  # noqa: E402
from stiction_view.links import find  # noqa: E402
from stiction_view.plan import Plan, load_plan  # noqa: E402

TASKS = {"allegro_cube": "0", "iiwa_bimanual": "0"}  # and their seeds
PROGRAM = ROOT / "build/release/stiction"
IMAGES = ROOT / "docs/images"
COLUMNS = ("plan", "run in MuJoCo, in closed loop")
WIDTH, HEIGHT, BAR = 420, 300, 36  # of one picture, and of the time bar below it [px]
PATIENCE = 300  # [s], on a machine that has much else to do
PLAN_BAR = ".mantine-Slider-track"
FRAMES, PER_SECOND = 40, 8
NEARER = 0.8  # the camera, since there is no panel to leave room for
HIDDEN = "<style>#stiction, [class*=Notification] {display: none !important}</style>"
# Without the notice that this machine has no graphics card.
QUIET = "document.head.insertAdjacentHTML('beforeend', '<style>[class*=Notification] {display: none !important}</style>')"
drawing.ROBOT, drawing.ROBOT_OPACITY = (148, 156, 170), None  # in a small picture fingers have to stand out


def simulate(task: str, seed: str, folder: Path) -> tuple[Plan, Plan, np.ndarray]:
    """The plan, the run as a plan whose motion is the simulated one, and the moments of the run."""
    subprocess.run([PROGRAM, "run", task, "--seed", seed, "-o", folder], check=True)
    run = overlay.load_simulation(folder / "plan.json", folder / "run.json")
    return load_plan(folder / "plan.json"), run.plan, run.times


def view_of(plan: Plan) -> View:
    view = choose_view(plan, body_meshes(plan, find(plan)[0]), np.arange(len(plan.poses)))
    view = dataclasses.replace(view, position=view.look_at + NEARER * (view.position - view.look_at), label=view.look_at - 100 * view.radius * view.up)
    return view.aside(-0.2)  # pages look a little aside


def page(plan: Plan, knots: np.ndarray, view: View) -> str:
    """Of these knots, each as long as the others, without the search tree."""

    def draw(server: object) -> Drawing:
        motion = Drawing(server, dataclasses.replace(plan, tree_parents=np.empty(0, dtype=int), loads=None), view=view)
        motion.frames = knots
        motion.times = np.arange(len(knots) + 1) / PER_SECOND
        return motion

    scene.light = functools.partial(light, shadows=False)  # a processor would draw them for minutes
    return scene.record(draw).replace("</head>", HIDDEN + "</head>", 1)


def drawn(window: browser.Browser) -> np.ndarray:
    """The picture, after the page was drawn twice."""
    window.call("Runtime.evaluate", expression="new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(true))))", awaitPromise=True)
    return window.screenshot()


def pictures(window: browser.Browser, file: Path) -> list[np.ndarray]:
    window.open(file)
    window.wait_for(lambda: window.evaluate("!!document.querySelector('.mantine-Slider-track')"), PATIENCE, "the time bar")
    out = []
    for k in range(FRAMES):
        moment = k / PER_SECOND

        def there(moment: float = moment, share: float = (k + 0.5) / FRAMES) -> np.ndarray | None:
            window.scrub(share)
            picture = drawn(window)
            close = abs(float(window.evaluate("document.querySelector('input').value")) - moment) < 1.5 / PER_SECOND
            return picture if close else None

        out.append(window.wait_for(there, PATIENCE, f"the moment {moment}")[:HEIGHT])
    assert not window.errors, window.errors
    return out


def clips(task: str, seed: str, folder: Path) -> list[list[np.ndarray]]:
    """Pictures of the plan of a task, and of its run."""
    plan, run, times = simulate(task, seed, folder / task)
    view = view_of(plan)
    knots = (
        np.linspace(0, len(plan.poses) - 1, FRAMES).round().astype(int),
        np.searchsorted(times, np.linspace(times[0], times[-1], FRAMES)).clip(0, len(times) - 1),
    )
    row = []
    for number, motion in enumerate((plan, run)):
        file = folder / f"{task}{number}.html"
        file.write_text(page(motion, knots[number], view), encoding="utf-8")
        with browser.Browser() as window:
            window.call("Emulation.setDeviceMetricsOverride", width=WIDTH, height=HEIGHT + BAR, deviceScaleFactor=1, mobile=False)
            row.append(pictures(window, file))
    return row


def moving(folder: Path) -> None:
    """Plans and runs of two tasks, side by side."""
    write_moving([clips(task, seed, folder) for task, seed in TASKS.items()])


def write_moving(rows: list[list[list[np.ndarray]]]) -> None:
    font = ImageFont.load_default(size=15)
    frames = []
    for k in range(FRAMES):
        image = Image.fromarray(np.vstack([np.hstack([column[k] for column in row]) for row in rows]))
        draw = ImageDraw.Draw(image)
        for number, text in enumerate(COLUMNS):
            draw.text((number * WIDTH + 10, 8), text, fill=(60, 64, 72), font=font)
        frames.append(image)
    shown = [1000 // PER_SECOND] * (FRAMES - 1) + [1500]  # [ms]
    data = io.BytesIO()
    frames[0].save(data, "WEBP", save_all=True, append_images=frames[1:], duration=shown, loop=0, quality=72, method=6)
    (IMAGES / "plan_and_run.webp").write_bytes(data.getvalue())


def save(picture: np.ndarray, name: str) -> None:
    """With few colours: text stays sharp and the file small."""
    Image.fromarray(picture).quantize(96, dither=Image.Dither.NONE).save(IMAGES / name, optimize=True)


def still(file: Path, name: str, moment: float, ready: str) -> None:
    """What a page shows at a moment of its motion."""
    with browser.Browser() as window:
        window.open(file)
        window.wait_for(lambda: window.evaluate(f"!!document.querySelector({ready!r})"), PATIENCE, "the time bar")
        window.evaluate(QUIET)
        time.sleep(3)
        if ready == PLAN_BAR:
            window.scrub(moment)
        else:
            window.evaluate(f"(() => {{ const s = document.querySelector({ready!r}); s.value = Math.round({moment} * s.max); s.dispatchEvent(new Event('input')); }})()")
        time.sleep(2)
        save(drawn(window), name)


def run_tutorial(folder: Path, *words: str) -> None:
    shutil.copytree(ROOT / "docs/tutorials", folder, dirs_exist_ok=True)
    subprocess.run([PROGRAM, *words], cwd=folder, check=True)


def plan(folder: Path) -> None:
    run_tutorial(folder, "plan", "push.yaml", "--seed", "0", "-o", "out", "--html")
    still(next((folder / "out").glob("*.html")), "tutorial_push.png", 0.6, PLAN_BAR)


def touch(folder: Path) -> None:
    run_tutorial(folder, "sense", "touch.yaml", "--html", "touch.html")
    still(folder / "touch.html", "tutorial_touch.png", 0.6, "#slider")


def studio(folder: Path) -> None:
    with studio_window.Program(PROGRAM, "allegro_cube", root=ROOT) as program, browser.Browser() as chromium:
        window = studio_window.Window(chromium, folder, (1100, 680))
        window.visit(program.address)
        window.press("Plan", "button")
        window.wait_text(r"solved in [\d.]+ s")
        chromium.evaluate(QUIET)
        time.sleep(10)  # until the result is drawn
        window.press("Play")
        time.sleep(3)
        chromium.scrub(0.5)
        time.sleep(5)
        save(drawn(chromium), "tutorial_studio.png")


MAKERS = {"moving": moving, "plan": plan, "touch": touch, "studio": studio}


def main(names: list[str]) -> None:
    IMAGES.mkdir(exist_ok=True)
    for name in names or MAKERS:
        with tempfile.TemporaryDirectory() as folder:
            MAKERS[name](Path(folder))


if __name__ == "__main__":
    main(sys.argv[1:])
