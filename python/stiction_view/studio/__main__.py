"""python -m stiction_view.studio [SHOWN] [--host ADDRESS] [--port N]; `stiction studio` starts it."""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from ..program import add_address, announce, end_on_signals, leave, run_until_interrupted


def main() -> int:
    parser = argparse.ArgumentParser(prog="stiction studio", description="Opens tasks in the browser.")
    parser.add_argument("shown", nargs="?", help="task or scenario (name or file), a whole scene (MJCF, URDF or SDF), or a folder of tasks")
    add_address(parser)
    args = parser.parse_args()
    end_on_signals()

    from . import catalog
    from .app import Studio
    from .server import serving

    def show() -> None:
        entries, first = catalog.find(args.shown)
        with serving(args.host, args.port) as server, tempfile.TemporaryDirectory(prefix="stiction-studio-") as folder:
            announce(server)  # a browser loads the page while the scene is made
            Studio(server, entries, first, Path(folder)).run()

    return run_until_interrupted(show, ValueError)


if __name__ == "__main__":
    leave(main())
