"""Sentences of the prose pages, and how long they are. Code, tables, headings, formulas and the targets of links are left out."""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

LONGEST = 35  # words of one sentence
AVERAGE = 25  # words of the sentences of one page


class Sentence(NamedTuple):
    line: int  # on which the sentence begins, from 1
    words: int
    text: str


# A word is a formula if it holds one of these, or is a number, or a single letter that is no English word.
MATHS = re.compile(r"[=<>≤≥≈≠±·×÷∈∉⊖⊕∘√∂∇‖|^_+−∞→⟂∀∃α-ωΑ-Ω²³¹⁰-⁹₀-₉⁺⁻ᵀᵃᵘ∑∏∫ℝ°%]|^[-(\[]*\d[\d.,:/]*[)\],;]*$|^[(\[]*[B-HJ-Zb-z][)\],;']*$")
PLACE = "\u27e8maths\u27e9"
ABBREVIATIONS = ("e.g.", "i.e.", "eq.", "eqs.", "fig.", "figs.", "sec.", "al.", "cf.", "vs.", "ch.", "no.", "approx.")


def _without_markup(line: str) -> str:
    line = re.sub(r"`` .+? ``|`[^`]*`", " CODE ", line)  # one word
    line = re.sub(r"!\[[^\]]*\]\([^)]*\)", " ", line)  # pictures
    line = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", line)  # links keep their text
    line = re.sub(r"\$[^$]+\$", " CODE ", line)
    line = re.sub(r"<https?:[^>]*>|https?://\S+", " CODE ", line)
    return re.sub(r"\*\*|<[^>]*>", "", line).replace("*", "")


def _blocks(text: str) -> list[list[tuple[int, str]]]:
    """Paragraphs and items of lists as lines with their numbers. A formula that stands by itself continues a sentence that it interrupts."""
    text = re.sub(r"^```.*?^```|<!--.*?-->", lambda match: "\n" * match.group(0).count("\n"), text, flags=re.DOTALL | re.MULTILINE)
    blocks: list[list[tuple[int, str]]] = []
    current: list[tuple[int, str]] = []
    formula = False  # the last thing was a formula
    item = False  # the last block was an item of a list

    def close() -> None:
        nonlocal current
        if current:
            blocks.append(current)
        current = []

    blank = True
    for number, line in enumerate(text.splitlines(), start=1):
        if not line.strip():
            blank = True
        elif line.startswith(("|", "#", "---", "![")) or re.match(r"\s*<[^>]*>\s*$", line):
            close()
            formula = item = False
            blank = True
        elif line.startswith("    ") and (formula or (blank and not item)):
            if current and not formula:
                current.append((number, PLACE))
            formula = True
            blank = False
        else:
            starts_item = re.match(r"\s*(?:[-*+]|\d+\.)\s", line)
            inside = formula and _unfinished([line for _, line in current if line != PLACE])
            if starts_item or (blank and not formula) or (formula and not inside):
                close()
                item = bool(starts_item)
            current.append((number, re.sub(r"^\s*(?:[-*+]|\d+\.|>)\s+", "", line)))
            formula = blank = False
    close()
    return blocks


def _unfinished(lines: list[str]) -> bool:
    """Whether the sentence of these lines goes on behind the formula that follows them."""
    return bool(lines) and not re.search(r"[.!?:][)*_\"”]*$", lines[-1].rstrip())


def sentences(text: str) -> list[Sentence]:
    found = []
    for block in _blocks(text):
        words = [(number, word) for number, line in _joined(block) for word in _without_markup(line).split()]
        current: list[tuple[int, str]] = []
        for index, (number, word) in enumerate(words):
            current.append((number, word))
            following = words[index + 1][1] if index + 1 < len(words) else ""
            ends = re.search(r"[.!?][)\]\"'”]*$", word) and word.lower().lstrip("([") not in ABBREVIATIONS
            if re.match(r"[A-Z]\.$", word) and (following.startswith("Pang") or all(re.match(r"[A-Z]\.$", before) for _, before in current)):
                ends = None  # initials of a name
            if word == PLACE and not re.match(r"[a-z]{2}|a$|[(\[,;–]", following):
                ends = True  # the formula ended the sentence
            if not following or (ends and not re.match(r"[a-z]{2}|a$", following)):
                found.append(Sentence(current[0][0], _count([word for _, word in current]), " ".join(word for _, word in current)))
                current = []
    return [sentence for sentence in found if sentence.words > 0]


def _joined(block: list[tuple[int, str]]) -> list[tuple[int, str]]:
    """Code and links may run over the end of a line: those lines become one."""
    joined: list[tuple[int, str]] = []
    for number, line in block:
        before = joined[-1][1] if joined else ""
        if before.count("`") % 2 or before.rfind("[") > before.rfind("]") or before.rfind("](") > before.rfind(")"):
            joined[-1] = (joined[-1][0], f"{before} {line}")
        else:
            joined.append((number, line))
    return joined


def _count(words: list[str]) -> int:
    """Neighbours that are parts of a formula count as one word."""
    count = 0
    before = False
    for word in words:
        maths = word == PLACE or bool(MATHS.search(word))
        if re.search(r"\w", word) or maths:
            count += not (maths and before)
        before = maths
    return count


def faults(page: Path, name: str) -> list[str]:
    """One line for each sentence that is too long, and one if the page as a whole is."""
    found = sentences(page.read_text(encoding="utf-8"))
    lines = [f"{name}:{sentence.line}: {sentence.words} words (at most {LONGEST}): {sentence.text}" for sentence in found if sentence.words > LONGEST]
    average = sum(sentence.words for sentence in found) / max(1, len(found))
    if average > AVERAGE:
        lines.append(f"{name}: {average:.1f} words a sentence on average (at most {AVERAGE})")
    return lines


def count_words(page: Path) -> int:
    """Words of the prose of a page, without tables, code and formulas."""
    return sum(sentence.words for sentence in sentences(page.read_text(encoding="utf-8")))
