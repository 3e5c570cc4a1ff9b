#!/usr/bin/env python3
"""Writes tasks/schema/planner.schema.json and docs/options.md from the table of options that the program reads tasks with (src/stiction/tasks/option_table.cpp).

    scripts/options.py [--check]        --check writes nothing; exit code 1 when a file is not what it should be
"""

import argparse
import json
import pathlib
import sys

import stiction

ROOT = pathlib.Path(__file__).resolve().parent.parent
HEAD = """# Options of the planner

A task needs none of these options. They stand in the section `planner` of a task file; in Python they have the same names, as in
`st.plan(task, options={"margins": True, "goal_bias": 0.2})`. Everything else that the planner needs follows from sizes, weights and springs of the scene
([scales](theory/scales.md)). A plan file lists the options that were used. Numbers such as (3.5) and Alg. 2 are those of the thesis.
`scripts/options.py` writes this page.

"""
FOOT = """
Files of version 0.2 may have other options, for example `substep`, `gamma`, `trees` or `brace_force`, and a map `advanced`. The program names and ignores
them, because the planner sets them from the scene. `single_step`, `real_regrasps` and `scheme` are refused: the map `thesis` stands for them.
"""


def table(properties):
    rows = [f"| `{name}` | {value['description']} |" for name, value in properties.items()]
    return "\n".join(["| option | what it is |", "|---|---|", *rows]) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true")
    arguments = parser.parse_args()
    schema = stiction.planner_schema()
    options = schema["properties"]
    page = HEAD + table(options) + FOOT
    files = {ROOT / "tasks/schema/planner.schema.json": json.dumps(schema, indent=2, ensure_ascii=False) + "\n", ROOT / "docs/options.md": page}
    wrong = [file for file, text in files.items() if not file.exists() or file.read_text() != text]
    if arguments.check:
        for file in wrong:
            print(f"{file.relative_to(ROOT)} is not what the table of options gives: run scripts/options.py", file=sys.stderr)
        return bool(wrong)
    for file in wrong:
        file.write_text(files[file])
    return False


if __name__ == "__main__":
    sys.exit(main())
