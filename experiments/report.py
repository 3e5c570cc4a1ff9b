"""What an experiment hands back, and the pages made of it."""

from __future__ import annotations

import base64
import csv
import html
import io
import json
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.figure import Figure  # noqa: E402

plt.rcParams.update(
    {
        "svg.fonttype": "none",  # text stays text: small files
        "svg.hashsalt": "stiction",  # the same picture gives the same bytes
        "font.size": 9,
        "axes.grid": True,
        "grid.alpha": 0.3,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "legend.frameon": False,
        "figure.constrained_layout.use": True,
        "path.simplify_threshold": 0.5,
    }
)


@dataclass
class Row:
    """One number of the thesis beside ours. `passed` is None where there is nothing to judge."""

    quantity: str
    thesis: str
    ours: str
    passed: bool | None = None
    note: str = ""


@dataclass
class Picture:
    name: str
    svg: str
    caption: str


@dataclass
class Result:
    text: str
    rows: list[Row] = field(default_factory=list)
    pictures: list[Picture] = field(default_factory=list)
    data: dict[str, Mapping[str, Sequence[float] | np.ndarray]] = field(default_factory=dict)  # file → columns
    settings: dict[str, Any] = field(default_factory=dict)

    @property
    def passed(self) -> bool:
        return all(row.passed is not False for row in self.rows)

    def add(self, quantity: str, thesis: str, ours: str, passed: bool | None = None, note: str = "") -> None:
        self.rows.append(Row(quantity, thesis, ours, None if passed is None else bool(passed), note))

    def draw(self, name: str, figure: Figure, caption: str) -> None:
        self.pictures.append(Picture(name, to_svg(figure), caption))


@dataclass
class Done:
    """A finished experiment."""

    name: str
    title: str
    result: Result
    wall_s: float


def to_svg(figure: Figure) -> str:
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", bbox_inches="tight", metadata={"Date": None, "Creator": None})
    plt.close(figure)
    return smaller(buffer.getvalue())


def smaller(svg: str) -> str:
    """The same picture with tenths of a point, one name of a font, and without remarks."""
    for pattern, replacement in (
        (r"<!--.*?-->|<metadata>.*?</metadata>", ""),
        (r"font-family: [^;\"]*sans-serif", "font-family: sans-serif"),
        (r' transform="rotate\(-0 [^)]*\)"', ""),
        (r"\s*\n\s*", " "),
        (r"> <", ">\n<"),
    ):
        svg = re.sub(pattern, replacement, svg, flags=re.DOTALL)
    # Marks of one line share their style; those of the axes have it already.
    svg = re.sub(r'(<use [^>]*) style="stroke: #000000; stroke-width: 0\.\d+"/>', r"\1/>", svg)
    marks = r'<g (clip-path="[^"]*")>((?:\s*<use [^>]* style="([^"]*)"/>)+)\s*</g>'
    svg = re.sub(marks, lambda m: f'<g {m[1]} style="{m[3]}">' + re.sub(r' style="[^"]*"/>', "/>", m[2]) + "</g>", svg)
    # Only inside of tags: labels keep their digits.
    return re.sub(r"<[^>]*>", lambda tag: re.sub(r"(\d+\.\d)\d+", r"\1", tag.group()), svg)


def number(value: float) -> str:
    """Four digits, or what else there is to say."""
    if math.isnan(value):
        return "–"
    return f"{value:.4g}"


# ---- files


