"""Jobs on many processes, or on the workers of a Ray cluster: one that dies is tried again, and no other one notices."""

from __future__ import annotations

import contextlib
import math
import multiprocessing
import multiprocessing.connection
import os
import re
import signal
import socket
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from types import ModuleType
from typing import Any, Protocol

from ._core import InvalidInput, version
from ._extras import require

ATTEMPTS = 2
MOST_ATTEMPTS = 6  # of a job whose machines go away
ANSWER_S = 5.0  # in which a cluster answers
LOOK_S = 0.2  # between looks for Ctrl-C
CLUSTER_LOOK_S = 2.0  # ... for the cluster
SILENCE_S = 10.0  # after which a cluster that does not answer is gone; Ray itself ends this process after a minute
PROBE_S = 120.0  # in which a machine of a cluster loads the package


@dataclass(frozen=True)
class Died:
    """The process of a job ended without a result."""

    message: str


@dataclass(frozen=True)
class Lost(Died):
    """The machine of a job is gone: another one tries it, and its attempts do not count."""


class Vanished(RuntimeError):
    """A cluster does not answer any more; jobs that were not done are not lost, but not done."""


@dataclass(frozen=True)
class Failed:
    """The job raised an exception."""

    message: str


@dataclass(frozen=True)
class Stopped:
    """The job used up its time, and its process was ended."""

    message: str


class Backend(Protocol):
    capacity: int  # jobs at a time

    def start(self, function: Callable[[Any], Any], job: Any) -> Any: ...
    def wait(self, handles: list[Any]) -> list[tuple[Any, Any]]: ...  # what has ended, after LOOK_S at the latest
    def close(self, handles: Iterable[Any]) -> None: ...


def carry_out(function: Callable[[Any], Any], job: Any) -> Any:
    try:
        return function(job)
    except Exception as error:  # of whatever kind: it is recorded, and the other jobs go on
        return Failed(f"{type(error).__name__}: {' '.join(str(error).split())}")


@contextlib.contextmanager
def _interrupt_noted() -> Iterator[threading.Event]:
    """Ctrl-C is noted and taken between jobs: while one starts, Python may lose it, or its process."""
    noted = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield noted
        return
    before = signal.signal(signal.SIGINT, lambda *_: noted.set())
    try:
        yield noted
    finally:
        signal.signal(signal.SIGINT, before)


def run_all(backend: Backend, function: Callable[[Any], Any], jobs: Iterable[Any]) -> Iterator[tuple[Any, int, Any]]:
    """(job, attempts, result) as jobs end; a result may be Failed, Stopped, or Died where it died at every attempt."""
    waiting = deque((job, 1, ATTEMPTS) for job in jobs)
    running: dict[Any, tuple[Any, int, int]] = {}
    with _interrupt_noted() as interrupted:
        try:
            while waiting or running:
                if interrupted.is_set():
                    raise KeyboardInterrupt
                while waiting and len(running) < backend.capacity:
                    job, attempt, allowed = waiting.popleft()
                    running[backend.start(function, job)] = (job, attempt, allowed)
                for handle, result in backend.wait(list(running)):
                    job, attempt, allowed = running.pop(handle)
                    allowed = min(allowed + isinstance(result, Lost), MOST_ATTEMPTS)
                    if isinstance(result, Died) and attempt < allowed:
                        waiting.appendleft((job, attempt + 1, allowed))
                    else:
                        yield job, attempt, result
        finally:
            backend.close(running)


@contextlib.contextmanager
def _without_main(function: Callable[[Any], Any]) -> Iterator[None]:
    """A new process does not run the caller's script again, unless what it is to do stands there."""
    main = sys.modules["__main__"]
    if getattr(function, "__module__", None) != "__main__":
        sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main


def _work(connection: Any, function: Callable[[Any], Any], job: Any) -> None:
    for number in (signal.SIGINT, signal.SIGHUP):  # a terminal sends them to all processes; the parent decides
        signal.signal(number, signal.SIG_IGN)
    connection.send(carry_out(function, job))


