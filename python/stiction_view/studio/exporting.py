"""What is taken away of a result: its plan, its motion over time in four formats, its page, what plans it again, and a report of a problem."""

from __future__ import annotations

import io
import tempfile
import zipfile
from collections.abc import Mapping
from pathlib import Path

import stiction as st
from stiction.reports import make_report

from ..scene import make_page
from .results import Result

EVERYTHING, PAGE, PLAN, REPORT = "everything", "page (html)", "plan.json", "report of a problem"
MOTIONS = ("csv", "npz", "json", "mcap")
CHOICES = (EVERYTHING, PLAN, PAGE, *MOTIONS, REPORT)


def script(command: str, task_file: str | None) -> str:
    """Lines for a shell: they write the task where it is in no file, and plan it."""
    return (f"cat > task.yaml <<'END'\n{task_file}END\n" if task_file is not None else "") + command + "\n"


def reproduce(result: Result) -> str:
    """What plans it again, as lines for a shell."""
    head = f"# stiction {st.version()}, task '{result.plan.task.name}', scene {result.plan.task.scene_sha256[:12]}, seed {result.plan.seed}\n"
    return head + script(result.command, result.task_file)


def motion(plan: st.Plan, format: str) -> dict[str, bytes]:
    """Files of `stiction export` by their names. Raises stiction.MissingExtra."""
    with tempfile.TemporaryDirectory(prefix="stiction-export-") as folder:
        return {file.name: file.read_bytes() for file in plan.export(Path(folder) / f"motion.{format}")}


def files(result: Result, choice: str) -> dict[str, bytes]:
    """What a choice gives. Raises stiction.MissingExtra; everything goes without what is missing, and says so."""
    if choice == PLAN:
        return {"plan.json": result.plan.to_text().encode()}
    if choice == PAGE:
        return {"plan.html": make_page(result.drawn).encode()}
    if choice == REPORT:
        return {name: content.encode() for name, content in make_report(result.plan.task, plan=result.plan).items()}
    if choice in MOTIONS:
        return motion(result.plan, choice)
    text, out = reproduce(result), files(result, PLAN) | files(result, PAGE)
    for format in MOTIONS:
        try:
            out |= motion(result.plan, format)
        except st.MissingExtra as error:
            text += f"# left out: {error}\n"
    if result.task_file is not None:
        out["task.yaml"] = result.task_file.encode()
    return out | result.files | {"reproduce.txt": text.encode()}


def as_zip(found: Mapping[str, bytes | str]) -> bytes:
    """One file of several."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for file, content in found.items():
            archive.writestr(file, content)
    return buffer.getvalue()


def export(result: Result, choice: str) -> tuple[str, bytes]:
    """Name and content of one file; of several a zip."""
    name = f"{result.plan.task.name}-seed{result.plan.seed}"
    found = files(result, choice)
    if len(found) == 1:
        (file, content), = found.items()
        return f"{name}-{file}", content
    return f"{name}{'' if choice == EVERYTHING else '-' + choice.split()[0]}.zip", as_zip(found)
