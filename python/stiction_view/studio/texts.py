"""Text in the markdown of the page."""

from __future__ import annotations

import re

# A word as code; what starts emphasis, code, markup or an entity; both ends of a picture and the middle of a link, which would be fetched.
MARKS = re.compile(r"`[\w.~:/ -]+`|[\\`*<&]|(?<=!)\[|\](?=[(\[])")


def plain(text: str) -> str:
    """Names, descriptions and messages as they are written, but for words as code: the page would carry out what is markup in them."""
    return MARKS.sub(lambda found: found[0] if len(found[0]) > 1 else "\\" + found[0], text)
