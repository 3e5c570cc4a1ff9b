"""Loads the extension with the libraries that it was linked to."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

# One function of each library that may be in a process twice.
NAMES = ("mj_step", "aiImportFile", "qh_new_qhull", "_ZN4YAML9ExceptionD1Ev", "_ZN8tinyxml211XMLDocumentD1Ev")


@contextmanager
def libraries() -> Iterator[None]:
    """Within the block, extensions look for functions in their own libraries first, if a program has made others known to the whole process.

    Modules of Python do not do that. A program that is linked to such a library does, and so does RTLD_GLOBAL. Otherwise nothing is changed,
    since a replaced `malloc` or a sanitizer wants to be found first.
    """
    before = sys.getdlopenflags()
    process = ctypes.CDLL(None)
    if any(hasattr(process, name) for name in NAMES):
        sys.setdlopenflags(before | getattr(os, "RTLD_DEEPBIND", 0))
    try:
        yield
    finally:
        sys.setdlopenflags(before)
