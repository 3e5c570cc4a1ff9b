#!/usr/bin/env python3
"""Runs the code cells of a notebook as Python, without Jupyter, and says what each shows.

    scripts/notebooks.py NOTEBOOK.ipynb [--json FILE]

A cell shows what it prints and then the value of its last line, as in Jupyter: the page of an object with _repr_html_, else its repr.
It runs in the working folder. Ends with 1 at the first cell that fails.
"""

from __future__ import annotations

import argparse
import ast
import contextlib
import html
import io
import json
import re
import sys
import traceback
from pathlib import Path
from typing import Any


def cells_of(notebook: Path) -> list[tuple[str, str]]:
    """Kind (markdown or code) and text of each cell."""
    document = json.loads(notebook.read_text(encoding="utf-8"))
    return [(cell["cell_type"], "".join(cell["source"])) for cell in document["cells"] if cell["cell_type"] in ("markdown", "code")]


def run_cell(code: str, name: str, variables: dict[str, Any]) -> dict[str, str]:
    """What it prints (text), and the page that it shows (html, or empty)."""
    tree = ast.parse(code, name)
    last = ast.Expression(tree.body.pop().value) if tree.body and isinstance(tree.body[-1], ast.Expr) else None  # type: ignore[attr-defined]
    out, page = io.StringIO(), ""
    with contextlib.redirect_stdout(out):
        exec(compile(tree, name, "exec"), variables)
        value = None if last is None else eval(compile(last, name, "eval"), variables)
        if hasattr(value, "_repr_html_"):
            page = value._repr_html_()
        elif value is not None and not code.rstrip().endswith(";"):  # which hides it, as in Jupyter
            print(repr(value))
    return {"text": out.getvalue(), "html": page}


def run(notebook: Path) -> list[dict[str, str]]:
    """The outputs of the code cells. Raises what a cell raises, with its number in the traceback."""
    variables: dict[str, Any] = {"__name__": "__main__"}
    codes = [text for kind, text in cells_of(notebook) if kind == "code"]
    return [run_cell(code, f"{notebook.name}, cell {k}", variables) for k, code in enumerate(codes, start=1)]


def page_of(shown: str) -> str:
    """The page in a frame of stiction.show(), or what is shown."""
    framed = re.fullmatch(r'<iframe srcdoc="([^"]*)"[^>]*></iframe>', shown)
    return html.unescape(framed.group(1)) if framed else shown


def to_markdown(notebook: Path, outputs: list[dict[str, str]]) -> tuple[str, dict[str, str]]:
    """The notebook as a page, and the pages that it shows by the name of their file."""
    parts, pages, left = [], {}, iter(outputs)
    for kind, text in cells_of(notebook):
        if kind == "markdown":
            parts.append(text)
            continue
        output = next(left)
        parts.append(f"```python\n{text}\n```")
        if output["text"].strip():
            parts.append(f"```text\n{output['text'].rstrip()}\n```")
        if output["html"]:
            name = f"{notebook.stem}_{len(pages) + 1}.html"
            pages[name] = page_of(output["html"])
            parts.append(f'<iframe src="{name}" width="100%" height="500" loading="lazy" style="border:0"></iframe>')
    return "\n\n".join(parts) + "\n", pages


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("notebook", type=Path)
    parser.add_argument("--json", type=Path, metavar="FILE", help="outputs of the cells")
    arguments = parser.parse_args()
    try:
        outputs = run(arguments.notebook)
    except Exception:
        traceback.print_exc()
        return 1
    for k, output in enumerate(outputs, start=1):
        print(f"[{k}]\n{output['text']}", end="" if not output["html"] else f"({len(output['html'])} characters of a page)\n")
    if arguments.json:
        arguments.json.write_text(json.dumps(outputs), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
