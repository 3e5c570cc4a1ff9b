"""python -m stiction_view FILE [--html FILE] [--simulation FILE] [--port N] [--temporary]"""

from __future__ import annotations

import argparse
import contextlib
import os
import sys
from pathlib import Path

from . import documents
from .plan import InvalidPlan, load_plan
from .program import BAD_INPUT, DONE, end_on_signals, run_until_interrupted


def main() -> int:
    parser = argparse.ArgumentParser(prog="stiction_view", description="Shows a plan of stiction in the browser.")
    parser.add_argument("plan", type=Path, help="plan file written by `stiction plan`, or what `stiction sense|control|touch --html` hands over")
    parser.add_argument("--html", type=Path, metavar="FILE", help="write one self-contained page instead of starting a server")
    parser.add_argument("--simulation", type=Path, metavar="FILE", help="draw this run of the plan, written by `stiction simulate`, over it")
    parser.add_argument("--port", type=int, default=8080, help="port of the live view on localhost (default: %(default)s)")
    parser.add_argument("--temporary", action="store_true", help="the plan and its folder are removed as soon as they are read")
    args = parser.parse_args()

    if args.simulation is not None and args.html is None:
        parser.error("--simulation needs --html")
    if args.html is None:
        end_on_signals()
        return run_until_interrupted(lambda: serve(args.plan, args.port, args.temporary), InvalidPlan)
    try:
        maker = documents.find(args.plan)
        if maker is not None:
            return write(args.html, maker(args.plan))
        plan = load_plan(args.plan)
        if args.simulation is not None:
            from . import overlay

            simulation = overlay.load_simulation(args.plan, args.simulation)
    except InvalidPlan as error:
        print(f"error: {error}", file=sys.stderr)
        return BAD_INPUT

    from . import dress, scene  # after the cheap checks: importing viser takes a moment

    if args.simulation is not None:
        return write(args.html, overlay.make_page(simulation, dress.of_file(args.plan, plan, bare=False)[1]))
    return write(args.html, scene.make_page(*dress.of_file(args.plan, plan)))


def serve(file: Path, port: int, temporary: bool) -> None:
    """Shows the plan until the program is ended. Raises InvalidPlan."""
    try:
        if documents.find(file) is not None:
            raise InvalidPlan(f"{file}: got a document of `sense`, `control` or `touch`, expected a plan; --html makes its page")
        plan = load_plan(file)
        from . import dress  # importing viser takes a moment

        plan, looks = dress.of_file(file, plan)
    finally:
        if temporary:
            file.unlink(missing_ok=True)
            with contextlib.suppress(OSError):  # others have put something there
                file.parent.rmdir()

    from . import scene

    scene.serve(plan, port, looks)


def write(file: Path, page: str) -> int:
    # Under a temporary name first, so that an interrupted run never leaves half a page.
    place = Path(os.path.realpath(file))  # a link stays
    temporary = place.with_name(f".{place.name}.{os.getpid()}")
    try:
        temporary.write_text(page, encoding="utf-8")
        temporary.replace(place)
    except OSError as error:
        print(f"error: {file}: cannot be written ({error.strerror})", file=sys.stderr)
        return BAD_INPUT
    finally:
        temporary.unlink(missing_ok=True)
    return DONE


if __name__ == "__main__":
    sys.exit(main())
