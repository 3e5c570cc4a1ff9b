"""Docstrings of the module: every public class and call has one, their examples run, and every command of the program has its call."""

from __future__ import annotations

import doctest
import enum
import inspect
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import children
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
MODULE = ROOT / "build" / "release" / "python"
if not (MODULE / "stiction").is_dir():
    pytest.skip(f"{MODULE} does not exist: run `make build`", allow_module_level=True)
sys.path.insert(0, str(MODULE))

import stiction as st  # noqa: E402

# What needs no words: protocols of Python, and what enumerations inherit.
SILENT = re.compile(r"__.*__$")


def public() -> Iterator[tuple[str, Any]]:
    """Classes, functions and methods, by name."""
    for name in dir(st):
        thing = getattr(st, name)
        if name.startswith("_") or inspect.ismodule(thing):
            continue
        if callable(thing):
            yield name, thing
        if inspect.isclass(thing) and not issubclass(thing, (enum.Enum, Exception)):
            for member, value in vars(thing).items():
                if not SILENT.match(member) and callable(value):
                    yield f"{name}.{member}", value
                if member in ("__init__", "__new__") and ">>> " in (value.__doc__ or ""):
                    yield name + "()", value  # a constructor says it of its own; else its class does


PUBLIC = dict(public())


def text(name: str) -> str:
    """Without the lines of signatures that nanobind puts first."""
    doc = inspect.getdoc(PUBLIC[name]) or ""
    short = name.split(".")[-1].removesuffix("()")
    return "\n".join(line for line in doc.splitlines() if not re.match(rf"(\d+\. ``)?({re.escape(short)}|__init__|__new__)\(", line)).strip()


@pytest.mark.parametrize("name", [name for name, thing in PUBLIC.items() if not (inspect.isclass(thing) and issubclass(thing, Exception))])
def test_what_is_public_says_what_it_is(name: str) -> None:
    own = PUBLIC[name]
    assert text(name) or (inspect.isclass(own) and text(f"{name}()")), name


EXAMPLES = sorted({name for name in PUBLIC if ">>> " in (PUBLIC[name].__doc__ or "")})
# Calls that a user meets first: each has an example that runs.
NEEDED = """Pose Task load_model Model.retract step calc_local_model rollout step_batch simulate DrivenPlant list_tasks load_task Task.with_ planner_schema
lint plan read_plan parse_plan Plan Plan.export refine check_plan make_trajectory optimize solve transfer run view sweep
Sensor load_sensing_scenario sense ContactController load_control_scenario control load_touch_scenario touch""".split()


def test_first_calls_have_examples() -> None:
    assert not sorted(set(NEEDED) - {name.removesuffix("()") for name in EXAMPLES})


@pytest.mark.parametrize("name", EXAMPLES)
def test_example_runs(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    example = doctest.DocTestParser().get_doctest(PUBLIC[name].__doc__, {"st": st, "np": np}, name, name, 0)
    assert example.examples
    failed = doctest.DocTestRunner(verbose=False).run(example).failed
    assert not failed, capsys.readouterr().out


def test_every_command_has_its_call(program: Path) -> None:
    """The table of python/README.md names every command of the program, and calls that are there."""
    import subprocess

    shown = children.run([program, "--help"], limit=60).stdout
    commands = set(re.findall(r"^  ([a-z]+) ", shown.split("Subcommands:")[1], flags=re.MULTILINE))
    table = (ROOT / "python" / "README.md").read_text(encoding="utf-8").split("## Commands")[1].split("\n## ")[0]
    rows = re.findall(r"^\| `([a-z]+)` \| (.*) \|$", table, flags=re.MULTILINE)
    assert {command for command, _ in rows} == commands
    for command, calls in rows:
        for name in re.findall(r"`(?:st\.)?([A-Za-z_.]+)\(", calls):
            name = name.replace("plan.", "Plan.").replace("task.", "Task.").replace("sensor.", "Sensor.")
            assert name in PUBLIC, f"{command}: {name}"
