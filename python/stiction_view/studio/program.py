"""What programs share that serve a page until they are interrupted: their address, and how they end."""

from __future__ import annotations

import argparse
import signal
import sys
from collections.abc import Callable
from typing import Any

LOOPBACK = "127.0.0.1"
DONE, BAD_INPUT = 0, 2


class PortTaken(OSError):
    """The message says which, and what to do."""


def add_address(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--host", default=LOOPBACK, help="address that is listened on (default: %(default)s)")
    parser.add_argument("--port", type=int, default=8080, help="its port, 0 for any that is free (default: %(default)s)")


def announce(server: Any, host: str) -> None:
    """Says where the page is, and who can see it."""
    shown = "localhost" if host == LOOPBACK else host
    print(f"http://{shown}:{server.get_port()}   (Ctrl-C ends)", flush=True)
    if host != LOOPBACK:
        print("stiction: warning: whoever reaches this address can use the page; it has no password", file=sys.stderr, flush=True)


def end_on_sigterm() -> None:
    """As on Ctrl-C: temporary folders go in any case."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)


def run_until_interrupted(show: Callable[[], None], *mistakes: type[Exception]) -> int:
    """The exit code. mistakes: of the caller, besides a port that is taken."""
    try:
        show()
    except KeyboardInterrupt:
        return DONE
    except (PortTaken, *mistakes) as error:
        print(f"stiction: {error}", file=sys.stderr)
        return BAD_INPUT
    return DONE
