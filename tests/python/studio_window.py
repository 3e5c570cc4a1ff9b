"""`stiction studio` in a headless browser: pressed, filled, dragged and looked at as a person does."""

from __future__ import annotations

import contextlib
import json
import re
import signal
import subprocess
from collections.abc import Callable
from pathlib import Path
from types import TracebackType

import numpy as np

import browser
import children

ADDRESS = re.compile(r"http://localhost:(\d+)/\?token=[0-9a-f]+")
PATIENCE = 300  # [s] until something shows, on a machine that has much else to do
MISSED = 30  # [s] after which a press has missed
PANEL = 400  # [px] width of the controls, at the right
FIND_FIELD = """(label) => {
  const word = [...document.querySelectorAll('label')].find((e) => e.textContent.trim() === label);
  return word ? document.getElementById(word.htmlFor) : null;
}"""


class Program:
    """The program on a free port, as a context."""

    def __init__(self, program: Path, *words: object, root: Path):
        self._words = [str(program), "studio", *map(str, words), "--port", "0"]
        self._root = root

    def __enter__(self) -> Program:
        self.process = children.Child(self._words, cwd=self._root)
        line = self.process.line()
        found = ADDRESS.search(line)
        if found is None:
            raise AssertionError(f"no address: {line!r} {self.process.stop(signal.SIGKILL).stderr}")
        self.address = found.group(0)
        return self

    def end(self) -> str:
        """Ends it as Ctrl-C does; what it said on stderr."""
        return self.process.stop().stderr

    def __exit__(self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None) -> None:
        with contextlib.suppress(subprocess.TimeoutExpired):  # it has been killed then
            self.process.stop()  # its temporary folder goes
        self.process.__exit__(kind, value, trace)


