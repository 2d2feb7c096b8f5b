"""XML from strangers: no entities, no network, no external files, one encoding.

Expat looks at the prolog first, so that a document with entity declarations is refused
before any parser could expand them.
"""

from __future__ import annotations

import codecs
import re
from pathlib import Path
from typing import TYPE_CHECKING
from xml.parsers import expat

from assetpipe.errors import InputError, Location

if TYPE_CHECKING:
    from lxml import etree

_BOMS = (
    (codecs.BOM_UTF8, "utf-8"),
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
_DECLARED = re.compile(
    rb"^\s*<\?xml[^>]*?\bencoding\s*=\s*[\"']([A-Za-z0-9._:-]{1,40})[\"']", re.DOTALL
)
_ENCODINGS = re.compile(
    r"utf-8|utf-(16|32)(-[lb]e)?|ascii|iso8859-\d+|cp\d+|koi8-[rut]|mac-\w+|gb\w+|big5\w*|hz"
    r"|shift_jis\w*|euc_\w+|johab|tis-620|hp-roman8"
)
"""Character sets only: Python also calls things encodings that compress or escape."""


class _PrologOver(Exception):  # noqa: N818 - a signal, no error
    """Raised at the first element."""


def encoding_of(data: bytes, file: Path) -> str:
    """The document's encoding by byte order mark or declaration, ``utf-8`` without.

    Raises:
        InputError: an encoding that is unknown or no character set.
    """
    for bom, name in _BOMS:
        if data.startswith(bom):
            return name
    declared = _DECLARED.match(data[:400])
    if declared is None:
        return "utf-8"
    name = declared[1].decode("ascii")
    try:
        known = codecs.lookup(name).name
    except LookupError:
        known = ""
    if not _ENCODINGS.fullmatch(known):
        raise InputError(f"unknown encoding '{name}'", location=Location(file, 1))
    # the declaration itself was legible as ASCII, so it cannot be UTF-16
    return "utf-8" if known.startswith(("utf-16", "utf-32", "ascii")) else known


def as_utf8(data: bytes, file: Path) -> bytes:
    """The document in UTF-8; the very same bytes where it is already.

    Raises:
        InputError: an unknown encoding, or bytes that don't fit it.
    """
    encoding = encoding_of(data, file)
    if encoding == "utf-8":
        return data
    try:
        return data.decode(encoding).encode("utf-8")
    except UnicodeError as error:
        raise InputError(f"not {encoding} as declared: {error}", location=Location(file)) from error


def refuse_declarations(data: bytes, file: Path) -> None:
    """Refuse a document type with declarations of its own (the door of entity attacks).

    A bare ``<!DOCTYPE name>`` is harmless and ignored. What is no XML passes here: the parser
    proper says so better.

    Args:
        data: UTF-8.
        file: for the message.

    Raises:
        InputError: with the line of the document type.
    """
    parser = expat.ParserCreate("utf-8")
    found: list[int] = []

    def doctype(_name: str, _system: str | None, _public: str | None, has_subset: int) -> None:
        if has_subset:
            found.append(parser.CurrentLineNumber)
            raise _PrologOver

    def element(_name: str, _attributes: list[str]) -> None:
        raise _PrologOver

    parser.ordered_attributes = True
    parser.StartDoctypeDeclHandler = doctype
    parser.StartElementHandler = element
    try:
        for start in range(0, len(data), 1 << 16):
            parser.Parse(data[start : start + (1 << 16)], False)
    except (_PrologOver, expat.ExpatError):
        pass
    if found:
        raise InputError(
            "document type with declarations refused: entities may be bombs or name files",
            location=Location(file, found[0]),
        )


def parse(data: bytes, file: Path) -> etree._Element:
    """The root element of a document; comments and processing instructions left out.

    Raises:
        InputError: not well formed (with the line), or with entity declarations.
    """
    from lxml import etree  # slow to import

    data = as_utf8(data, file)
    refuse_declarations(data, file)
    parser = etree.XMLParser(
        encoding="utf-8",
        resolve_entities=False,
        no_network=True,
        load_dtd=False,
        dtd_validation=False,
        attribute_defaults=False,
        # numbers of a mesh exceed libxml2's cautious 10 MB a text; bombs are out already
        huge_tree=True,
        remove_comments=True,
        remove_pis=True,
    )
    try:
        return etree.fromstring(data, parser)
    except etree.XMLSyntaxError as error:
        line = error.lineno if error.lineno and error.lineno > 0 else None
        raise InputError(
            f"not well-formed XML: {error.msg}", location=Location(file, line)
        ) from error
    except ValueError as error:
        raise InputError(f"not XML: {error}", location=Location(file)) from error
