"""`stiction report`: what others need to look at a problem, in one zip without paths, names of people or of machines (docs/commands.md)."""

from __future__ import annotations

import getpass
import json
import os
import platform
import re
import socket
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from . import _command, _core
from ._core import InvalidInput, Plan, Task, load_task, read_plan, version
from ._files import require_writable, write_whole

FORMAT, FORMAT_VERSION = "stiction-report", 1
LOG_MB = 5  # of a log its end counts
COMMON_NAMES = {"admin", "debian", "docker", "guest", "home", "localhost", "root", "runner", "ubuntu", "user"}  # that tell nobody who it was
LETTER = r"[^\s\"'<>|:;,()\[\]{}=/\\]"  # of a name in a path
PLAIN = r"[^\s\"'<>|:;,()\[\]{}=/\\.]"
FOLDER = rf"(?:{LETTER}*|{PLAIN}+(?: {PLAIN}+){{1,2}})[/\\]"  # its name may be two or three words
ABSOLUTE = rf"(?:file://|package://|[A-Za-z]:[/\\]|~[\w.-]*/|\.{{1,2}}/|/)(?:{FOLDER})*({LETTER}+)"
RELATIVE = rf"(?:{LETTER}+/){{1,64}}({LETTER}+\.[A-Za-z]\w{{0,4}})"  # to a file with an ending; N/m and body/link_0.0 are none
PATHS = re.compile(rf"(?<![\w.)/]){ABSOLUTE}|{RELATIVE}")
ADDRESSES = re.compile(r"[\w.+-]+@[\w-]+(?:\.[\w-]+)*|\b\d{1,3}(?:\.\d{1,3}){3}\b")


class Scrubber:
    """Takes from a text what says where it was made and by whom: folders of paths, names of user and machine, addresses."""

    def __init__(self, names: Sequence[str]) -> None:
        telling = sorted({name for name in names if len(name) >= 3 and name.lower() not in COMMON_NAMES}, key=len, reverse=True)
        self._names = re.compile("|".join(map(re.escape, telling)), re.IGNORECASE) if telling else None

    def __call__(self, text: str) -> str:
        text = ADDRESSES.sub("ADDRESS", text)
        text = PATHS.sub(self._shorten, text)
        return text if self._names is None else self._names.sub("NAME", text)

    @staticmethod
    def _shorten(match: re.Match[str]) -> str:
        """The last part of a path, after dots."""
        return f".../{match.group(1) or match.group(2)}"


def names_here() -> list[str]:
    """Of the user and of the machine, and the folders that lead to the home of the user."""
    names = [socket.gethostname(), socket.gethostname().split(".")[0], platform.node(), *Path.home().parts[1:]]
    try:
        names.append(getpass.getuser())
    except (KeyError, OSError):  # a user without a name
        pass
    return [name for name in names if name]


def about_machine() -> dict[str, Any]:
    built = Path(__file__).with_name("built_for.txt")
    return {
        "system": platform.system(),
        "release": ".".join(re.findall(r"\d+", platform.release())[:2]),
        "processor": platform.machine(),
        "cores": os.cpu_count(),
        "python": platform.python_version(),
        "built_for": built.read_text(encoding="utf-8").split() if built.is_file() else [],
    }


def try_task(task: Task, seed: int, timeout_s: float) -> tuple[dict[str, Any], Plan | None]:
    """What lint, a search and a check of its plan say; an error of theirs is a part of the answer."""
    out: dict[str, Any] = {"seed": seed, "timeout_s": timeout_s}
    try:
        out["lint"] = [repr(finding) for finding in _core.lint(task)]
        result = _core.plan(task, seed=seed, timeout_s=timeout_s)
        out |= {"status": result.status.name, "reason": result.reason, "wall_s": result.wall_s, "nodes": result.nodes, "steps": result.steps}
        out |= {"failed_steps": result.failed_steps, "error": {"position": result.plan.error.position, "angle": result.plan.error.angle}}
        out["check"] = repr(_core.check_plan(result.plan))
        return out, result.plan
    except Exception as error:  # this is what is to be reported
        return out | {"raised": f"{type(error).__name__}: {error}"}, None


