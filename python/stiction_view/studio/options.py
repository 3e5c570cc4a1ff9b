"""The options of a task that is posed: changed, refused, reset."""

from __future__ import annotations

from collections.abc import Callable

from . import form
from .desk import MISTAKES
from .panel import OptionControls
from .problem import Problem
from .texts import plain


class Options:
    """`changed` is called when other options are wanted."""

    def __init__(self, controls: OptionControls, changed: Callable[[], None]):
        self._controls, self._changed = controls, changed
        self._problem: Problem | None = None

    def open(self, problem: Problem | None) -> None:
        """None: nothing is posed, and nothing can be changed."""
        self._problem = problem
        if problem is not None:
            given = problem.given.options
            self._controls.say("")
            self._controls.fill(form.fields(given), given.to_dict())

    def read(self) -> None:
        problem, controls = self._problem, self._controls
        if problem is None:
            return
        try:
            values = {name: field.read(handle.value) for name, (field, handle) in controls.fields.items()}
            problem.options = form.changed(problem.given.options, values)
        except MISTAKES as error:
            controls.say(f"**⚠ {plain(str(error))}**")
            return
        changed = ", ".join(f"`{name}`" for name in problem.options)
        controls.say(f"changed: {changed}" if changed else "")
        self._changed()

    def reset(self) -> None:
        if self._problem is not None:
            self._problem.options = {}
            self.open(self._problem)
            self._changed()
