"""Files that are there whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from ._core import InvalidInput


def require_folder(file: Path) -> None:
    """Makes the folder of a file to write. Raises InvalidInput: it cannot."""
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InvalidInput(f"{file.parent}: cannot be made ({error.strerror}), expected a folder to write to") from None
    if file.is_dir():
        raise InvalidInput(f"{file}: got a folder, expected a file to write")


def write_whole(file: Path, write: Callable[[Path], object]) -> Path:
    """Lets `write` make the file under a temporary name and renames it. Raises InvalidInput: it cannot be written."""
    require_folder(file)
    temporary = file.with_name(f".{file.stem}.{os.getpid()}{file.suffix}")
    try:
        write(temporary)
        temporary.replace(file)
    except OSError as error:
        raise InvalidInput(f"{file}: cannot be written ({error.strerror}), expected a folder to write to") from None
    finally:
        temporary.unlink(missing_ok=True)
    return file
