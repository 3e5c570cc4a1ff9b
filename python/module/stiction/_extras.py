"""Packages that only some functions need."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType


class MissingExtra(ImportError):
    """An optional package is not installed. The message names the extra of stiction that installs it."""


def require(extra: str, purpose: str, module: str) -> ModuleType:
    """The module, of the optional extra `stiction[extra]`."""
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        if (error.name or "").split(".")[0] != module.split(".")[0]:
            raise  # it is there, and broken
        raise MissingExtra(f"{purpose}: no Python module '{module}'; `pip install 'stiction[{extra}]'` brings it") from None
