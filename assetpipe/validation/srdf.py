"""SRDF: which pairs a planner need not ask, with the reason, patched into what is there."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal
from xml.sax.saxutils import quoteattr

from assetpipe.errors import InputError, Location
from assetpipe.validation.contact.pairs import Pair
from assetpipe.validation.self_collision import SelfCollisions

Reason = Literal["Adjacent", "Always", "Never", "Default"]
"""MoveIt's words: joined by a joint; always touching; never touching when sampled;
touching at home."""

MAX_BYTES = 16 << 20
_END = re.compile(rb"</robot\s*>\s*(?:<!--(?:(?!-->).)*-->\s*)*\Z", re.DOTALL)
"""The root's end tag, and comments after it, each ended once: nothing is tried twice."""


@dataclass(frozen=True)
class DisabledPair:
    """A pair whose collision need not be asked."""

    pair: Pair
    reason: Reason

    @property
    def element(self) -> str:
        """The SRDF element."""
        a, b = self.pair
        return (
            f"<disable_collisions link1={quoteattr(a)} link2={quoteattr(b)} "
            f'reason="{self.reason}"/>'
        )


def disabled_pairs(
    found: SelfCollisions, *, with_geometry: Iterable[str] | None = None
) -> tuple[DisabledPair, ...]:
    """Pairs to disable, from the self-collisions of a robot.

    ``Never`` is written only where at least 1,000 configurations were sampled: fewer say
    too little. A pair that is new after decomposition is never disabled: it is a finding.

    Args:
        found: over sampled configurations, home first.
        with_geometry: links that have collision geometry; others need no entry.
    """
    known = None if with_geometry is None else set(with_geometry)
    pairs: dict[Pair, Reason] = {}
    if found.configurations > 1000:
        pairs |= dict.fromkeys(found.never_before, "Never")
    pairs |= dict.fromkeys(found.home_before, "Default")
    pairs |= dict.fromkeys(found.always_before, "Always")
    pairs |= dict.fromkeys(found.excluded, "Adjacent")
    fresh = {change.pair for change in found.new}
    return tuple(
        DisabledPair(pair, reason)
        for pair, reason in sorted(pairs.items())
        if pair not in fresh and (known is None or set(pair) <= known)
    )


def patch_srdf(source: bytes, pairs: Iterable[DisabledPair], *, path: Path | None = None) -> bytes:
    """Add missing entries to an SRDF; every byte that is there stays.

    Entries that exist, in either order of their links, are left as they are; so are pairs
    that somebody enabled by name (``enable_collisions``).

    Args:
        source: the SRDF.
        pairs: to disable.
        path: for messages.

    Raises:
        InputError: not an SRDF, or larger than 16 MiB.
    """
    from lxml import etree

    where = Location(path) if path is not None else None
    if len(source) > MAX_BYTES:
        raise InputError(f"SRDF is larger than {MAX_BYTES} bytes", location=where)
    parser = etree.XMLParser(
        resolve_entities=False, no_network=True, load_dtd=False, huge_tree=False
    )
    try:
        root = etree.fromstring(source, parser)
    except etree.XMLSyntaxError as error:
        line = Location(path, error.lineno) if path is not None else None
        raise InputError(f"SRDF is not well-formed: {error.msg}", location=line) from error
    if root.tag != "robot":
        raise InputError(f"SRDF's root is '{root.tag}', not 'robot'", location=where)
    there = {
        frozenset((entry.get("link1"), entry.get("link2")))
        for entry in root.iter("disable_collisions", "enable_collisions")
    }
    missing = [p for p in pairs if frozenset(p.pair) not in there]
    if not missing:
        return source
    newline = b"\r\n" if b"\r\n" in source else b"\n"
    codec = root.getroottree().docinfo.encoding or "utf-8"
    lines = [b"    " + p.element.encode(codec, "xmlcharrefreplace") + newline for p in missing]
    end = _END.search(source)
    if end is not None:
        before = source[: end.start()].rstrip(b" \t")
        glue = b"" if before.endswith(b"\n") or not before else newline
        return before + glue + b"".join(lines) + source[len(before) :]
    empty = re.search(rb"<robot\b[^>]*/>", source)
    if empty is None:
        raise InputError("SRDF's closing tag cannot be found", location=where)
    opened = source[empty.start() : empty.end() - 2].rstrip() + b">" + newline
    return source[: empty.start()] + opened + b"".join(lines) + b"</robot>" + source[empty.end() :]


def new_srdf(robot: str, pairs: Iterable[DisabledPair]) -> bytes:
    """An SRDF that holds nothing but the entries."""
    lines = "".join(f"    {p.element}\n" for p in pairs)
    head = '<?xml version="1.0" encoding="utf-8"?>\n'
    return f"{head}<robot name={quoteattr(robot)}>\n{lines}</robot>\n".encode()
