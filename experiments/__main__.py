"""python -m experiments NAME|all [-o DIR] [--quick] [--docs FILE]"""

from __future__ import annotations

import argparse
import importlib
import re
import sys
import time
from pathlib import Path

FOLDER = Path(__file__).resolve().parent

MADE_BY = "Made by `build/release/stiction reproduce all --docs docs/reproduction/{page}`. ✓ marks what was checked and holds."
REMARKS = {"2": "Rows of Drake's SAP\nneed `make experiments`. Figures 2-2 and 2-9 are pictures of systems."}  # by chapter


def names() -> list[str]:
    """Experiments in the order of the thesis: figure_2_13.py is "figure-2.13"."""
    stems = [path.stem for path in FOLDER.glob("*.py") if re.match(r"(figure|table|section|errata)_\d", path.stem)]
    return [name_of(stem) for stem in sorted(stems, key=lambda stem: ([int(n) for n in re.findall(r"\d+", stem)], stem))]


def name_of(stem: str) -> str:
    kind, *numbers = stem.split("_")
    return f"{kind}-{'.'.join(numbers)}"


def main() -> int:
    parser = argparse.ArgumentParser(prog="experiments", description="Figures and tables of the thesis, beside ours.")
    parser.add_argument("name", choices=[*names(), "all"])
    parser.add_argument("-o", "--out", type=Path, default=Path("reproduction"), help="folder for the results")
    parser.add_argument("--quick", action="store_true", help="fewer and coarser points")
    parser.add_argument("--docs", type=Path, help="also write this Markdown page; of one that exists only the sections of NAME")
    arguments = parser.parse_args()
    try:
        arguments.out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        print(f"error: {arguments.out}: cannot be written ({error.strerror})", file=sys.stderr)
        return 2

    import stiction
    from stiction._extras import MissingExtra, require

    try:
        for module in ("matplotlib", "yaml", "pinocchio"):
            require("reproduce", "reproduce", module)
    except MissingExtra as error:
        print(f"stiction: {error}", file=sys.stderr)
        return 70

    from . import report

    experiments = []
    for name in names() if arguments.name == "all" else [arguments.name]:
        module = importlib.import_module("experiments." + re.sub(r"[-.]", "_", name))
        started = time.perf_counter()
        result = module.run(arguments.quick)
        done = report.Done(name, module.TITLE, result, time.perf_counter() - started)
        report.write_data(arguments.out, done)
        experiments.append(done)
        print_rows(done)
        # After each one: an interrupted run leaves what it has.
        report.write_text(arguments.out / "report.json", report.to_json(experiments, stiction.__version__, arguments.quick))
        report.write_text(arguments.out / "report.html", report.to_html(experiments, stiction.__version__, arguments.quick))
    print(f"report  {arguments.out / 'report.html'}")
    if arguments.docs:
        write_docs(arguments.docs, experiments, whole=arguments.name == "all")
    return 0 if all(done.result.passed for done in experiments) else 1


def print_rows(done) -> None:
    verdicts = {True: "ok  ", False: "FAIL", None: "    "}
    print(f"{done.name}: {done.title}  ({done.wall_s:.1f} s)")
    for row in done.result.rows:
        print(f"  {verdicts[row.passed]} {row.quantity}: thesis {row.thesis} | ours {row.ours}" + (f"  ({row.note})" if row.note else ""))


def write_docs(page: Path, experiments: list, whole: bool) -> None:
    """The whole page, or these sections of one that exists. A page chapterN.md takes those of chapter N only."""
    from . import report

    named = re.fullmatch(r"chapter(\d+)", page.stem)
    chapter = named[1] if named else ""
    mine = [done for done in experiments if not chapter or re.search(r"\d+", done.name)[0] == chapter]
    title = f"# Chapter {chapter}, reproduced" if chapter else "# The thesis, reproduced"
    made_by = " ".join(filter(None, [MADE_BY.format(page=page.name), REMARKS.get(chapter)]))
    text = report.to_markdown(mine, f"{title}\n\n{made_by}", page.stem)
    if page.exists() and not whole:
        text = report.with_sections(page.read_text(encoding="utf-8"), text)
    report.write_text(page, text)
    for done in mine:
        for picture in done.result.pictures:
            report.write_text(page.parent / page.stem / f"{done.name}-{picture.name}.svg", picture.svg)


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit(130)
