"""Text in the markdown of the page."""

from __future__ import annotations

import re

# What starts emphasis, code, markup or an entity; and the middle of a link or a picture, which would be fetched.
MARKS = re.compile(r"[\\`*<&]|(?<=!)\[|\](?=[(\[])")


def plain(text: str) -> str:
    """Names, descriptions and messages as they are written: the page would carry out what is markup in them."""
    return MARKS.sub(r"\\\g<0>", text)
