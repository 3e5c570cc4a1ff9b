"""Figures that experiments make for the page: another program on its own scenes (peer_comfree.py), and goals in a row (goals_in_row.py)."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ._benchmark_failures import number, table

FILE = Path(__file__).with_name("benchmark_peers.json")
ROWS = Path(__file__).with_name("benchmark_rows.json")
Peers = Mapping[str, Any]


def load_peers(file: Path = FILE) -> Peers | None:
    """None: there are no figures."""
    return json.loads(file.read_text(encoding="utf-8")) if file.exists() else None


def write_peers(peers: Peers) -> list[str]:
    """A section of the page."""
    lines = ["## Beside another program", "", *peers["about"], "", "```text", peers["command"], "```", ""]
    head = ["scene", "program", "starts and goals", "their test", "5° and 10 mm", "held", "median time [s]", "processor s per s"]
    lines += table(head, (_line(row) for row in peers["rows"]))
    return [*lines, *peers["notes"], "", "The conditions differ:", "", *(f"* {text}" for text in peers["differs"]), ""]


def _line(row: Mapping[str, Any]) -> list[str]:
    shares = (f"{row[name]} of {row['n']}" for name in ("theirs", "ours"))
    held = "" if row["held"] is None else f"{row['held']} of {row['n']}"
    return [row["scene"], row["program"], str(row["n"]), *shares, held, number(row["median_s"], 1), number(row["processor_per_s"], 2)]


def write_rows(figures: Peers) -> list[str]:
    """Another section: goals in a row."""
    lines = ["## Goals in a row", "", *figures["about"], "This command makes the table:", "", "```text", figures["command"], "```", ""]
    head = ["scene", "program", "runs", "goals reached", "median of a run", "least", "most", "fell", "median way [s]", "processor s per s"]
    lines += table(head, (_row_line(row) for row in figures["rows"]))
    return [*lines, *figures["notes"], "", "The conditions:", "", *(f"* {text}" for text in figures["differs"]), ""]


def _row_line(row: Mapping[str, Any]) -> list[str]:
    counts = (str(row[name]) for name in ("n", "goals", "median", "least", "most", "dropped"))
    return [row["scene"], row["program"], *counts, number(row["median_s"], 1), number(row["processor_per_s"], 2)]
