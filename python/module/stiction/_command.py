"""What the commands that run in Python share with those that do not: messages, the object of --json and exit codes (README.md)."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Sequence
from typing import Any, NoReturn

from ._core import InvalidInput
from ._extras import MissingExtra

DONE, CHECK_FAILED, BAD_INPUT, NOT_SOLVED, INTERNAL_ERROR, INTERRUPTED = 0, 1, 2, 3, 70, 130


class Parser(argparse.ArgumentParser):
    """A faulty command line is an InvalidInput."""

    def error(self, message: str) -> NoReturn:
        raise InvalidInput(f"{message}; `{self.prog} --help` says what there is")


def make_parser(command: str, description: str, epilog: str | None = None) -> Parser:
    parser = Parser(prog=f"stiction {command}", description=description, epilog=epilog, allow_abbrev=False, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true", help="one JSON object on stdout; the text for people goes to stderr")
    return parser


def run(main: Callable[[Sequence[str]], int], words: Sequence[str]) -> int:
    """The exit code of a command, with a message on stderr where it does not end well."""
    try:
        return main(words)
    except InvalidInput as error:
        return fail(words, BAD_INPUT, "InvalidInput", str(error))
    except MissingExtra as error:
        return fail(words, INTERNAL_ERROR, "Error", str(error))
    except KeyboardInterrupt:
        return INTERRUPTED


def fail(words: Sequence[str], code: int, status: str, message: str) -> int:
    print(f"stiction: {message}", file=sys.stderr)
    if "--json" in words:
        print(json.dumps({"status": status, "message": message}, ensure_ascii=False))
    return code


def report(arguments: argparse.Namespace, title: str, rows: dict[str, str], result: dict[str, Any]) -> None:
    """The summary for people, and the object of --json."""
    to = sys.stderr if arguments.json else sys.stdout
    print(title, file=to)
    for name, value in rows.items():
        print(f"  {name:22} {value}", file=to)
    if arguments.json:
        print(json.dumps(result, ensure_ascii=False, allow_nan=False))