def write_text(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.tmp")
    temporary.write_text(text, encoding="utf-8")
    temporary.replace(path)


def write_data(folder: Path, done: Done) -> None:
    for name, columns in done.result.data.items():
        buffer = io.StringIO()
        writer = csv.writer(buffer, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows([f"{value:.10g}" for value in row] for row in zip(*columns.values(), strict=True))
        write_text(folder / done.name / f"{name}.csv", buffer.getvalue())
    for picture in done.result.pictures:
        write_text(folder / done.name / f"{picture.name}.svg", picture.svg)


def to_json(experiments: Sequence[Done], version: str, quick: bool) -> str:
    passed = all(done.result.passed for done in experiments)
    return json.dumps(
        {
            "format": "stiction-reproduction",
            "format_version": 1,
            "status": "Done" if passed else "CheckFailed",
            "code_version": version,
            "quick": quick,
            "wall_s": round(sum(done.wall_s for done in experiments), 3),
            "experiments": [
                {
                    "name": done.name,
                    "title": done.title,
                    "passed": done.result.passed,
                    "wall_s": round(done.wall_s, 3),
                    "settings": done.result.settings,
                    "rows": [vars(row) for row in done.result.rows],
                    "files": [f"{done.name}/{name}.csv" for name in done.result.data]
                    + [f"{done.name}/{picture.name}.svg" for picture in done.result.pictures],
                }
                for done in experiments
            ],
        },
        indent=1,
        ensure_ascii=False,
    )


VERDICT = {True: "✓", False: "✗", None: ""}

STYLE = """body{font:15px/1.5 system-ui,sans-serif;max-width:62rem;margin:2rem auto;padding:0 1rem;color:#222}
table{border-collapse:collapse;margin:1rem 0}td,th{border-bottom:1px solid #ddd;padding:.25rem .7rem;text-align:left;vertical-align:top}
figure{margin:1rem 0}figcaption{color:#555;font-size:.9em}img{max-width:100%}.no{color:#b00;font-weight:bold}code{background:#f3f3f3}"""


def to_html(experiments: Sequence[Done], version: str, quick: bool) -> str:
    """One page with everything in it."""
    parts = [f"<!doctype html><html lang=en><meta charset=utf-8><title>stiction: thesis | ours</title><style>{STYLE}</style>"]
    parts.append(f"<h1>Thesis | ours</h1><p>stiction {html.escape(version)}{', quick mode' if quick else ''}</p>")
    for done in experiments:
        parts.append(f"<h2>{html.escape(done.title)}</h2><p><code>stiction reproduce {done.name}</code>, {done.wall_s:.1f} s</p>")
        parts += [f"<p>{html.escape(paragraph).replace(chr(10), '<br>')}</p>" for paragraph in done.result.text.strip().split("\n\n")]
        parts.append("<table><tr><th>quantity<th>thesis<th>ours<th><th>")
        for row in done.result.rows:
            cells = "".join(f"<td>{html.escape(cell)}" for cell in (row.quantity, row.thesis, row.ours))
            parts.append(f"<tr>{cells}<td class={'no' if row.passed is False else 'yes'}>{VERDICT[row.passed]}<td>{html.escape(row.note)}")
        parts.append("</table>")
        for picture in done.result.pictures:
            code = base64.b64encode(picture.svg.encode()).decode()
            parts.append(f"<figure><img alt='{html.escape(picture.name)}' src='data:image/svg+xml;base64,{code}'>")
            parts.append(f"<figcaption>{html.escape(picture.caption)}</figcaption></figure>")
    return "\n".join(parts) + "\n"


def to_markdown(experiments: Sequence[Done], heading: str, pictures: str) -> str:
    """A page of the documentation; pictures lie in the folder `pictures` beside it."""

    def cell(text: str) -> str:
        return text.replace("|", "\\|")

    parts = [heading.strip()]
    for done in experiments:
        parts.append(f"## {done.title}\n\n    build/release/stiction reproduce {done.name}\n\n{done.result.text.strip()}")
        if done.result.rows:
            table = ["| quantity | thesis | ours | | |", "|---|---|---|---|---|"]
            for row in done.result.rows:
                cells = (row.quantity, row.thesis, row.ours, VERDICT[row.passed], row.note)
                table.append("| " + " | ".join(map(cell, cells)) + " |")
            parts.append("\n".join(table))
        parts += [f"![{p.caption}]({pictures}/{done.name}-{p.name}.svg)\n\n*{p.caption}*" for p in done.result.pictures]
    return "\n\n".join(parts) + "\n"


def with_sections(page: str, newer: str) -> str:
    """The page with the sections of a newer one in place of those made by the same command; what it did not have comes at its end."""

    def split(text: str) -> tuple[str, dict[str, str]]:
        head, *sections = re.split(r"^(?=## )", text, flags=re.MULTILINE)
        return head.strip(), {re.search(r"^    (build/\S+ reproduce \S+)$", section, flags=re.MULTILINE)[1]: section.strip() for section in sections}

    (head, sections), (_, replacing) = split(page), split(newer)
    return "\n\n".join([head, *(sections | replacing).values()]) + "\n"
