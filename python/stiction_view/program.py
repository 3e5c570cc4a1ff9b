"""What programs share that serve a page until they are ended: their address, and how they end."""

from __future__ import annotations

import argparse
import contextlib
import os
import signal
import sys
import traceback
from collections.abc import Callable
from types import FrameType
from typing import TYPE_CHECKING, NoReturn

from .access import LOOPBACK, is_loopback

if TYPE_CHECKING:  # importing viser takes a moment
    from .quiet import PageServer

DONE, BAD_INPUT, INTERNAL_ERROR = 0, 2, 70


class PortTaken(OSError):
    """The message says which, and what to do."""


def add_address(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--host", default=LOOPBACK, help="address that is listened on (default: %(default)s)")
    parser.add_argument("--port", type=int, default=8080, help="its port, 0 for any that is free (default: %(default)s)")


def announce(server: PageServer) -> None:
    """Says where the page is, and who can see it."""
    first, *others = server.urls()
    print(f"{first}   (Ctrl-C ends)", flush=True)
    for url in others:
        print(url, flush=True)
    if not is_loopback(server.access.host):
        print("stiction: warning: the page goes over the network without encryption; whoever reads the address there can use the page", file=sys.stderr, flush=True)


_interrupted = False


def _end(number: int, frame: FrameType | None) -> None:
    """Ends the program once. While it puts things away, a second Ctrl-C ends it at once; SIGTERM and SIGHUP often come twice."""
    global _interrupted
    _interrupted = True
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    for other in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(other, signal.SIG_IGN)
    raise KeyboardInterrupt


def check_interrupted() -> None:
    """Raises KeyboardInterrupt once a signal came. Loops ask here, since Python drops an exception that comes up in a callback of the garbage collector."""
    if _interrupted:
        raise KeyboardInterrupt


def _say_unraisable(dropped: sys.UnraisableHookArgs) -> None:
    if not (_interrupted and issubclass(dropped.exc_type, KeyboardInterrupt)):
        sys.__unraisablehook__(dropped)


def end_on_signals() -> None:
    """SIGINT, SIGTERM and SIGHUP end the program as Ctrl-C does: the port is free then, and temporary folders are gone.

    A script starts programs in the background with SIGINT ignored, and Python leaves it ignored. There is no other way to send a Ctrl-C to such a
    program, so that it is taken here all the same. Who starts a program with nohup means that it ignores SIGHUP.
    """
    sys.unraisablehook = _say_unraisable
    signal.signal(signal.SIGINT, _end)
    signal.signal(signal.SIGTERM, _end)
    if signal.getsignal(signal.SIGHUP) is not signal.SIG_IGN:
        signal.signal(signal.SIGHUP, _end)


def leave(code: int) -> NoReturn:
    """Ends the process at once, after everything was put away.

    A job in C++ that cannot be cancelled may still run in a thread of its own. The interpreter would stop this thread in the middle of a call and abort.
    """
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError):  # nobody reads it any more
            stream.flush()
    os._exit(code)


def run_until_interrupted(show: Callable[[], None], *mistakes: type[Exception]) -> int:
    """The exit code. mistakes: of the caller, besides a port that is taken."""
    expected: tuple[type[Exception], ...] = (PortTaken, *mistakes)
    try:
        show()
    except KeyboardInterrupt:
        return DONE
    except expected as error:
        print(f"stiction: {error}", file=sys.stderr)
        return BAD_INPUT
    except Exception:
        traceback.print_exc()
        return INTERNAL_ERROR
    return DONE