class Local:
    """A process for every job, forked from one that has loaded the package and does nothing else."""

    def __init__(self, processes: int | None = None, limit_s: float | None = None) -> None:
        """limit_s: wall time of a job, after which its process is ended; None: as long as it takes."""
        self.capacity = len(os.sched_getaffinity(0)) if processes is None else processes
        self._limit_s = limit_s
        if self.capacity < 1:
            raise InvalidInput(f"processes: got {processes}, expected at least 1")
        self._context = multiprocessing.get_context("forkserver")
        self._context.set_forkserver_preload(["stiction.sweeps"])

    def start(self, function: Callable[[Any], Any], job: Any) -> Any:
        ours, theirs = self._context.Pipe(duplex=False)
        process = self._context.Process(target=_work, args=(theirs, function, job), daemon=True)
        with _without_main(function):
            process.start()
        theirs.close()
        return process, ours, None if self._limit_s is None else time.monotonic() + self._limit_s

    def wait(self, handles: list[Any]) -> list[tuple[Any, Any]]:
        by_connection = {handle[1]: handle for handle in handles}
        out = []
        for ready in multiprocessing.connection.wait(list(by_connection), timeout=LOOK_S):
            process, connection, _ = handle = by_connection.pop(ready)
            try:
                result = connection.recv()
            except (EOFError, OSError):
                result = None
            process.join()
            connection.close()
            out.append((handle, Died(f"its process ended with exit code {process.exitcode}") if result is None else result))
        late = [handle for handle in by_connection.values() if handle[2] is not None and time.monotonic() > handle[2]]
        self.close(late)
        return out + [(handle, Stopped(f"its process was ended after {self._limit_s:g} s")) for handle in late]

    def close(self, handles: Iterable[Any]) -> None:
        for process, connection, _ in handles:
            process.kill()
            process.join()
            connection.close()


@contextlib.contextmanager
def _path_inherited() -> Iterator[None]:
    """Processes that are started meanwhile find what this one imports, this package among it, and nothing else in the working folder."""
    given = {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path), "PYTHONSAFEPATH": "1"}
    before = {name: os.environ.get(name) for name in given}
    os.environ.update(given)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _version() -> str:
    return version()