class Window:
    """The page in a browser."""

    def __init__(self, chromium: browser.Browser, downloads: Path, size: tuple[int, int] = (900, 560)):
        self.browser, self.downloads, self.address = chromium, downloads, ""
        chromium.call("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(downloads))
        # Where nobody answers a dialog for files, what is saved goes to the folder of downloads.
        chromium.call("Page.addScriptToEvaluateOnNewDocument", source="delete window.showSaveFilePicker; delete Window.prototype.showSaveFilePicker")
        chromium.call("Emulation.setDeviceMetricsOverride", width=size[0], height=size[1], deviceScaleFactor=1, mobile=False)

    # ---- words ----

    def visit(self, address: str) -> None:
        """Until the controls and the object are there."""
        self.address = address
        self.browser.visit(address)
        self.wait_text(r"Open[\s\S]*Export")
        self.browser.wait_for(lambda: orange(self.scene()) > 0.002, PATIENCE, "the object")

    def text(self) -> str:
        return self.browser.evaluate("document.body ? document.body.innerText : ''") or ""

    def wait_text(self, pattern: str) -> re.Match[str]:
        return self.browser.wait_for(lambda: re.search(pattern, self.text()), PATIENCE, Said(pattern, self))

    # ---- controls ----

    def click(self, find: str, what: str) -> None:
        """The element that a script finds (null: not yet), wherever it has moved to by then."""
        script = f"(() => {{ const e = ({find}); if (!e) return false; e.scrollIntoView({{block: 'nearest'}}); e.click(); return true; }})()"
        self.browser.wait_for(lambda: self.browser.evaluate(script), PATIENCE, what)

    def click_at(self, at: tuple[float, float]) -> None:
        """With the mouse."""
        self.mouse("mouseMoved", at, pressed=False)
        self.mouse("mousePressed", at)
        self.mouse("mouseReleased", at)

    def turn_to(self, label: str) -> None:
        """The tab of that name, which listens to the mouse and may move away beneath it."""
        tab = f"[...document.querySelectorAll('[role=tab]')].find((e) => e.textContent.trim() === {json.dumps(label)})"
        place = f"(() => {{ const e = {tab}; e.scrollIntoView({{block: 'nearest'}}); const r = e.getBoundingClientRect(); return [r.left + r.width / 2, r.top + r.height / 2]; }})()"

        def turned() -> bool:
            if self.browser.evaluate(f"({tab}).getAttribute('aria-selected')") == "true":
                return True
            self.click_at(self.browser.evaluate(place))
            self.frames(2)
            return False

        self.browser.wait_for(turned, PATIENCE, f"the tab {label!r}")

    def press(self, label: str, tag: str = "button, label") -> None:
        """The button or choice of that name, once it is there and may be pressed."""
        found = f"[...document.querySelectorAll({json.dumps(tag)})].filter((e) => e.textContent.trim() === {json.dumps(label)} && !e.disabled && e.offsetParent !== null).pop()"
        self.click(found, f"the button {label!r}")

    def fill(self, label: str, value: object) -> None:
        """A number or a text into its field."""
        script = f"""(() => {{
          const field = ({FIND_FIELD})({json.dumps(label)});
          if (!field) return false;
          const set = Object.getOwnPropertyDescriptor(field.tagName === 'TEXTAREA' ? HTMLTextAreaElement.prototype : HTMLInputElement.prototype, 'value').set;
          field.focus();
          set.call(field, {json.dumps(str(value))});
          field.dispatchEvent(new Event('input', {{bubbles: true}}));
          field.dispatchEvent(new Event('change', {{bubbles: true}}));
          field.blur();
          return true;
        }})()"""
        self.browser.wait_for(lambda: self.browser.evaluate(script), PATIENCE, f"the field {label!r}")

    def value(self, label: str) -> str:
        return self.browser.evaluate(f"(({FIND_FIELD})({json.dumps(label)}) || {{value: ''}}).value") or ""

    def choose(self, label: str, choice: str) -> None:
        """One of a list: opens it, presses the choice."""
        self.click(f"({FIND_FIELD})({json.dumps(label)})", f"the list {label!r}")
        option = f"[...document.querySelectorAll('[role=option]')].filter((e) => e.textContent.trim() === {json.dumps(choice)} && e.offsetParent !== null)[0]"
        self.click(option, f"the choice {choice!r} of {label!r}")

    def targets(self) -> list[tuple[float, float, str]]:
        """Where what can be pressed is, and what is written on it; without the head of the panel, behind which the page keeps the address of its server."""
        return self.browser.evaluate("""[...document.querySelectorAll('button, label, input:not([type=file]), [role=tab], [role=option], canvas, .mantine-Slider-track')]
          .map((e) => [e.getBoundingClientRect(), e]).filter(([r, e]) => r.width > 0 && r.height > 0 && r.top >= (e.tagName === 'CANVAS' ? 0 : 56) && r.bottom <= innerHeight && r.right <= innerWidth)
          .map(([r, e]) => [r.left + r.width / 2, r.top + r.height / 2, e.textContent.slice(0, 40)])""")

    def type(self, text: str) -> None:
        """Into what was clicked last, in place of what is there."""
        self.browser.call("Input.dispatchKeyEvent", type="keyDown", key="a", code="KeyA", modifiers=2, windowsVirtualKeyCode=65, commands=["selectAll"])
        self.browser.call("Input.insertText", text=text)

    # ---- the scene ----

    def mouse(self, kind: str, at: tuple[float, float], pressed: bool = True) -> None:
        self.browser.call("Input.dispatchMouseEvent", type=kind, x=at[0], y=at[1], button="left" if pressed else "none", buttons=int(pressed), clickCount=int(pressed))

    def drag(self, at: tuple[float, float], by: tuple[float, float], steps: int = 8) -> None:
        """Takes what is there along with the mouse [px]."""
        self.mouse("mouseMoved", at, pressed=False)
        self.mouse("mousePressed", at)
        for k in range(1, steps + 1):
            self.frames(2)
            self.mouse("mouseMoved", (at[0] + by[0] * k / steps, at[1] + by[1] * k / steps))
        self.frames(2)
        self.mouse("mouseReleased", (at[0] + by[0], at[1] + by[1]))

    def still(self, find: Callable[[np.ndarray], tuple[float, float] | None], what: str) -> tuple[float, float]:
        """Where `find` sees something in the scene, once that stays while the page is drawn anew: a camera that is aimed late moves it."""

        def same() -> tuple[float, float] | None:
            before = find(self.scene())
            self.frames(5)
            return before if before == find(self.scene()) else None

        return self.browser.wait_for(same, PATIENCE, what)

    def pull(self, find: Callable[[np.ndarray], tuple[float, float] | None], by: tuple[float, float], moved: Callable[[], bool], what: str) -> None:
        """Drags what `find` sees until something has moved. A press that misses turns the view, which is turned back."""

        def pulled() -> bool:
            at = self.still(find, what)
            self.drag(at, by)
            try:
                return self.browser.wait_for(moved, MISSED, what)
            except AssertionError:
                self.drag((at[0] + by[0], at[1] + by[1]), (-by[0], -by[1]))
                return moved()

        self.browser.wait_for(pulled, PATIENCE, what)

    def frames(self, count: int) -> None:
        """Until the page was drawn that often."""
        script = f"new Promise((done) => {{ let n = {count}; const next = () => n-- > 0 ? requestAnimationFrame(next) : done(true); next(); }})"
        self.browser.call("Runtime.evaluate", expression=script, awaitPromise=True)

    def picture(self) -> np.ndarray:
        return self.browser.screenshot()

    def scene(self) -> np.ndarray:
        """The part of the picture beside the panel."""
        picture = self.picture()
        return picture[:, : picture.shape[1] - PANEL]


class Said:
    """What a page lacks and what it says instead, looked up when it is asked for."""

    def __init__(self, pattern: str, window: Window):
        self.pattern, self.window = pattern, window

    def __str__(self) -> str:
        return f"{self.pattern!r}; the page says {self.window.text()!r}"


def orange(picture: np.ndarray) -> float:
    """Part of the pixels in the colours of an object."""
    r, g, b = np.moveaxis(picture.astype(int), 2, 0)
    return float(((r > 120) & (g > 0.3 * r) & (g < 0.85 * r) & (b < 0.6 * g)).mean())


def red(picture: np.ndarray) -> float:
    """Part of the pixels in the colour of a fault, through which the background shows."""
    r, g, b = np.moveaxis(picture.astype(int), 2, 0)
    return float(((r > 180) & (g < 0.8 * r) & (np.abs(g - b) < 30)).mean())


def drawn(picture: np.ndarray) -> float:
    """Part of the pixels that are not background."""
    return float((np.abs(picture.astype(int) - 255).max(axis=2) > 20).mean())


def colours(picture: np.ndarray) -> int:
    """How many different ones, to an eighth of their range."""
    return len(np.unique(picture.reshape(-1, 3) // 32, axis=0))


def square(picture: np.ndarray, colour: tuple[int, int, int], size: int = 15) -> tuple[float, float] | None:
    """Middle (x, y) of the pixels around which a square of that side has one colour, to 60 of 255; None: there is none."""
    like = (np.abs(picture.astype(int) - colour).max(axis=2) <= 60).astype(int)
    sums = np.pad(like.cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0)))
    full = sums[size:, size:] - sums[:-size, size:] - sums[size:, :-size] + sums[:-size, :-size] == size * size
    if not full.any():
        return None
    y, x = np.nonzero(full)
    return float(x.mean() + size // 2), float(y.mean() + size // 2)
