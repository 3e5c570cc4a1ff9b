#!/usr/bin/env python3
"""Which MJCF files load, as scenes or as robots, what is in them, and why the others do not.

    .venv/bin/python bench/mjcf_scenes.py FOLDER … [--json FILE]

A file is a scene where it has a robot, that is a joint with an actuator; else its trees are loaded as robots. Files of other formats and
fragments of an <include> have another root element and are left out.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "build" / "release" / "python"))

import stiction as st  # noqa: E402


def is_mjcf(file: Path) -> bool:
    return re.search(r"<(\w+)", re.sub(r"<\?.*?\?>|<!--.*?-->", "", file.read_text(errors="replace"), flags=re.S)).group(1) == "mujoco"


def load(file: Path) -> dict:
    """A row: what the file holds, or why it does not load."""
    row = {"file": str(file), "kind": "scene", "joints": 0, "objects": [], "reason": ""}
    for kind, scene in (
        ("scene", {"file": str(file)}),
        ("scene", {"file": str(file), "robot": {"fixed_base": True}}),
        ("robot", {"robots": [{"name": "robot", "mjcf": str(file)}]}),
    ):
        try:
            model = st.load_model(scene)
        except st.InvalidInput as error:
            row["reason"] = row["reason"] or re.sub(r"\s+", " ", str(error)).replace(str(file), file.name)
            continue
        return row | {"kind": kind, "joints": model.n_a, "objects": list(model.object_names), "reason": ""}
    return row


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--json", type=Path, help="rows of all files")
    given = parser.parse_args()
    rows = [load(file) for folder in given.folders for file in sorted(folder.rglob("*.xml")) if is_mjcf(file)]
    loaded = [row for row in rows if not row["reason"]]
    scenes = [row for row in loaded if row["kind"] == "scene"]
    print(f"{len(loaded)} of {len(rows)} files load, {len(scenes)} of them as scenes, {sum(bool(r['objects']) for r in scenes)} with objects")
    for reason, count in Counter(re.sub(r"^\S+: ", "", row["reason"])[:200] for row in rows if row["reason"]).most_common():
        print(f"{count:4}  {reason}")
    if given.json:
        given.json.write_text(json.dumps(rows, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
