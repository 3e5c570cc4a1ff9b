"""What can be opened: built-in tasks and scenarios, files, whole scenes of others, the files of a folder."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import stiction as st

from .form import tasks_folder

TASK, SENSE, CONTROL, SCENE = "task", "sense", "control", "scene"
SUFFIXES = (".yaml", ".yml")
SCENES = (".xml", ".mjcf", ".urdf", ".sdf", ".world")  # that are imported


@dataclass(frozen=True)
class Entry:
    kind: str
    label: str
    source: str | Path


def kind_of(file: Path) -> str:
    """Of a YAML file, by the keys that only one kind has."""
    try:
        text = file.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return TASK  # its reader says what is wrong
    keys = set(re.findall(r"^([a-z_]+):", text, flags=re.MULTILINE))
    if "reference" in keys:
        return CONTROL
    return SENSE if keys & {"contact", "torques", "series"} and "goal" not in keys else TASK


def entry_of(file: Path, builtin: bool = False) -> Entry:
    kind = SCENE if file.suffix.lower() in SCENES else kind_of(file)
    label = file.stem if kind == TASK else f"{file.stem} ({kind})"
    return Entry(kind, label, file.stem if builtin else file)


def builtin() -> list[Entry]:
    """Tasks that have a start and a goal for the planner, then scenarios."""
    tasks = [Entry(TASK, name, name) for name in st.list_tasks()]
    scenarios = sorted((tasks_folder().parent / "scenarios").glob("*.yaml"))
    return tasks + sorted((entry_of(file, builtin=True) for file in scenarios), key=lambda e: e.label)


def in_folder(folder: Path) -> list[Entry]:
    return [entry_of(file) for file in sorted(folder.iterdir()) if file.suffix in SUFFIXES and file.is_file()]


def told_apart(entries: Sequence[Entry]) -> list[Entry]:
    """The same with a label for each of its own: a list with two of the same leaves the page empty."""
    out: dict[str, Entry] = {}
    for entry in entries:
        label = entry.label
        if label in out:
            label = f"{label} (built-in)" if isinstance(entry.source, str) else entry.source.name
        while label in out:
            label += "'"
        out[label] = replace(entry, label=label)
    return list(out.values())


def find(shown: str | None) -> tuple[list[Entry], Entry | None]:
    """Everything that can be picked, and what is shown first. Raises ValueError: there is no such thing."""
    entries = builtin()
    if shown is None:
        return entries, next((e for e in entries if e.label == "allegro_cube"), entries[0])
    path = Path(shown)
    if path.is_dir():
        own = in_folder(path)
        if not own:
            raise ValueError(f"shown: got the folder '{shown}' without .yaml files, expected tasks or scenarios in it")
        return told_apart(own + entries), own[0]
    if path.suffix.lower() in SUFFIXES + SCENES or "/" in shown:
        if not path.is_file():
            raise ValueError(f"shown: got '{shown}', which does not exist, expected a task, a scenario, a scene (MJCF, URDF or SDF) or a folder of tasks")
        chosen = entry_of(path.resolve())
        return told_apart([chosen, *entries]), chosen
    chosen = next((e for e in entries if e.source == shown), None)
    if chosen is None:
        raise ValueError(f"shown: got '{shown}', expected a file, a folder, or one of {', '.join(str(e.source) for e in entries)}")
    return entries, chosen