def read_log(file: Path) -> str:
    """Its end. Raises InvalidInput: there is none."""
    try:
        data = file.read_bytes()
    except OSError as error:
        raise InvalidInput(f"{file}: cannot be read ({error.strerror}), expected a log") from None
    return data[-LOG_MB * 10**6 :].decode("utf-8", errors="replace")


def make_report(task: Task, *, seed: int = 0, timeout_s: float = 20.0, plan: Plan | None = None, logs: Sequence[Path] = (), note: str = "") -> dict[str, str]:
    """The files of a report by name, scrubbed."""
    texts = [read_log(log) for log in logs]
    if plan is None:
        tried, plan = try_task(task, seed, timeout_s)
    else:
        tried = {"seed": plan.seed, "status": plan.status.name, "check": repr(_core.check_plan(plan))}
    options = {name: value for name, value in task.options.to_dict().items() if value is not None}
    built_in = task.name in _core.list_tasks() and load_task(task.name).scene_sha256 == task.scene_sha256
    about = {"format": FORMAT, "format_version": FORMAT_VERSION, "code_version": version(), "task": task.name, "built_in": built_in}
    about |= {"scene_sha256": task.scene_sha256, "note": note, "machine": about_machine(), "tried": tried, "options": options, "notes": task.model.notes}
    files = {"report.json": json.dumps(about, indent=1, ensure_ascii=False, default=str)}
    text = task.text or (task.file.read_text(encoding="utf-8") if task.file.is_file() else "")
    if text:
        files["task.yaml"] = text
    if plan is not None:
        files["plan.json"] = plan.to_text()
    files |= {f"log_{k}.txt": log for k, log in enumerate(texts)}
    scrub = Scrubber(names_here())
    return {name: scrub(content) for name, content in files.items()}


def write_report(files: dict[str, str], file: Path) -> Path:
    def write(to: Path) -> None:
        with zipfile.ZipFile(to, "w", zipfile.ZIP_DEFLATED) as out:
            for name, content in files.items():
                out.writestr(zipfile.ZipInfo(name), content, zipfile.ZIP_DEFLATED)  # without the time of this machine

    return write_whole(file, write)


def main(words: Sequence[str]) -> int:
    """`stiction report`"""
    parser = _command.make_parser(
        "report", "Packs a problem report into a zip file: task, seed, version, result of a search, and logs. Paths and names are removed; look at the file before you send it."
    )
    parser.add_argument("task", metavar="TASK|PLAN", help="name or file of a task, or a plan file or its folder")
    parser.add_argument("--seed", type=_command.integer(0, 2**63 - 1), default=0, metavar="N", help="seed of the search (default: %(default)s)")
    parser.add_argument("--timeout", type=_command.positive, default=20.0, metavar="S", help="largest wall time of the search [s] (default: %(default)s)")
    parser.add_argument("--log", type=Path, action="append", default=[], metavar="FILE", help=f"log file of which the last {LOG_MB} MB are added; may be repeated")
    parser.add_argument("--note", default="", metavar="TEXT", help="description of the problem in your words")
    parser.add_argument("-o", "--out", type=Path, default=Path("report.zip"), metavar="FILE", help="zip file to write (default: %(default)s)")
    a = parser.parse_args(words)
    is_plan = a.task.endswith(".json") or Path(a.task).is_dir()
    plan = read_plan(a.task) if is_plan else None
    task = load_task(a.task) if plan is None else plan.task
    require_writable(a.out)
    files = make_report(task, seed=a.seed, timeout_s=a.timeout, plan=plan, logs=a.log, note=a.note)
    file = write_report(files, a.out)
    rows = {"files": ", ".join(files), "zip": str(file), "send": "nothing was sent; look at the files before you do"}
    _command.report(a, f"{task.name}: report", rows, {"status": "Done", "task": task.name, "files": list(files), "zip": str(file)})
    return _command.DONE
