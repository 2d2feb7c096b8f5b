"""Exchange pieces of a text and leave every other byte alone."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from xml.sax.saxutils import escape

from assetpipe.robot.markup import Element, tag_end

_ATTRIBUTE = re.compile(rb"(\s+)([^\s=/>\"']+)(\s*=\s*)(\"[^\"]*\"|'[^']*')")


@dataclass(frozen=True)
class Edit:
    """Bytes ``start`` to ``end`` of a text become ``text``; equal offsets insert."""

    start: int
    end: int
    text: bytes


def spliced(text: bytes, edits: Sequence[Edit]) -> bytes:
    """The text with all edits made.

    Raises:
        ValueError: edits that overlap or lie outside of the text.
    """
    parts: list[bytes] = []
    position = 0
    for edit in sorted(edits, key=lambda e: (e.start, e.end)):
        if not position <= edit.start <= edit.end <= len(text):
            raise ValueError(f"edit {edit.start}:{edit.end} overlaps another or the end")
        parts += [text[position : edit.start], edit.text]
        position = edit.end
    return b"".join((*parts, text[position:]))


def value_edit(text: bytes, element: Element, name: str, value: str) -> Edit | None:
    """Give an attribute another value, its quotes kept; ``None`` when it isn't there."""
    match = _attribute(text, element, name)
    if match is None:
        return None
    quote = match[4][:1]
    return Edit(match.start(4) + 1, match.end(4) - 1, attribute_text(value, quote))


def removal_edit(text: bytes, element: Element, name: str) -> Edit | None:
    """Take an attribute out together with the white space before it."""
    match = _attribute(text, element, name)
    return None if match is None else Edit(match.start(), match.end(), b"")


def attribute_text(value: str, quote: bytes) -> bytes:
    """A value as it stands between these quotes."""
    entities = {'"': "&quot;"} if quote == b'"' else {"'": "&apos;"}
    entities |= {"\n": "&#10;", "\r": "&#13;", "\t": "&#9;"}
    return escape(value, entities).encode("utf-8")


def indentation(text: bytes, start: int) -> bytes | None:
    """The white space before an offset if nothing else precedes it on its line."""
    line = max(text.rfind(b"\n", 0, start), text.rfind(b"\r", 0, start)) + 1
    before = text[line:start]
    return before if not before.strip(b" \t") else None


def newline(text: bytes, near: int) -> bytes:
    """The line ending in use just before an offset, or the first one of the text."""
    at = text.rfind(b"\n", 0, near)
    if at < 0:
        at = text.find(b"\n")
    if at < 0:
        return b"\n" if b"\r" not in text else b"\r"
    return b"\r\n" if text[at - 1 : at] == b"\r" and at > 0 else b"\n"


def _attribute(text: bytes, element: Element, name: str) -> re.Match[bytes] | None:
    end = tag_end(text, element.start)
    position = element.start + 1 + len(element.tag.encode("utf-8"))
    wanted = name.encode("utf-8")
    while True:
        match = _ATTRIBUTE.match(text, position, end)
        if match is None or match[2] == wanted:
            return match
        position = match.end()
