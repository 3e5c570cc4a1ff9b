"""What benchmarks that run the program share."""

import dataclasses
import os
import pathlib
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[1]


@dataclasses.dataclass
class Run:
    code: int
    text: str  # on stdout
    peak_mb: float  # resident memory
    processor_s: float
    wall_s: float


def measure_run(words):
    """A run of a program, whatever comes of it."""
    with tempfile.TemporaryFile("w+") as out:
        start = time.monotonic()
        process = subprocess.Popen([str(word) for word in words], stdout=out, stderr=subprocess.DEVNULL)
        _, status, usage = os.wait4(process.pid, 0)
        wall = time.monotonic() - start
        process.returncode = os.waitstatus_to_exitcode(status)
        out.seek(0)
        return Run(process.returncode, out.read(), usage.ru_maxrss / 1024, usage.ru_utime + usage.ru_stime, wall)


def exit_with(name, main):
    """Exit code 2 and the reason where a program failed."""
    try:
        sys.exit(main())
    except RuntimeError as error:
        print(f"{name}: {error}", file=sys.stderr)
        sys.exit(2)
