"""The tests' own tools: programs end with all that they have started, and no test waits for ever."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import children
import pytest
from limits import within

HERE = Path(__file__).resolve().parent
SLEEP = "import time; print('ready', flush=True); time.sleep(600)"


def is_running(pid: int) -> bool:
    """Neither gone nor waiting for somebody who asks how it ended."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGHUP, signal.SIGTERM])
def test_child_ends_at_a_signal_that_this_process_ignores(number: signal.Signals) -> None:
    before = signal.signal(number, signal.SIG_IGN)
    try:
        with children.Child([sys.executable, "-c", SLEEP]) as child:
            assert child.line() == "ready\n"
            done = child.stop(number)
        assert signal.getsignal(number) is signal.SIG_IGN, "as it was before"
    finally:
        signal.signal(number, before)
    assert done.returncode == -number, done.stderr


def test_what_a_child_has_started_ends_with_it() -> None:
    code = f"import subprocess, sys; print(subprocess.Popen([sys.executable, '-c', {SLEEP!r}], stdout=subprocess.DEVNULL).pid, flush=True); input()"
    with children.Child([sys.executable, "-c", code], stdin=subprocess.PIPE) as child:
        grandchild = int(child.line())
        assert is_running(grandchild)
    with within(60, "the end of the grandchild"):
        while is_running(grandchild):
            time.sleep(0.01)


def test_child_that_takes_longer_than_its_limit_is_ended() -> None:
    with pytest.raises(subprocess.TimeoutExpired):
        children.run([sys.executable, "-c", SLEEP], limit=0.5)
    with children.Child([sys.executable, "-c", "import time; time.sleep(600)"]) as child:
        with pytest.raises(pytest.fail.Exception, match="a line of .*: not done within 0.2 s"):
            child.line(limit=0.2)
        with pytest.raises(subprocess.TimeoutExpired):
            child.finish(limit=0.2)
        assert child.returncode == -signal.SIGKILL


def test_limits_inside_limits() -> None:
    with pytest.raises(pytest.fail.Exception, match="outside: not done within 0.2 s"), within(0.2, "outside"), within(60, "inside"):
        time.sleep(60)
    with within(60, "outside"):
        with pytest.raises(pytest.fail.Exception, match="inside: not done within 0.2 s"), within(0.2, "inside"):
            time.sleep(60)
        assert 50 < signal.getitimer(signal.ITIMER_REAL)[0] <= 60, "the limit outside goes on"


@pytest.mark.parametrize(
    ("before", "said"),
    [
        ("", "call of test_waiting.py::test_waits: not done within 1 s"),
        ("signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGALRM}); ", "Timeout (0:00:02)!"),  # as code in C++ that does not come back
    ],
)
def test_each_test_has_a_limit(tmp_path: Path, before: str, said: str) -> None:
    (tmp_path / "conftest.py").write_text("import limits\nfrom limits import pytest_runtest_call\nlimits.GRACE = 1\n")
    (tmp_path / "pytest.ini").write_text("[pytest]\nmarkers = limit\naddopts = -p no:cacheprovider\n")
    (tmp_path / "test_waiting.py").write_text(f"import signal, time\nimport pytest\n\n@pytest.mark.limit(1)\ndef test_waits():\n    {before}time.sleep(600)\n")
    done = children.run([sys.executable, "-m", "pytest", "-q"], cwd=tmp_path, limit=60, env={**os.environ, "PYTHONPATH": str(HERE)})
    assert done.returncode == 1 and said in done.stdout + done.stderr, done.stdout + done.stderr
