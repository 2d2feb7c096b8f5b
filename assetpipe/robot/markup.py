"""XML as a tree that knows where every element stands in the bytes.

Expat gives byte offsets; nothing is ever serialised again, so a writer can exchange single
elements and leave the rest as it is. Namespaces are not interpreted, as in the parsers of
URDF consumers. Common slips of hand-written URDFs that have one reading only are tolerated
and told; everything else that is not well formed is an error with its line.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from assetpipe.errors import InputError, LimitError, Location
from assetpipe.secure_xml import as_utf8, encoding_of

MAX_BYTES = 64 * 1024 * 1024
MAX_ELEMENTS = 1_000_000
MAX_DEPTH = 500

_DECLARATION = re.compile(rb"<\?xml\s[^>]*\?>")
_VERSION = re.compile(rb"^<\?xml\s+version\s*=\s*(?:\"([^\"]*)\"|'([^']*)')")
_LEGIBLE = re.compile(rb"[^\r\n]")
_MISPLACED_DECLARATION = expat.errors.codes[expat.errors.XML_ERROR_MISPLACED_XML_PI]


@dataclass(frozen=True)
class Element:
    """One element.

    Attributes:
        tag: as written, prefix included.
        attributes: decoded values by name.
        children: elements only.
        text: character data directly inside, joined.
        line: of its start tag, 1-based.
        start: byte offset of ``<`` in :attr:`Markup.text`.
        end: byte offset just after its end tag.
        inner_end: byte offset of ``</``, or ``None`` for an empty-element tag.
    """

    tag: str
    attributes: dict[str, str]
    children: tuple[Element, ...]
    text: str
    line: int
    start: int
    end: int
    inner_end: int | None

    def all(self, tag: str) -> tuple[Element, ...]:
        """Direct children with this tag."""
        return tuple(child for child in self.children if child.tag == tag)

    def first(self, tag: str) -> Element | None:
        """The first direct child with this tag."""
        return next((child for child in self.children if child.tag == tag), None)

    def walk(self) -> Iterator[Element]:
        """This element and all below it, in document order."""
        stack = [self]
        while stack:
            element = stack.pop()
            yield element
            stack.extend(reversed(element.children))


@dataclass(frozen=True)
class Slip:
    """A fault in the markup that was read over: a line and a sentence."""

    line: int
    message: str


@dataclass(frozen=True)
class Markup:
    """A document.

    Attributes:
        text: UTF-8 bytes that all offsets point into; the source itself when that is UTF-8.
        encoding: of the source.
        root: its outermost element.
        slips: faults that were read over.
    """

    text: bytes
    encoding: str
    root: Element
    slips: tuple[Slip, ...]

    def of(self, element: Element) -> bytes:
        """An element as it stands in the text."""
        return self.text[element.start : element.end]


def read_markup(source: bytes, file: Path) -> Markup:
    """Parse a document.

    Raises:
        InputError: not well formed beyond tolerance, unknown encoding, or with entity
            declarations; with the line.
        LimitError: larger or deeper than :data:`MAX_BYTES`, :data:`MAX_ELEMENTS` or
            :data:`MAX_DEPTH` allow.
    """
    if len(source) > MAX_BYTES:
        raise LimitError(
            f"{len(source):,} bytes exceed the limit of {MAX_BYTES:,}", location=Location(file)
        )
    text = as_utf8(source, file)
    legible = text
    slips: list[Slip] = []
    while True:
        builder = _Builder(file)
        try:
            root = builder.build(legible)
            break
        except expat.ExpatError as error:
            fixed = _tolerate(legible, error, builder)
            if fixed is None or fixed[0] == legible:
                raise InputError(
                    f"not well-formed XML: {expat.ErrorString(error.code)}",
                    location=Location(file, error.lineno),
                ) from error
            legible, slip = fixed
            slips.append(slip)
    version = _VERSION.match(text.removeprefix(b"\xef\xbb\xbf"))
    number = (version[1] or version[2] or b"").decode("latin-1") if version else "1.0"
    if not re.fullmatch(r"1\.\d+", number):
        slips.append(Slip(1, f"XML version '{number}' does not exist; read as 1.0"))
    return Markup(text, encoding_of(source, file), root, tuple(slips))


class _Open:
    """An element whose end has not come yet."""

    def __init__(self, tag: str, attributes: dict[str, str], line: int, start: int) -> None:
        self.tag = tag
        self.attributes = attributes
        self.line = line
        self.start = start
        self.children: list[Element] = []
        self.text: list[str] = []


@dataclass
class _Builder:
    """Builds the tree from Expat's events."""

    file: Path
    root: Element | None = None
    failed_at: int = 0
    _open: list[_Open] = field(default_factory=list)
    _count: int = 0

    def build(self, text: bytes) -> Element:
        parser = expat.ParserCreate("utf-8")
        parser.buffer_text = True
        self._parser = parser
        self._text = text
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        parser.CharacterDataHandler = self._characters
        parser.StartDoctypeDeclHandler = self._doctype
        parser.SkippedEntityHandler = self._skipped
        try:
            parser.Parse(text, True)
        except expat.ExpatError:
            self.failed_at = parser.ErrorByteIndex
            raise
        if self.root is None:  # pragma: no cover - Expat says "no element found" before
            raise InputError("no element", location=Location(self.file))
        return self.root

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        self._count += 1
        line = self._parser.CurrentLineNumber
        if self._count > MAX_ELEMENTS or len(self._open) >= MAX_DEPTH:
            raise LimitError(
                f"more than {MAX_ELEMENTS:,} elements or {MAX_DEPTH} levels",
                location=Location(self.file, line),
            )
        self._open.append(_Open(tag, attributes, line, self._parser.CurrentByteIndex))

    def _end(self, _tag: str) -> None:
        item = self._open.pop()
        end = tag_end(self._text, item.start)
        inner_end: int | None = None
        # At the end of <a/> Expat already stands on what follows, which may be another "</".
        if not self._text.endswith(b"/>", item.start, end):
            inner_end = self._parser.CurrentByteIndex
            end = self._text.index(b">", inner_end) + 1
        element = Element(
            item.tag,
            item.attributes,
            tuple(item.children),
            "".join(item.text),
            item.line,
            item.start,
            end,
            inner_end,
        )
        if self._open:
            self._open[-1].children.append(element)
        else:
            self.root = element

    def _characters(self, text: str) -> None:
        if self._open:
            self._open[-1].text.append(text)

    def _doctype(self, _n: str, _s: str | None, _p: str | None, has_subset: int) -> None:
        if has_subset:
            raise InputError(
                "document type with declarations refused: entities may be bombs or name files",
                location=Location(self.file, self._parser.CurrentLineNumber),
            )

    def _skipped(self, name: str, _is_parameter: int) -> None:
        raise InputError(
            f"unknown entity '&{name[:40]};'",
            location=Location(self.file, self._parser.CurrentLineNumber),
        )


