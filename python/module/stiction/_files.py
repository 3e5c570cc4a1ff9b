"""Files that are there whole or not at all, and tables and arrays that others wrote."""

from __future__ import annotations

import csv
import os
import re
import threading
import zipfile
import zlib
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import TextIO

import numpy as np

from ._core import InvalidInput


def require_folder(file: Path) -> Path:
    """Makes the folder of a file to write, and returns where it is written: a link leads to it. Raises InvalidInput: it cannot, or something else is there."""
    try:
        is_folder, is_other = file.is_dir(), file.exists() and not file.is_file()  # also /dev/stdout, a link to no path
        place = Path(os.path.realpath(file))  # fails where the working folder is gone
        if not is_other:
            place.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InvalidInput(f"{file.parent}: cannot be made or written ({error.strerror}), expected a folder to write to") from None
    if is_other:  # renaming would remove a device
        raise InvalidInput(f"{file}: got {'a folder' if is_folder else 'a device or a pipe'}, expected a file to write")
    return place


def require_writable(file: Path) -> None:
    """Before the work, not after it. Raises InvalidInput as write_whole()."""
    probe = require_folder(file).with_name(f".stiction-probe-{os.getpid()}")
    try:
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise _unwritable(file, error) from None


def _unwritable(file: Path, error: OSError) -> InvalidInput:
    return InvalidInput(f"{file}: cannot be written ({error.strerror}), expected a folder to write to")


def write_whole(file: Path, write: Callable[[Path], object]) -> Path:
    """Lets `write` make the file under a temporary name and renames it. Raises InvalidInput: it cannot be written."""
    place = require_folder(file)
    temporary = place.with_name(f".stiction-{os.getpid()}-{threading.get_ident()}{place.suffix}")
    try:
        write(temporary)
        temporary.replace(place)
    except OSError as error:
        raise _unwritable(file, error) from None
    finally:
        temporary.unlink(missing_ok=True)
    return file


@dataclass(frozen=True)
class Rows:
    """A table of words: its names, and the cells and the line of each row."""

    names: list[str]
    cells: list[list[str]]
    lines: list[int]


def read_csv(file: Path, *, whole: bool = False) -> Rows:
    """Reads a table with a line of names. Between cells are commas, semicolons, tabs or blanks, as between the names; beside semicolons numbers may have a decimal comma.

    Lines end as on any system. Empty lines, and lines that begin with #, are left out. whole: leave out a last line that does not end, as it may
    have been cut off. Raises InvalidInput: no such table, a name that is there twice, or a row of another length.
    """
    names: list[str] = []
    cells, lines = [], []
    try:
        with file.open(encoding="utf-8-sig", newline="") as text:
            kept = _Kept(file, text, whole)
            for row in csv.reader(kept, delimiter=kept.delimiter, skipinitialspace=True):
                row = [cell.strip() for cell in row]
                if not names:
                    names = row
                    continue
                if len(row) != len(names):
                    raise InvalidInput(f"{file}:{kept.line}: got {len(row)} cells, expected {len(names)}, one for each name")
                cells.append([_with_point(cell) for cell in row] if kept.delimiter == ";" else row)
                lines.append(kept.line)
    except OSError as error:
        raise InvalidInput(f"{file}: cannot be read ({error.strerror}), expected a table (CSV)") from None
    except (UnicodeDecodeError, csv.Error) as error:
        raise InvalidInput(f"{file}: cannot be read ({error}), expected a table (CSV) in UTF-8") from None
    if twice := [name for name, count in Counter(names).items() if name and count > 1]:
        raise InvalidInput(f"{file}: got the column '{twice[0]}' more than once, expected every name once")
    return Rows(names, cells, lines)


class _Kept:
    """The lines of a table, without those that say nothing."""

    def __init__(self, file: Path, text: TextIO, whole: bool) -> None:
        self._file, self.line = file, 0
        self._lines = ((k, line) for k, line in enumerate(text, 1) if line.strip() and not line.startswith("#") and (not whole or line[-1] in "\r\n"))
        self._first = next(self._lines, (0, ""))
        self.delimiter = max(",;\t", key=self._first[1].count)
        if self.delimiter not in self._first[1] and " " in self._first[1].strip():
            self.delimiter = " "

    def __iter__(self) -> Iterator[str]:
        for self.line, line in chain([self._first], self._lines):
            if "\0" in line:
                raise InvalidInput(f"{self._file}: got a byte 0 in line {self.line}, expected a table (CSV), which is text")
            yield line.strip() if self.delimiter == " " else line


def _with_point(cell: str) -> str:
    return cell.replace(",", ".") if re.fullmatch(r"[+-]?\d*,\d+([eE][+-]?\d+)?", cell) else cell


def read_npz(file: str | os.PathLike[str], names: Sequence[str], what: str) -> dict[str, np.ndarray]:
    """Reads all arrays of a file of numpy.savez. Raises InvalidInput: no such file, or without an array of these names."""
    try:
        with Path(file).open("rb") as stream:
            if not zipfile.is_zipfile(stream):
                raise ValueError("no archive of numpy.savez")
            stream.seek(0)
            data = np.load(stream, allow_pickle=False)
            arrays = {name: data[name] for name in data.files}
    except OSError as error:
        raise InvalidInput(f"{file}: cannot be read ({error.strerror or error}), expected {what}") from None
    except (ValueError, EOFError, zipfile.BadZipFile, zlib.error) as error:
        raise InvalidInput(f"{file}: cannot be read ({error}), expected {what}") from None
    if missing := [name for name in names if name not in arrays]:
        raise InvalidInput(f"{file}: {missing[0]}: got no such array among {', '.join(arrays) or 'none'}, expected {what} with {', '.join(names)}")
    return arrays
