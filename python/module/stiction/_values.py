"""Text, equality and hash of the values of the extension module, from their fields."""

from __future__ import annotations

import enum
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from . import _core

LONGEST = 60  # characters of one field, and numbers of an array
MOST = 8


def values_equal(a: Any, b: Any) -> bool:
    """Whether two fields are equal. Arrays are if they have the same shape and numbers; NaN equals NaN."""
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        a, b = np.asarray(a), np.asarray(b)
        return bool(np.array_equal(a, b, equal_nan=a.dtype.kind == "f" and b.dtype.kind == "f"))
    return bool(a == b)


def fields_equal(a: Any, b: Any) -> bool:
    """Equality of two dataclasses, whose arrays would make the one that Python writes fail."""
    return all(values_equal(getattr(a, field.name), getattr(b, field.name)) for field in fields(a))


def _show(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, np.ndarray) and value.size <= MOST:
        return np.array2string(value + 0 if value.dtype.kind == "f" else value, precision=6, separator=", ").replace("\n", "")
    if isinstance(value, np.ndarray):
        return f"array of {value.dtype} {value.shape}"
    if isinstance(value, enum.Enum):
        return str(value)
    if isinstance(value, (list, tuple, dict)) and len(value) > MOST:
        return f"{type(value).__name__} of {len(value)}"
    if isinstance(value, (list, tuple)):
        text = ", ".join(_show(item) for item in value)
        text = f"[{text}]" if isinstance(value, list) else f"({text})"
        return text if len(text) <= LONGEST else f"{type(value).__name__} of {len(value)}"
    text = repr(str(value) if isinstance(value, Path) else value)
    if len(text) <= LONGEST:
        return text
    if isinstance(value, (str, Path)):
        return f"{str(value)[:LONGEST]!r}…"
    return f"<{'stiction.' if type(value).__module__ == _core.__name__ else ''}{type(value).__name__}>"


def _text(self: Any) -> str:
    parts = []
    for name, member in vars(type(self)).items():
        if not isinstance(member, property):
            continue
        try:
            parts.append(f"{name}={_show(getattr(self, name))}")
        except Exception:  # a value that the object cannot give now
            continue
    return f"<stiction.{type(self).__name__}: {', '.join(parts)}>" if parts else f"<stiction.{type(self).__name__}>"


def _equal(a: Any, b: Any) -> bool:
    if type(a) is not type(b):
        return NotImplemented
    return a is b or bool(a.__getstate__() == b.__getstate__())


def _hash(a: Any) -> int:
    return hash((type(a), *(part for part in a.__getstate__() if isinstance(part, (str, bytes)))))


def _same_pose(a: Any, b: Any) -> bool:
    if type(a) is not type(b):
        return NotImplemented
    return bool(np.array_equal(a.R, b.R) and np.array_equal(a.p, b.p))


def _same_scene(a: Any, b: Any) -> bool:
    if type(a) is not type(b):
        return NotImplemented
    return a is b or bool(a.scene == b.scene)


def _same_sensor(a: Any, b: Any) -> bool:
    """Made of equal models with equal options."""
    if type(a) is not type(b):
        return NotImplemented
    return a is b or bool(a.__reduce__()[1] == b.__reduce__()[1])


def _hash_of_sensor(sensor: Any) -> int:
    return hash(type(sensor))


def _frozen(value: Any) -> Any:
    if isinstance(value, dict):
        return tuple((key, _frozen(part)) for key, part in value.items())
    return tuple(_frozen(part) for part in value) if isinstance(value, list) else value


def _hash_of_options(options: _core.PlannerOptions) -> int:
    return hash(_frozen(options.to_dict()))  # the text tells -0.0 from 0.0, which are equal


def _hash_of_pose(pose: _core.Pose) -> int:
    return hash(tuple(np.concatenate([pose.R.ravel(), pose.p]).tolist()))


def _hash_of_model(model: _core.Model) -> int:
    return hash((model.n_q, *model.joint_names, *model.object_names))


def _text_of_task(task: _core.Task) -> str:
    return f"<stiction.Task {task.name!r}>"


def _give(cls: type, **methods: Any) -> None:
    for name, method in methods.items():
        setattr(cls, f"__{name}__", method)


def complete() -> None:
    """Gives the classes of the module what they lack."""
    for cls in vars(_core).values():
        if not isinstance(cls, type) or issubclass(cls, (enum.Enum, BaseException)):
            continue
        if cls.__repr__ is object.__repr__:
            _give(cls, repr=_text)
        if "__getstate__" in vars(cls) and cls.__eq__ is object.__eq__:
            _give(cls, eq=_equal, hash=_hash)
    _give(_core.Task, repr=_text_of_task)
    _give(_core.PlannerOptions, hash=_hash_of_options)
    _give(_core.Pose, eq=_same_pose, hash=_hash_of_pose)  # -0.0 equals 0.0
    _give(_core.Model, eq=_same_scene, hash=_hash_of_model)
    _give(_core._SharedSensor, eq=_same_sensor, hash=_hash_of_sensor)
