"""Figures of other programs on their own scenes, beside those of `stiction run` (made by experiments/peer_comfree.py)."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ._benchmark_failures import number, table

FILE = Path(__file__).with_name("benchmark_peers.json")
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
