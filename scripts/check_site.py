#!/usr/bin/env python3
"""scripts/check_site.py [FOLDER]: looks at the built site as a visitor does, and says what is wrong.

Every link of every page leads to a file and a heading that are there. Every page opens in Chromium without an error and asks no other machine for anything.
The moving picture of the first page is there within 5 s. The search, without a server, finds an answer page for each of the questions below.
"""

from __future__ import annotations

import sys
import time
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests/python"))
import browser  # noqa: E402

FIRST_PICTURE = 5.0  # [s] after the first page was asked for
PATIENCE = 60  # [s] for a page, on a machine that has much else to do
FIRST = 3  # so many results of the search are looked at
# What people ask, as they would type it, and the page that answers it.
QUESTIONS = {
    "Algorithm 2": "answers",
    "loose release": "answers",
    "add a contact sampler": "answers",
    "at what speed may I play this file": "answers",
    "load my robot and a gripper": "answers",
    "set a goal for a drawer": "answers",
    "which row is used as rest": "answers",
    "exit code 3": "commands",
    "switch a mechanism off": "answers",
    "get a gradient": "answers",
}


class Page(HTMLParser):
    """Links of a page, and what links may lead to in it."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: set[str] = set()
        self.names: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        self.names |= {value for key in ("id", "name") if (value := given.get(key))}
        self.links |= {value for key in ("href", "src") if (value := given.get(key)) and tag not in ("base",)}


def dead_links(site: Path) -> list[str]:
    """Of all pages but those of plans, which have none."""
    pages = {file.resolve(): Page(file.read_text(encoding="utf-8")) for file in site.rglob("*.html") if file.parent.name != "plans"}
    out = []
    for file, page in pages.items():
        if file.name == "404.html":  # its links are from the top of a server
            continue
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (file.parent / unquote(parts.path)).resolve() if parts.path else file
            if not target.exists():
                out.append(f"{file.relative_to(site)}: {link}: no such file")
            elif parts.fragment and target in pages and not parts.fragment.startswith("__") and unquote(parts.fragment) not in pages[target].names:
                out.append(f"{file.relative_to(site)}: {link}: no such heading")
    return sorted(out)


def opened_with_faults(site: Path) -> list[str]:
    """Errors of pages, and addresses of other machines that they ask."""
    out = []
    with browser.Browser() as window:
        for file in sorted(site.rglob("*.html")):
            if file.name == "404.html":
                continue
            window.errors.clear()
            window.requests.clear()
            window.open(file)
            ready = "document.readyState === 'complete' && location.href.startsWith('file:')"
            window.wait_for(lambda: window.evaluate(ready), PATIENCE, f"{file}")
            name = file.relative_to(site)
            out += [f"{name}: {error}" for error in window.errors]
            out += [f"{name}: asks for {address[:100]}" for address in window.requests if not address.startswith(("file:", "data:", "blob:", "about:"))]
    return out


def on_a_desk(window: browser.Browser) -> None:
    """As wide as pages with a field for the search are."""
    window.call("Emulation.setDeviceMetricsOverride", width=1280, height=900, deviceScaleFactor=1, mobile=False)


def seconds_to_first_picture(site: Path) -> float:
    """Until the first picture of the first page is loaded and the page is painted."""
    there = "(() => { const i = document.querySelector('article img'); return !!i && i.complete && i.naturalWidth > 0 && performance.getEntriesByType('paint').length > 0; })()"
    with browser.Browser() as window:
        on_a_desk(window)
        begin = time.monotonic()
        window.open(site / "index.html")
        window.wait_for(lambda: window.evaluate(there), PATIENCE, "the first picture")
        return time.monotonic() - begin


def results_of_search(window: browser.Browser, words: str) -> list[str]:
    """Pages in the order of the search, without their anchors: clicked and typed, as a visitor does."""
    place = window.evaluate("(() => { const r = document.querySelector('.md-search__input').getBoundingClientRect(); return [r.left + r.width / 2, r.top + r.height / 2]; })()")
    for kind in ("mousePressed", "mouseReleased"):
        window.call("Input.dispatchMouseEvent", type=kind, x=place[0], y=place[1], button="left", clickCount=1)
    meta = "document.querySelector('.md-search-result__meta')?.textContent.trim() ?? ''"
    window.wait_for(lambda: "Type to start" in window.evaluate(meta), PATIENCE, "the search to be ready")
    window.call("Input.insertText", text=words)
    window.call("Input.dispatchKeyEvent", type="keyUp", key="a", code="KeyA")
    window.wait_for(lambda: "document" in window.evaluate(meta) or "No matching" in window.evaluate(meta), PATIENCE, f"an answer to {words!r}")
    found = window.evaluate("[...document.querySelectorAll('.md-search-result__link')].map((a) => a.href.split('?')[0].split('#')[0])")
    return list(dict.fromkeys(address.rsplit("/site/", 1)[-1] for address in found))


def unanswered(site: Path) -> list[str]:
    """Questions whose page is not among the first results, and does not say it."""
    out = []
    for words, page in QUESTIONS.items():
        with browser.Browser() as window:
            on_a_desk(window)
            window.open(site / "index.html")
            window.wait_for(lambda: window.evaluate("document.readyState === 'complete'"), PATIENCE, "the first page")
            found = results_of_search(window, words)
            if not any(address.startswith(page) for address in found[:FIRST]):
                out.append(f"search: {words!r}: found {found[:FIRST]}, expected {page} among them")
    return out


def main() -> int:
    site = Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "build/site").resolve()
    faults = dead_links(site) + opened_with_faults(site) + unanswered(site)
    seconds = seconds_to_first_picture(site)
    if seconds > FIRST_PICTURE:
        faults.append(f"index.html: first picture after {seconds:.1f} s, expected {FIRST_PICTURE:g} s at most")
    for fault in faults:
        print(f"check_site: {fault}", file=sys.stderr)
    print(f"check_site: {len(list(site.rglob('*.html')))} pages, {len(faults)} faults, first picture after {seconds:.1f} s")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
