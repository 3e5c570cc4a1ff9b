"""Text in the markdown of the page."""

from __future__ import annotations

import re

# A word as code; what starts emphasis, code, markup or an entity, or strikes through; `_` but for those inside of a word; both ends of a picture and the
# middle of a link, which would be fetched.
MARKS = re.compile(r"`[\w.~:/ -]+`|[\\`*<&~]|(?<![^\W_])_|_(?![^\W_])|(?<=!)\[|\](?=[(\[])")
# What makes a line a heading, an item, a quotation, a rule or a part of a table.
BEGINNING = re.compile(r"^([ \t]*|[ \t]*\d{1,9}(?=[.)](?:\s|$)))([-+#>=|:.)])", re.MULTILINE)


def plain(text: str) -> str:
    """Names, descriptions and messages as they are written, but for words as code: the page would carry out what is markup in them."""
    text = MARKS.sub(lambda found: found[0] if len(found[0]) > 1 else "\\" + found[0], text)
    return BEGINNING.sub(r"\1\\\2", text)
