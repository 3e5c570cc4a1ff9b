"""Plans and tasks in the browser: what `stiction view` shows."""

from __future__ import annotations

import sys
import tempfile
from html import escape
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from ._core import InvalidInput, Plan, Task
from ._files import require_folder, write_whole

PACKAGE = "stiction_view"


def find_viewer(here: Path) -> Path:
    """The folder of the viewer: of a wheel inside the package, of an installation beside it, of a build in the clone above it."""
    places = [here / "share" / "stiction" / "python", here.parent, *(folder / "python" for folder in here.parents)]
    for place in places:
        if (place / PACKAGE / "__init__.py").is_file():
            return place
    raise ImportError(f"no package {PACKAGE} beside {here}; the wheel and `make install` bring it")


def _viewer(name: str) -> ModuleType:
    if PACKAGE not in sys.modules:
        place = str(find_viewer(Path(__file__).resolve().parent))
        if place not in sys.path:
            sys.path.append(place)
    return import_module(f"{PACKAGE}.{name}")


def _plan_of(shown: Plan | Task) -> Plan:
    if not isinstance(shown, (Plan, Task)):
        raise InvalidInput(f"shown: got {type(shown).__name__}, expected a Plan or a Task")
    return shown.as_plan() if isinstance(shown, Task) else shown


def _dressed(shown: Plan | Task) -> tuple[Any, Any]:
    """What the viewer draws, and how its bodies look."""
    plan = _plan_of(shown)
    return _viewer("dress").of_plan(_load(plan), plan)


def _load(shown: Plan | Task) -> Any:
    """What the viewer draws, read from the text of the plan's file."""
    plan = _plan_of(shown)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "plan.json"
        plan.write(file)
        viewer = _viewer("plan")
        try:
            return viewer.load_plan(file)
        except viewer.InvalidPlan as error:
            raise InvalidInput(f"{str(error).removeprefix(f'{file}: ')}; a Task shows its start") from None


class Page:
    """Self-contained HTML page, which a notebook shows in a frame."""

    def __init__(self, html: str, height: int) -> None:
        self.html, self._height = html, height

    def __repr__(self) -> str:
        return f"<stiction.Page: {len(self.html)} characters>"

    def _repr_html_(self) -> str:
        return f'<iframe srcdoc="{escape(self.html)}" width="100%" height="{self._height}" style="border:0"></iframe>'


def show(shown: Plan | Task, *, height: int = 480) -> Page:
    """Shows a plan, or a task before it is planned, in a notebook. Use it as the last line of a cell.

    shown: Plan or Task.
    height: height of the frame [pixels].

    Returns a Page. Raises InvalidInput: `shown` is neither a Plan nor a Task.

        >>> st.show(st.load_task("planar_pushing"))._repr_html_()[:16]
        '<iframe srcdoc="'
    """
    return Page(_viewer("scene").make_page(*_dressed(shown)), height)


def view(shown: Plan | Task, *, html: str | Path | None = None, port: int = 8080) -> Path | None:
    """Shows a plan, or a task before it is planned, in the browser.

    The page plays and scrubs the motion, and shows contact forces as arrows.

    shown: Plan or Task.
    html: self-contained HTML file to write. None: a server on the loopback address shows the page until Ctrl-C, and prints the address of
      the page with its token.
    port: port of the server.

    Returns the path of the HTML file, or None. Raises InvalidInput: `shown` is neither a Plan nor a Task, or the file cannot be written.

        >>> st.view(st.load_task("planar_pushing"), html="task.html").name
        'task.html'
    """
    if html is not None:
        require_folder(Path(html))
    drawn, looks = _dressed(shown)
    scene = _viewer("scene")
    if html is not None:
        return write_whole(Path(html), lambda file: file.write_text(scene.make_page(drawn, looks), encoding="utf-8"))
    try:
        scene.serve(drawn, port, looks)
    except KeyboardInterrupt:
        pass
    return None
