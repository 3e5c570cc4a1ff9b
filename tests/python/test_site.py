"""What the documentation site is made of and looked at with: the gallery, links, the search of pages that are opened from a folder, figures that are on two pages."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest

import browser

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))

import check_site  # noqa: E402
import gallery  # noqa: E402


def write(folder: Path, name: str, body: str) -> None:
    (folder / name).parent.mkdir(parents=True, exist_ok=True)
    (folder / name).write_text(f"<html><body>{body}</body></html>", encoding="utf-8")


def test_dead_links_are_those_without_a_file_or_a_heading(tmp_path: Path) -> None:
    write(tmp_path, "index.html", '<a href="a/one.html#there">1</a> <a href="https://example.org/x">2</a> <img src="picture.png"> <a href="#top">3</a><h1 id="top">t</h1>')
    write(tmp_path, "a/one.html", '<h2 id="there">1</h2> <a href="../index.html">back</a> <a href="two.html">2</a> <a href="../index.html#nowhere">3</a>')
    (tmp_path / "picture.png").write_bytes(b"x")
    assert check_site.dead_links(tmp_path) == ["a/one.html: ../index.html#nowhere: no such heading", "a/one.html: two.html: no such file"]
    (tmp_path / "picture.png").unlink()
    assert "index.html: picture.png: no such file" in check_site.dead_links(tmp_path)


def test_gallery_has_twelve_built_in_tasks_whose_pictures_open_their_pages() -> None:
    assert len(gallery.TASKS) == 12 and all((ROOT / f"tasks/{task}.yaml").is_file() for task in gallery.TASKS)
    links = re.findall(r'<a href="plans/([a-z0-9_]+)\.html"><img src="plans/([a-z0-9_]+)\.webp" alt="[^"]+"', gallery.markup())
    assert links == [(task, task) for task in gallery.TASKS]
    assert (ROOT / "docs/index.md").read_text(encoding="utf-8").count("<!-- gallery -->") == 1


def test_figures_on_the_page_of_tools_are_those_of_the_benchmark() -> None:
    rows = {cells[0]: cells for line in (ROOT / "docs/benchmark.md").read_text(encoding="utf-8").splitlines() if len(cells := [c.strip() for c in line.strip("|").split("|")]) == 10}
    page = (ROOT / "docs/which_tool.md").read_text(encoding="utf-8")
    _, _, runs, _, planned, _, reached, *_ = rows["all"]
    assert f"plans {planned} of {runs} and reaches {reached} of {runs}" in page
    for name, words in (("pick and place", "Pick and place with a gripper"), ("tools", "Tools"), ("insertion", "Insertion")):
        assert f"{words}: {rows[name][6]} of {rows[name][2]}" in page


def test_benchmark_has_a_picture_of_every_task_and_says_of_each_failure_why() -> None:
    pages = {name: (ROOT / f"docs/{name}.md").read_text(encoding="utf-8") for name in ("benchmark", "benchmark_failures")}
    shown = {name: re.findall(r'<img src="(benchmark_pictures/[\w.]+)"', text) for name, text in pages.items()}
    tasks = re.findall(r"<br>`(\w+)` \|", pages["benchmark"])
    assert shown["benchmark"] == [f"benchmark_pictures/{task}.webp" for task in tasks] and len(tasks) == 89
    files = list((ROOT / "docs/benchmark_pictures").iterdir())
    assert {f"benchmark_pictures/{file.name}" for file in files} == {picture for pictures in shown.values() for picture in pictures}
    assert sum(file.stat().st_size for file in files) < 2_500_000
    told = re.findall(r"^## (\w+)$", pages["benchmark_failures"], flags=re.MULTILINE)
    linked = re.findall(r"\(benchmark_failures\.md#(\w+)\)", pages["benchmark"])  # some tasks have a link for their plans and one for their runs
    assert told == list(dict.fromkeys(linked)) and 0 < len(told) < 89


def test_questions_of_the_check_lead_to_pages_that_there_are() -> None:
    assert len(check_site.QUESTIONS) == 10
    assert all((ROOT / f"docs/{page}.md").is_file() for page in check_site.QUESTIONS.values())


@browser.needed
def test_page_from_a_folder_has_a_worker(tmp_path: Path) -> None:
    """Chromium refuses one of its own there; docs/iframe-worker.js stands in, and keeps what is posted before it is ready."""
    (tmp_path / "worker.js").write_text("addEventListener('message', (event) => { importScripts('more.js').then(() => postMessage(event.data + more)) })", encoding="utf-8")
    (tmp_path / "more.js").write_text("self.more = 1", encoding="utf-8")
    shim = (ROOT / "docs/iframe-worker.js").resolve().as_uri()
    write(
        tmp_path,
        "page.html",
        f"<script src='{shim}'></script><script>const worker = new Worker('worker.js'); window.got = []; worker.addEventListener('message', (event) => got.push(event.data)); worker.postMessage(1); worker.postMessage(41)</script>",
    )
    with browser.Browser() as window:
        window.open(tmp_path / "page.html")
        window.wait_for(lambda: window.evaluate("window.got?.length === 2"), 30, "two answers")
        assert window.evaluate("window.got.sort()") == [2, 42] and window.errors == []


@pytest.mark.parametrize("name", ["index.html", "a/index.html"])
def test_link_to_itself_is_none_that_is_dead(tmp_path: Path, name: str) -> None:
    write(tmp_path, name, '<a href="">here</a> <a href="index.html">here</a> <h1 id="x">x</h1> <a href="#x">x</a>')
    assert check_site.dead_links(tmp_path) == []
