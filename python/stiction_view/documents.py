"""Which page a file is for."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path


def find(file: Path) -> Callable[[Path], str] | None:
    """What makes the page of a file of `sense`, `control` or `touch`; None: it is a plan, or nothing that can be read."""
    try:
        data = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    name = data.get("format") if isinstance(data, dict) else None
    if name == "stiction-sense":
        from . import sense

        return lambda f: sense.make_page(sense.load_sense(f))
    if name == "stiction-control":
        from . import control

        return lambda f: control.make_page(control.load_control(f))
    if name == "stiction-touch":
        from . import touch

        return lambda f: touch.make_page(touch.load_touch(f))
    return None