_TAG = re.compile(rb"<[^\s/>]+(?:[^\"'>]|\"[^\"]*\"|'[^']*')*>")


def tag_end(text: bytes, start: int) -> int:
    """Offset just after the start tag that begins at ``start``; quoted ``>`` don't count."""
    match = _TAG.match(text, start)
    assert match is not None  # noqa: S101 - Expat has accepted the tag
    return match.end()


def _tolerate(text: bytes, error: expat.ExpatError, builder: _Builder) -> tuple[bytes, Slip] | None:
    """The text with the fault blanked out, every byte offset kept; ``None`` beyond tolerance."""
    line, at = error.lineno, builder.failed_at
    if error.code == _MISPLACED_DECLARATION and builder.root is None:
        match = _DECLARATION.search(text, at)
        if match is not None:
            blanked = text[: match.start()] + b" " * len(match[0]) + text[match.end() :]
            return blanked, Slip(line, "XML declaration is not at the very beginning")
    if builder.root is not None and b"<" not in text[builder.root.end :]:
        end = builder.root.end
        return text[:end] + b" " * (len(text) - end), Slip(
            line, "text after the end of the root element"
        )
    legible = _as_legible(text)
    if legible != text:
        return legible, Slip(line, "bytes that are not UTF-8 (read as '?')")
    opened = text.rfind(b"<!--", 0, at + 4)
    if opened >= 0 and b"-->" not in text[opened:at]:
        return _with_blank_comments(text), Slip(line, "'--' inside of a comment")
    return None


def _as_legible(text: bytes) -> bytes:
    """Bytes that are no UTF-8 and control characters that XML forbids as question marks."""
    decoded = text.decode("utf-8", "surrogateescape")
    return "".join("?" if "\udc80" <= c <= "\udcff" else c for c in decoded).encode("utf-8")


def _with_blank_comments(text: bytes) -> bytes:
    parts, at = [], 0
    # Found one by one: a pattern would look for the end from every beginning that has none.
    while (start := text.find(b"<!--", at)) >= 0 and (end := text.find(b"-->", start + 4)) >= 0:
        parts += [text[at : start + 4], _LEGIBLE.sub(b" ", text[start + 4 : end])]
        at = end
    return b"".join([*parts, text[at:]])
