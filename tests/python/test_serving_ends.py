"""Programs that serve a page end at the usual signals, however they were started: with their port, their temporary files and all that they have started."""

from __future__ import annotations

import contextlib
import http.client
import os
import signal
import sys
from pathlib import Path
from urllib.parse import urlsplit

import children
import pytest
from studio_window import ADDRESS

ROOT = Path(__file__).resolve().parents[2]
TUTORIAL = ROOT / "docs" / "tutorials" / "touch.yaml"
ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
# What a script does before it starts a program in the background, and what nohup does.
IGNORED = {"": "", "INT": "trap '' INT; ", "HUP": "trap '' HUP; "}


def started(words: list[object], folder: Path, ignored: str = "") -> children.Child:
    shell = ["sh", "-c", IGNORED[ignored] + 'exec "$@"', "sh"]
    return children.Child([*shell, *words], cwd=folder, env={**os.environ, "TMPDIR": str(folder)})


def address_of(child: children.Child) -> str:
    """As it has printed it."""
    line = child.line()
    found = ADDRESS.match(line)
    assert found is not None, line
    return found.group(0)


def is_served(address: str) -> bool:
    """By the program that knows its token: as soon as the port is free, another program may take the port."""
    parts = urlsplit(address)
    with contextlib.closing(http.client.HTTPConnection("127.0.0.1", parts.port, timeout=30)) as connection:
        try:
            connection.request("GET", f"/?{parts.query}")
            return connection.getresponse().status == 303
        except ConnectionError:
            return False


def check_ends(child: children.Child, address: str, number: signal.Signals, folder: Path) -> None:
    assert is_served(address)
    done = child.stop(number, limit=60)
    assert done.returncode == 0 and "Traceback" not in done.stderr, done.stderr
    assert not is_served(address)
    with pytest.raises(ProcessLookupError):  # nobody of its group is left
        os.killpg(child.pid, 0)
    assert list(folder.iterdir()) == [], "no temporary file is left"


@pytest.mark.parametrize("number", ENDING)
@pytest.mark.parametrize("ignored", ["", "INT"])
@pytest.mark.parametrize("words", [["studio", "planar_pushing", "--port", 0], ["view", "planar_pushing"], ["sense", TUTORIAL, "--live", "--port", 0]], ids=["studio", "view", "sense"])
def test_program_ends_at_a_signal_and_frees_its_port(program: Path, tmp_path: Path, words: list[object], ignored: str, number: signal.Signals) -> None:
    with started([program, *words], tmp_path, ignored) as child:
        check_ends(child, address_of(child), number, tmp_path)


def test_view_of_a_plan_ends_and_leaves_the_plan(program: Path, real_plan: Path, tmp_path: Path) -> None:
    with started([program, "view", real_plan], tmp_path, "INT") as child:
        check_ends(child, address_of(child), signal.SIGINT, tmp_path)
    assert real_plan.is_file()


@pytest.mark.parametrize("words", [["studio", "planar_pushing", "--port", 0], ["view", "planar_pushing"]], ids=["studio", "view"])
def test_program_that_was_started_with_nohup_goes_on_at_a_hangup(program: Path, tmp_path: Path, words: list[object]) -> None:
    with started([program, *words], tmp_path, "HUP") as child:
        address = address_of(child)
        child.send_signal(signal.SIGHUP)
        check_ends(child, address, signal.SIGTERM, tmp_path)


def test_signals_that_come_several_times_end_it_once(program: Path, tmp_path: Path) -> None:
    with started([program, "studio", "planar_pushing", "--port", 0], tmp_path) as child:
        address = address_of(child)
        for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGTERM):  # as a terminal that is closed
            child.send_signal(number)
        check_ends_without_signal(child, address, tmp_path)


def check_ends_without_signal(child: children.Child, address: str, folder: Path) -> None:
    done = child.finish(limit=60)
    assert done.returncode == 0, done.stderr
    assert not is_served(address) and list(folder.iterdir()) == []


STUDIO = """
import tempfile
from pathlib import Path
from stiction_view.program import announce, end_on_signals, leave, run_until_interrupted
from stiction_view.studio import catalog
from stiction_view.studio.app import Studio
from stiction_view.studio.server import serving

end_on_signals()

BEGIN

def show():
    entries, first = catalog.find("allegro_cube_180")
    with serving("127.0.0.1", 0) as server, tempfile.TemporaryDirectory() as folder:
        studio = Studio(server, entries, first, Path(folder))
        begin(studio)
        announce(server)
        studio.run()

leave(run_until_interrupted(show))
"""


SEARCH = """
def begin(studio):
    studio.panel.search.budget.value = 600.0
    studio.planning.plan()
    while studio.work.running.fraction == 0:
        studio.step(0.01)
"""
DEAF = """
import stiction as st
from stiction_view.studio.jobs import Job

def begin(studio):
    task = st.load_task("allegro_cube_180")
    studio.work.start(Job("Long", lambda _: [st.plan(task, seed=seed, timeout_s=600) for seed in range(100)], lambda _: None))
"""  # it cannot be cancelled


@pytest.mark.parametrize(("begin", "number"), [*((SEARCH, number) for number in ENDING), (DEAF, signal.SIGTERM)], ids=["search, SIGINT", "search, SIGTERM", "search, SIGHUP", "deaf, SIGTERM"])
def test_studio_ends_while_a_job_runs(program: Path, tmp_path: Path, begin: str, number: signal.Signals) -> None:
    code = STUDIO.replace("BEGIN", begin)
    path = os.pathsep.join(str(place) for place in (ROOT / "python", ROOT / "build" / "release" / "python"))
    with children.Child([sys.executable, "-c", code], cwd=tmp_path, env={**os.environ, "TMPDIR": str(tmp_path), "PYTHONPATH": path}) as child:
        check_ends(child, address_of(child), number, tmp_path)


CAUGHT = """
import os, signal, sys, time, weakref
from stiction_view import program

program.end_on_signals()

class Thing: pass

def collected(_):  # the signal comes, and Python drops what its handler raises
    os.kill(os.getpid(), signal.SIGTERM)
    for _ in range(1000): pass

thing = Thing()
watched = weakref.ref(thing, collected)

def show():
    global thing
    thing = None
    while True:
        program.check_interrupted()
        time.sleep(0.01)

sys.exit(program.run_until_interrupted(show))
"""


def test_signal_in_a_callback_of_the_garbage_collector_is_not_lost(tmp_path: Path) -> None:
    done = children.run([sys.executable, "-c", CAUGHT], limit=60, cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(ROOT / "python")})
    assert (done.returncode, done.stderr) == (0, "")
