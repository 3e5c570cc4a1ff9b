"""Fields for the options of the planner, made from their table (docs/options.md)."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import stiction as st


@dataclass(frozen=True)
class Field:
    """One option. `kind`: "bool", "int", "number", "choice", or "json" for whatever has parts; "json" also where it may be left out."""

    name: str
    meaning: str
    kind: str
    choices: tuple[str, ...] = ()
    low: float | None = None
    high: float | None = None

    def read(self, text: Any) -> Any:
        """The value of what was put into the field. Raises ValueError."""
        if self.kind == "json":
            return None if not str(text).strip() else json.loads(text)
        return text

    def write(self, value: Any) -> Any:
        """What stands in the field for a value."""
        return ("" if value is None else json.dumps(value)) if self.kind == "json" else value


@cache
def tasks_folder() -> Path:
    """Of the built-in tasks and of the schemas beside them."""
    return Path(st.load_task(min(st.list_tasks(), key=len)).file).parent


@cache
def _schema(name: str) -> dict[str, Any]:
    return json.loads((tasks_folder() / "schema" / name).read_text(encoding="utf-8"))


def _resolve(entry: dict[str, Any]) -> dict[str, Any]:
    """The entry without a reference to another schema and without null."""
    while True:
        if "$ref" in entry:
            file, path = entry["$ref"].split("#/")
            target: Any = _schema(file)
            for key in path.split("/"):
                target = target[key]
            entry = {**target, **{k: v for k, v in entry.items() if k != "$ref"}}
        elif "anyOf" in entry and len(some := [e for e in entry["anyOf"] if e != {"type": "null"}]) == 1:
            entry = {**some[0], **{k: v for k, v in entry.items() if k != "anyOf"}}
        else:
            return entry


def _field(name: str, entry: dict[str, Any], value: Any) -> Field:
    entry = _resolve(entry)
    low = entry.get("minimum", entry.get("exclusiveMinimum"))
    kind = {"boolean": "bool", "integer": "int", "number": "number"}.get(str(entry.get("type")), "json")
    if "enum" in entry:
        kind = "choice"
    fits = {"bool": bool, "int": int, "number": (int, float), "choice": str}.get(kind, object)
    if not isinstance(value, fits):  # left out: no value of that kind stands for it
        kind = "json"
    return Field(name, entry.get("description", ""), kind, tuple(entry.get("enum", ())), low, entry.get("maximum"))


def fields(options: st.PlannerOptions) -> list[Field]:
    """One per option that has a place in the form. Seed and threads have places of their own, and trees of the thesis none."""
    schema: dict[str, Any] = dict(st.planner_schema())["properties"]  # type: ignore[assignment]
    values = options.to_dict()
    own = ("seed", "threads", "thesis")
    return [_field(name, entry, values.get(name)) for name, entry in schema.items() if name not in own]


def changed(given: st.PlannerOptions, values: dict[str, Any]) -> dict[str, Any]:
    """What differs from the options of the task, after the reader of options took it. Raises stiction.InvalidInput."""
    before = given.to_dict()
    out = {name: value for name, value in values.items() if value != before.get(name)}
    given.replace(**out)
    return out
