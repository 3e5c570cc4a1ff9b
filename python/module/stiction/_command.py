"""What the commands that run in Python share with those that do not: messages, the object of --json and exit codes (README.md)."""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import math
import os
import re
import signal
import sys
import traceback
from collections.abc import Callable, Sequence
from typing import Any, NoReturn

from ._core import InvalidInput
from ._extras import MissingExtra

DONE, CHECK_FAILED, BAD_INPUT, NOT_SOLVED, INTERNAL_ERROR, INTERRUPTED = 0, 1, 2, 3, 70, 130


class Parser(argparse.ArgumentParser):
    """A faulty command line is an InvalidInput."""

    def error(self, message: str) -> NoReturn:
        raise InvalidInput(f"{message.removeprefix('argument ')}; `{self.prog} --help` says what there is")


NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
LONGEST_INTEGER = 20  # digits


def quote(text: str) -> str:
    """What was given, short enough to be read."""
    return repr(text) if len(text) <= 40 else f"{text[:20] + '…'!r} ({len(text)} characters)"


def read_number(text: str, *, positive: bool) -> float:
    """A finite number, as the commands that do not run in Python read it. Raises ArgumentTypeError: it is none, or not > 0 (positive) or >= 0."""
    value = float(text) if NUMBER.fullmatch(text) else math.nan
    if not math.isfinite(value) or value < 0 or (positive and value == 0):
        raise argparse.ArgumentTypeError(f"got {quote(text)}, expected a number {'>' if positive else '≥'} 0")
    return value


def positive(text: str) -> float:
    return read_number(text, positive=True)


def nonnegative(text: str) -> float:
    return read_number(text, positive=False)


def integer(low: int, high: int) -> Callable[[str], int]:
    """A reader of integers from low to high, both included."""

    def read(text: str) -> int:
        value = int(text) if re.fullmatch(rf"[+-]?\d{{1,{LONGEST_INTEGER}}}", text, re.ASCII) else None
        if value is None or not low <= value <= high:
            raise argparse.ArgumentTypeError(f"got {quote(text)}, expected an integer from {low} to {high}")
        return value

    return read


def make_parser(command: str, description: str, epilog: str | None = None) -> Parser:
    parser = Parser(prog=f"stiction {command}", description=description, epilog=epilog, allow_abbrev=False, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true", help="one JSON object on stdout; the text for people goes to stderr")
    return parser


def run(main: Callable[[Sequence[str]], int], words: Sequence[str]) -> int:
    """The exit code of a command, with a message on stderr where it does not end well."""
    _take_signals()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # letters that the terminal lacks are replaced, and nothing fails
            stream.reconfigure(errors="backslashreplace")
    code = _run(main, words)
    if _fault_of_stdout is None:
        write_text("", sys.stdout)  # what is still in its buffer
    if _fault_of_stdout is None:
        return code
    say(f"stiction: stdout: cannot be written ({_fault_of_stdout}); files of the command are whole", sys.stderr)
    return INTERNAL_ERROR if code == DONE else code


def _run(main: Callable[[Sequence[str]], int], words: Sequence[str]) -> int:
    try:
        return main(words)
    except SystemExit as done:  # of --help
        return DONE if done.code is None else int(done.code)
    except InvalidInput as error:
        return fail(words, BAD_INPUT, "InvalidInput", str(error))
    except MissingExtra as error:
        return fail(words, INTERNAL_ERROR, "Error", str(error))
    except KeyboardInterrupt:
        return fail(words, INTERRUPTED, "Cancelled", "interrupted")
    except OSError as error:
        if error.filename is None:
            return fail_by(error, words)
        return fail(words, BAD_INPUT, "InvalidInput", f"{os.fsdecode(error.filename)}: got a path that cannot be used ({error.strerror}), expected a file or folder that can be")
    except ImportError as error:  # of a package that is missing, or too new for this interpreter
        return fail(words, INTERNAL_ERROR, "Error", f"the Python of {sys.executable} cannot run it: {error}; STICTION_PYTHON names another interpreter")
    except Exception as error:  # a fault of the program
        return fail_by(error, words)


def fail_by(error: Exception, words: Sequence[str]) -> int:
    place = traceback.extract_tb(error.__traceback__)[-1]
    return fail(words, INTERNAL_ERROR, "Error", f"{type(error).__name__}: {error} ({os.path.basename(place.filename)}:{place.lineno})")


def _take_signals() -> None:
    """SIGTERM and SIGHUP end a command as Ctrl-C does, also one that was started in the background; nohup keeps SIGHUP away."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    for number in (signal.SIGTERM, signal.SIGHUP):
        if number == signal.SIGTERM or signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, lambda *_: signal.raise_signal(signal.SIGINT))


_fault_of_stdout: str | None = None


def say(text: str, to: Any) -> None:
    """A line. Work goes on where it cannot be written, as to `| head -1`: run() says so at the end."""
    write_text(text + "\n", to)


def write_text(text: str, to: Any) -> None:
    """A part of a line, or of the one that progress rewrites."""
    global _fault_of_stdout
    if to is None:  # the caller has closed it
        return
    try:
        to.write(text)
        to.flush()
    except OSError as error:
        if to is sys.stdout:
            _fault_of_stdout = _fault_of_stdout or str(error.strerror)
        with contextlib.suppress(OSError):  # what the buffer holds would fail again when Python ends
            os.dup2(os.open(os.devnull, os.O_WRONLY), to.fileno())


def fail(words: Sequence[str], code: int, status: str, message: str) -> int:
    say(f"stiction: {message}", sys.stderr)
    if "--json" in words:
        say(json.dumps({"status": status, "message": message}), sys.stdout)
    return code


def report(arguments: argparse.Namespace, title: str, rows: dict[str, str], result: dict[str, Any]) -> None:
    """The summary for people, and the object of --json."""
    to = sys.stderr if arguments.json else sys.stdout
    say(title, to)
    for name, value in rows.items():
        say(f"  {name:22} {value}", to)
    if arguments.json:
        say(json.dumps(result, allow_nan=False), sys.stdout)
