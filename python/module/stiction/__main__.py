"""python -m stiction COMMAND …: the commands of the program `stiction` that run in Python."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib import import_module

from . import _command

MODULES = {
    "benchmark": "_benchmark_command",
    "export": "exports",
    "grasps": "grasps",
    "repair": "demonstrations",
    "report": "reports",
    "sdf": "sdf",
    "stream": "_stream_command",
    "sweep": "_sweep_command",
}


def main(words: list[str]) -> int:
    if not words or words[0] not in MODULES:
        return _command.fail(words, _command.BAD_INPUT, "InvalidInput", f"command: got '{' '.join(words[:1])}', expected one of {', '.join(MODULES)}")

    def carry_out(rest: Sequence[str]) -> int:
        return import_module(f".{MODULES[words[0]]}", __package__).main(rest)

    return _command.run(carry_out, words[1:])


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
