"""python -m stiction_view.studio [SHOWN] [--host ADDRESS] [--port N]; `stiction studio` starts it."""

from __future__ import annotations

import argparse
import signal
import sys
import tempfile
from pathlib import Path

DONE, BAD_INPUT = 0, 2


def main() -> int:
    parser = argparse.ArgumentParser(prog="stiction studio", description="Opens tasks in the browser.")
    parser.add_argument("shown", nargs="?", help="task or scenario (name or file), or a folder of them")
    parser.add_argument("--host", default="127.0.0.1", help="address that is listened on (default: %(default)s)")
    parser.add_argument("--port", type=int, default=8080, help="its port, 0 for any that is free (default: %(default)s)")
    args = parser.parse_args()
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # the temporary folder goes in any case

    from . import catalog
    from .app import Studio
    from .server import LOOPBACK, PortTaken, serving

    try:
        entries, first = catalog.find(args.shown)
        with serving(args.host, args.port) as server, tempfile.TemporaryDirectory(prefix="stiction-studio-") as folder:
            studio = Studio(server, entries, first, Path(folder))
            shown = "localhost" if args.host == LOOPBACK else args.host
            print(f"http://{shown}:{server.get_port()}   (Ctrl-C ends)", flush=True)
            if args.host != LOOPBACK:
                print("stiction: warning: whoever reaches this address can use the page; it has no password", file=sys.stderr, flush=True)
            studio.run()
    except KeyboardInterrupt:
        return DONE
    except (PortTaken, ValueError) as error:
        print(f"stiction: {error}", file=sys.stderr)
        return BAD_INPUT
    return DONE


if __name__ == "__main__":
    sys.exit(main())