class Ray:
    """Tasks of one processor each on the cluster at an address; `local` starts one on this machine."""

    def __init__(self, address: str, processes: int | None = None, limit_s: float | None = None) -> None:
        """limit_s: as of Local. Raises InvalidInput: no cluster answers, or its machines do not have this package; MissingExtra."""
        self._limit_s = limit_s
        self._late: dict[Any, float] = {}  # when a job will have used up its time
        self._ray = ray = require("ray", "ray", "ray")
        _require_answer(address)
        place = {"num_cpus": processes} if address == "local" else {}
        try:
            with _path_inherited() if place else contextlib.nullcontext():
                ray.init(address=address, log_to_driver=False, include_dashboard=False if place else None, **place)
        except (ConnectionError, TimeoutError) as error:
            raise InvalidInput(f"ray: got '{address}', where no cluster answers ({' '.join(str(error).split())})") from None
        self._address, self._looked = address, time.monotonic()
        self._heard = self._looked  # when the cluster was last seen to be able to carry out a job
        self._gone = False
        try:
            self._require_package()
        except BaseException:
            ray.shutdown()
            raise
        self.capacity = processes or int(ray.cluster_resources().get("CPU", 1))
        self._remote = ray.remote(num_cpus=1, max_retries=0)(carry_out)

    def _require_package(self) -> None:
        """Raises InvalidInput: a machine of the cluster lacks this package, or has another version; all runs would die there."""
        ray = self._ray
        on_node = ray.util.scheduling_strategies.NodeAffinitySchedulingStrategy
        probe = ray.remote(num_cpus=0, max_retries=1)(_version)
        nodes = {node["NodeID"]: node["NodeManagerHostname"] for node in ray.nodes() if node["Alive"] and node["Resources"].get("CPU", 0) >= 1}
        probes = {name: probe.options(scheduling_strategy=on_node(number, soft=False)).remote() for number, name in nodes.items()}
        for name, handle in probes.items():
            try:
                found = ray.get(handle, timeout=PROBE_S)
            except ray.exceptions.RayError as error:
                if (missing := re.search(r"No module named '[\w.]+'", str(error))) is None:
                    continue  # it is gone, or busy: jobs that come to it are tried elsewhere
                raise InvalidInput(f"ray: got '{self._address}', whose machine {name} cannot load stiction ({missing[0]}), expected stiction {version()} on every machine") from None
            if found != version():
                raise InvalidInput(f"ray: got '{self._address}', whose machine {name} has stiction {found}, expected {version()} on every machine")

    def start(self, function: Callable[[Any], Any], job: Any) -> Any:
        handle = self._remote.remote(function, job)
        if self._limit_s is not None:
            self._late[handle] = time.monotonic() + self._limit_s
        return handle

    def wait(self, handles: list[Any]) -> list[tuple[Any, Any]]:
        """Raises Vanished."""
        errors = self._ray.exceptions
        ready, _ = self._ray.wait(handles, timeout=LOOK_S)
        out = []
        for handle in ready:
            try:
                out.append((handle, self._ray.get(handle)))
            except errors.LocalRayletDiedError:
                raise self._vanished("its process on this machine has ended") from None
            except errors.NodeDiedError as error:
                out.append((handle, Lost(_one_line(error))))
            except errors.RayError as error:
                out.append((handle, Died(_one_line(error))))
        self._look()
        return out + self._stop_late([handle for handle in handles if handle not in ready])

    def _stop_late(self, running: list[Any]) -> list[tuple[Any, Any]]:
        now = time.monotonic()
        late = [handle for handle in running if now > self._late.get(handle, math.inf)]
        for handle in late:
            self._ray.cancel(handle, force=True)
        return [(handle, Stopped(f"its process was ended after {self._limit_s:g} s")) for handle in late]

    def _look(self) -> None:
        """Every now and then: does the head answer, and is there a machine that carries out jobs? Raises Vanished."""
        now = time.monotonic()
        if now - self._looked < CLUSTER_LOOK_S:
            return
        self._looked = now
        host, _, port = self._ray.get_runtime_context().gcs_address.rpartition(":")
        try:
            socket.create_connection((host, int(port)), timeout=CLUSTER_LOOK_S).close()
            answers, able = True, self._ray.cluster_resources().get("CPU", 0) >= 1
        except OSError:
            answers = able = False
        if able:
            self._heard = now
        elif now - self._heard > SILENCE_S:
            raise self._vanished("no machine of it is left" if answers else f"its head does not answer for {SILENCE_S:g} s")

    def _vanished(self, why: str) -> Vanished:
        self._gone = True
        return Vanished(f"ray: the cluster at {self._address} has vanished: {why}")

    def close(self, handles: Iterable[Any]) -> None:
        for handle in handles if not self._gone else ():
            self._ray.cancel(handle, force=True)
        self._ray.shutdown()


def _one_line(error: Exception) -> str:
    return " ".join(re.sub(r"\x1b\[\d*m", "", str(error)).split())[:200]


def _require_answer(address: str) -> None:
    """Raises InvalidInput: nothing listens at HOST:PORT; Ray itself would try for minutes."""
    host, _, port = address.removeprefix("ray://").rpartition(":")
    if not host:
        return  # local, auto
    try:
        socket.create_connection((host, int(port)), timeout=ANSWER_S).close()
    except (OSError, ValueError) as error:
        raise InvalidInput(f"ray: got '{address}', where nothing answers ({error}), expected HOST:PORT of a cluster, auto or local") from None
