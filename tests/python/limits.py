"""Limits on time, so that no test waits for ever: of each test by itself, and of single waits inside one.

A conftest.py imports the hooks. `@pytest.mark.limit(900)` gives a test that takes longer another limit [s].
"""

from __future__ import annotations

import faulthandler
import functools
import os
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

LIMIT = 600.0  # [s] of the fixtures of a test, of the test, and of what is put away after it
GRACE = 60.0  # [s] after which a test that does not answer to its limit is ended with its process


@contextmanager
def within(seconds: float, what: str) -> Iterator[None]:
    """Fails if the block takes longer. Blocks can be nested: the one whose time is up first fails. For the main thread only."""

    def fail(*_: object) -> None:
        pytest.fail(f"{what}: not done within {seconds:g} s")

    before = signal.signal(signal.SIGALRM, fail)
    left, _ = signal.setitimer(signal.ITIMER_REAL, seconds)
    if 0 < left < seconds:  # the block outside ends first
        signal.signal(signal.SIGALRM, before)
        signal.setitimer(signal.ITIMER_REAL, left)
    begin = time.monotonic()
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
        if left > 0:
            signal.setitimer(signal.ITIMER_REAL, max(left - (time.monotonic() - begin), 1e-3))


@functools.cache
def _stderr(config: pytest.Config) -> int:
    """The stderr of the process, which pytest replaces by a file while a test runs."""
    with config.pluginmanager.getplugin("capturemanager").global_and_fixture_disabled():
        return os.dup(2)


@contextmanager
def _limited(item: pytest.Item, what: str) -> Iterator[None]:
    mark = item.get_closest_marker("limit")
    seconds = float(mark.args[0]) if mark else LIMIT
    # Code in C++ that does not come back never sees the signal: a thread of faulthandler then says where it is and ends the process.
    faulthandler.dump_traceback_later(seconds + GRACE, exit=True, file=_stderr(item.config))
    try:
        with within(seconds, f"{what} of {item.nodeid}"):
            yield
    finally:
        faulthandler.cancel_dump_traceback_later()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_setup(item: pytest.Item) -> Iterator[None]:
    with _limited(item, "setup"):
        return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Iterator[None]:
    with _limited(item, "call"):
        return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_teardown(item: pytest.Item) -> Iterator[None]:
    with _limited(item, "teardown"):
        return (yield)
