"""python -m stiction_view FILE [--html FILE] [--simulation FILE] [--port N]"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

from . import documents
from .plan import InvalidPlan, load_plan


def main() -> int:
    parser = argparse.ArgumentParser(prog="stiction_view", description="Shows a plan of stiction in the browser.")
    parser.add_argument("plan", type=Path, help="plan file written by `stiction plan`, or what `stiction sense|control|touch --html` hands over")
    parser.add_argument("--html", type=Path, metavar="FILE", help="write one self-contained page instead of starting a server")
    parser.add_argument("--simulation", type=Path, metavar="FILE", help="draw this run of the plan, written by `stiction simulate`, over it")
    parser.add_argument("--port", type=int, default=8080, help="port of the live view on localhost (default: %(default)s)")
    args = parser.parse_args()

    if args.simulation is not None and args.html is None:
        parser.error("--simulation needs --html")
    try:
        maker = documents.find(args.plan)
        if maker is not None:
            if args.html is None:
                parser.error(f"{args.plan} needs --html")
            return write(args.html, maker(args.plan))
        plan = load_plan(args.plan)
        if args.simulation is not None:
            from . import overlay

            simulation = overlay.load_simulation(args.plan, args.simulation)
    except InvalidPlan as error:
        print(f"error: {error}", file=sys.stderr)
        return 2

    from . import scene  # after the cheap checks: importing viser takes a moment

    if args.html is None:
        try:
            scene.serve(plan, args.port)
        except KeyboardInterrupt:
            pass
        return 0

    return write(args.html, scene.make_page(plan) if args.simulation is None else overlay.make_page(simulation))


def write(file: Path, page: str) -> int:
    # Under a temporary name first, so that an interrupted run never leaves half a page.
    temporary = file.with_name(f".{file.name}.{os.getpid()}")
    try:
        temporary.write_text(page, encoding="utf-8")
        temporary.replace(file)
    except OSError as error:
        print(f"error: {file}: cannot be written ({error.strerror})", file=sys.stderr)
        return 2
    finally:
        temporary.unlink(missing_ok=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
