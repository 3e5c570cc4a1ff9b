"""A table that grows by a row as soon as there is one, and can be gone on with (docs/sweeps.md)."""

from __future__ import annotations

import csv
import fcntl
import io
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any, TextIO

from ._core import InvalidInput
from ._extras import require
from ._files import read_csv, require_folder, write_whole


def to_cell(value: Any) -> str:
    """Words as they are, nothing for None, everything else as JSON."""
    if value is None:
        return ""
    return " ".join(value.split()) if isinstance(value, str) else json.dumps(value, ensure_ascii=False)


def from_cell(text: str) -> Any:
    if text == "":
        return None
    if text in ("TRUE", "FALSE"):  # as spreadsheets write them
        return text == "TRUE"
    try:
        return json.loads(text)
    except ValueError:
        return text


def to_line(cells: Sequence[str]) -> str:
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerow(cells)
    return out.getvalue()


def read_rows(file: Path) -> list[dict[str, Any]]:
    """The rows of a Parquet file, or of a CSV file, without a last one that was not written to its end. Raises MissingExtra."""
    if file.suffix == ".parquet":
        rows = require("parquet", "a file of type Parquet", "pyarrow.parquet").read_table(file).to_pylist()
        return [{name: from_cell(value) if isinstance(value, str) else value for name, value in row.items()} for row in rows]
    table = read_csv(file, whole=True)
    return [{name: from_cell(cell) for name, cell in zip(table.names, row)} for row in table.cells]


def differences(before: Any, now: Any, field: str = "") -> list[str]:
    """FIELD: got …, expected … of whatever differs."""
    if isinstance(before, dict) and isinstance(now, dict):
        names = [*before, *(name for name in now if name not in before)]
        return [line for name in names for line in differences(before.get(name), now.get(name), f"{field}.{name}" if field else name)]
    return [] if before == now else [f"{field}: got {_short(now)}, expected {_short(before)}"]


def _short(value: Any, limit: int = 80) -> str:
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= limit else text[: limit - 1] + "…"


class Table:
    """Rows in `file` (CSV; Parquet is written of them at the end), what they are rows of beside it in `file`.json."""

    def __init__(self, file: Path, columns: Sequence[str], spec: dict[str, Any]) -> None:
        """Raises InvalidInput: cannot be written, holds the rows of something else, or is being written."""
        require_folder(file)
        self._file, self._columns, self._spec = file, list(columns), spec
        self._pyarrow = require("parquet", "a file of type Parquet", "pyarrow.parquet") if file.suffix == ".parquet" else None
        self._rows_file = file.with_suffix(".csv") if self._pyarrow else file
        self._spec_file = file.with_name(file.name + ".json")
        there = self._rows_file.exists() and self._rows_file.stat().st_size > 0
        if there:
            self._require_same(spec)
        else:
            write_whole(self._spec_file, lambda to: to.write_text(json.dumps(spec, ensure_ascii=False, indent=1) + "\n", encoding="utf-8"))
        self._out = self._open()
        self.rows: list[dict[str, Any]] = self._go_on() if there else []
        if not there:
            self._write(self._columns)

    def _open(self) -> TextIO:
        try:
            out = self._rows_file.open("a", encoding="utf-8", newline="")
            fcntl.flock(out, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InvalidInput(f"{self._file}: got a file that another sweep is writing, expected one of its own") from None
        except OSError as error:
            raise InvalidInput(f"{self._file}: cannot be written ({error.strerror})") from None
        return out

    def _require_same(self, spec: dict[str, Any]) -> None:
        try:
            before = json.loads(self._spec_file.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            raise InvalidInput(f"{self._file}: got rows without a readable {self._spec_file.name}, expected another file") from None
        if found := differences(before, json.loads(json.dumps(spec))):
            raise InvalidInput(f"{self._file}: holds the rows of another sweep: {'; '.join(found)}; the same sweep goes on here, this one needs a file of its own")

    def _go_on(self) -> list[dict[str, Any]]:
        """The rows that are there. A row that was cut off goes, and a table that another program has written is written anew."""
        names = read_csv(self._rows_file, whole=True).names
        if names != self._columns and names:  # else its line of names was cut off
            raise InvalidInput(f"{self._rows_file}: got other columns, expected {', '.join(self._columns)}")
        rows = read_rows(self._rows_file)
        text = "".join(map(to_line, [self._columns, *([to_cell(row[name]) for name in self._columns] for row in rows)]))
        if self._rows_file.read_bytes() != text.encode():
            write_whole(self._rows_file, lambda to: to.write_text(text, encoding="utf-8"))
            self._out.close()
            self._out = self._open()
        return rows

    def _write(self, cells: Sequence[str]) -> None:
        self._out.write(to_line(cells))
        self._out.flush()

    def add(self, rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
        """Writes rows. Returns them as they are kept, with every column."""
        for row in rows:
            if unknown := set(row) - set(self._columns):
                raise ValueError(f"columns: a row has {', '.join(sorted(unknown))} as well")
            cells = [to_cell(row.get(name)) for name in self._columns]
            self.rows.append({name: from_cell(cell) for name, cell in zip(self._columns, cells)})
            self._write(cells)
        return self.rows[len(self.rows) - len(rows) :]

    def close(self) -> None:
        self._out.close()
        if parquet := self._pyarrow:
            import pyarrow

            columns = {name: [_flat(row[name]) for row in self.rows] for name in self._columns}
            write_whole(self._file, lambda to: parquet.write_table(pyarrow.table(columns), to))


def _flat(value: Any) -> Any:
    return json.dumps(value, ensure_ascii=False) if isinstance(value, (dict, list)) else value
