"""Strangers' text on a terminal: neither its markup nor its control characters count."""

from __future__ import annotations

from rich import markup

from assetpipe.errors import printable


def escape(text: str) -> str:
    """Text to be printed by rich as it reads."""
    return markup.escape(printable(text))
