"""What benchmarks that run the program share."""

import dataclasses
import os
import pathlib
import resource
import signal
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


    @property
    def out_of_processor_time(self):
        return self.code == -signal.SIGXCPU


def measure_run(words, processor_seconds=None):
    """A run of a program, whatever comes of it; it is ended once it has used processor_seconds, on whatever cores, which other work beside it does not shorten."""
    limit = processor_seconds and (lambda: resource.setrlimit(resource.RLIMIT_CPU, (processor_seconds, processor_seconds + 5)))
    with tempfile.TemporaryFile("w+") as out:
        start = time.monotonic()
        process = subprocess.Popen([str(word) for word in words], stdout=out, stderr=subprocess.DEVNULL, preexec_fn=limit)
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
