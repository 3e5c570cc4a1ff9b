"""Whole scenes that are in one file, as tasks."""

from __future__ import annotations

import json
import os
import re
import tempfile
import warnings
from pathlib import Path

from . import _core, sdf


def import_scene(file: str | os.PathLike[str], *, out: str | os.PathLike[str] | None = None, object: str = "") -> _core.Task:
    """Makes a task from a whole scene in one MJCF, URDF or SDF file. Use it to plan in a scene that you already have.

    Kinematic trees with an actuator become robots. The moving bodies of other trees become objects, and all other bodies are fixed. The task
    starts at the first keyframe, or else in the configuration of the file. Its goal is a placeholder: replace it by Task.set_goal or in the
    task file. An SDF file is first converted to MJCF (stiction.sdf). Each element that MJCF cannot represent exactly gives a warning.

      file: MJCF, URDF or SDF file.
      out: task file to write. It lists the robots and objects that were found, and you may edit it. For an SDF file, the MJCF is written
        beside it. None: the task is made in memory, and Task.text holds its text.
      object: name of the object that the goal moves. Empty: the first object.

    Returns a Task. Raises InvalidInput; for an SDF file also MissingExtra: Drake is not installed.

    >>> xml = "<mujoco><worldbody><body pos='0 .3 0'><joint name='lid' type='slide' axis='1 0 0' range='0 .2'/><geom name='box' size='.05'/></body>" \\
    ...     "<body><joint name='arm' axis='0 0 1'/><geom type='capsule' fromto='0 0 0 0 .2 0' size='.02'/></body></worldbody>" \\
    ...     "<actuator><position joint='arm' kp='50'/></actuator></mujoco>"
    >>> with open("scene.xml", "w") as file:
    ...     _ = file.write(xml)
    >>> task = st.import_scene("scene.xml")
    >>> task.model.joint_names, task.model.object_names, task.q_goal
    (['robot/arm'], ['body_1'], array([0.18]))
    """
    if not sdf.is_sdf(file):
        return _core._import_scene(file, out=out, object=object)
    task, notes = _in_memory(Path(file), object) if out is None else _in_files(Path(file), Path(out), object)
    for note in notes:
        warnings.warn(f"{file}: {note}", stacklevel=2)
    return task


def _in_files(source: Path, out: Path, object: str) -> tuple[_core.Task, list[str]]:
    mjcf = out.with_suffix(".xml")
    if mjcf == out or (mjcf.exists() and not sdf.made_of_sdf(mjcf)):
        was = "which is that file" if mjcf == out else "which is there already"
        raise _core.InvalidInput(f"out: got '{out}', expected a task file with another name: the MJCF of {source.name} is to be {mjcf.name} beside it, {was}")
    notes = sdf.convert_sdf(source, mjcf)
    return _core._import_scene(mjcf, out=out, object=object), notes


def _in_memory(source: Path, object: str) -> tuple[_core.Task, list[str]]:
    """The MJCF is a text in the task, which leaves no file behind."""
    mjcf, notes = sdf.make_mjcf(source)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"{source.stem}.xml"
        file.write_bytes(mjcf)
        try:
            found = _core._import_scene(file, object=object)
        except _core.InvalidInput as error:
            raise _core.InvalidInput(str(error).replace(str(file), str(source))) from None
    text = json.dumps(mjcf.decode(), ensure_ascii=False)  # as YAML takes it
    return _core._parse_task(re.sub(r"(?m)^  file: .*$", lambda _: f"  file: {text}", found.text, count=1)), notes
