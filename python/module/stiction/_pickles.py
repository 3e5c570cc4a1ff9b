"""What pickle calls to make anew what values share."""

from __future__ import annotations

from typing import Any

from . import _core


def make_model(scene: _core.Scene) -> _core.Model:
    return _core.Model.make(scene)


def make_shared_sensor(model: _core.Model, options: Any) -> Any:
    return _core._make_shared_sensor(model, options)
