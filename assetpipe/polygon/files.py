"""Outlines from files: GeoJSON, CSV and SVG paths."""

from __future__ import annotations

import csv
import json
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from assetpipe.errors import InputError, LimitError, Location, UsageError

SUFFIXES = (".geojson", ".csv", ".svg")
"""What can be read."""

_MAX_BYTES = 256 << 20
_MAX_POINTS = 10_000_000
_UNREADABLE = (ArithmeticError, AssertionError, AttributeError, LookupError, TypeError, ValueError)
"""What svg.path raises for paths that it cannot read."""

Rings = tuple[NDArray[np.float64], ...]


@dataclass(frozen=True)
class ReadOutline:
    """An outline from a file: rings of shape (n, 2) under the even-odd rule, in file units.

    Attributes:
        name: what the file calls it, or its number.
        rings: outer boundaries and holes alike.
    """

    name: str
    rings: Rings


def read_outlines(path: Path, *, flatness: float = 1e-3) -> tuple[ReadOutline, ...]:
    """All outlines in a file.

    * GeoJSON: every Polygon and MultiPolygon of the file.
    * CSV: two columns x, y; an optional third one, ``ring``, numbers the rings; without it, an
      empty line begins the next ring. A line of headings is skipped.
    * SVG: every ``<path>``, each an outline of its subpaths, in the path's own coordinates:
      transforms of the document are *not* applied. Curves become chords that leave them by at
      most about ``flatness`` times the path's size.

    Raises:
        InputError: unreadable, or nothing in it.
        LimitError: larger than 256 MB or ten million points.
        UsageError: the suffix is not known, or svg.path is missing for SVG.
    """
    readers = {".geojson": _geojson, ".csv": _csv, ".svg": _svg}
    reader = readers.get(path.suffix.lower())
    if reader is None:
        raise UsageError(f"'{path}' is no outline that can be read; known are {', '.join(readers)}")
    try:
        if path.stat().st_size > _MAX_BYTES:
            raise LimitError("file is larger than 256 MB", location=Location(path))
        data = path.read_bytes()
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", location=Location(path)) from error
    outlines = reader(path, data, flatness)
    if not outlines:
        raise InputError("no polygon in this file", location=Location(path))
    if sum(len(ring) for outline in outlines for ring in outline.rings) > _MAX_POINTS:
        raise LimitError("more than ten million points", location=Location(path))
    for outline in outlines:
        if not all(np.isfinite(ring).all() for ring in outline.rings):
            message = f"outline '{outline.name[:80]}' has a coordinate that is not finite"
            raise InputError(message, location=Location(path))
    return tuple(outlines)


def _geojson(path: Path, data: bytes, _flatness: float) -> list[ReadOutline]:
    try:
        document = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise InputError(f"not JSON: {error}", location=Location(path)) from error
    found: list[ReadOutline] = []
    pending: deque[tuple[Any, str | None]] = deque([(document, None)])
    while pending:
        value, name = pending.popleft()
        if not isinstance(value, dict):
            continue
        kind = value.get("type")
        if kind == "FeatureCollection":
            pending += [(feature, None) for feature in _listed(path, value, "features")]
        elif kind == "Feature":
            properties = value.get("properties")
            named = properties.get("name") if isinstance(properties, dict) else None
            pending.append((value.get("geometry"), str(named) if named is not None else None))
        elif kind == "GeometryCollection":
            pending += [(geometry, name) for geometry in _listed(path, value, "geometries")]
        elif kind in ("Polygon", "MultiPolygon"):
            coordinates: Any = value.get("coordinates")
            try:
                polygons = [coordinates] if kind == "Polygon" else list(coordinates)
                rings = tuple(_ring(path, ring) for rings in polygons for ring in rings)
            except TypeError as error:
                raise InputError(f"bad coordinates: {error}", location=Location(path)) from error
            found.append(ReadOutline(name or str(len(found)), rings))
    return found


def _listed(path: Path, value: dict[str, Any], name: str) -> list[Any]:
    found = value.get(name) or []
    if not isinstance(found, list):
        raise InputError(f"'{name}' is no list", location=Location(path))
    return found


def _csv(path: Path, data: bytes, _flatness: float) -> list[ReadOutline]:
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError("not UTF-8 text", location=Location(path)) from error
    rings: dict[str, list[tuple[float, float]]] = {}
    block = 0
    for line, row in enumerate(_rows(path, text), 1):
        cells = [cell.strip() for cell in row]
        if not any(cells):
            block += 1
            continue
        try:
            x, y = float(cells[0]), float(cells[1])
        except (ValueError, IndexError) as error:
            if line == 1:
                continue
            raise InputError("not two numbers x, y", location=Location(path, line)) from error
        key = cells[2] if len(cells) > 2 else str(block)
        rings.setdefault(key, []).append((x, y))
    read = tuple(_ring(path, ring) for ring in rings.values())
    return [ReadOutline(path.stem, read)] if read else []


def _rows(path: Path, text: str) -> Iterator[list[str]]:
    try:
        yield from csv.reader(text.splitlines())
    except csv.Error as error:
        raise InputError(f"not CSV: {error}", location=Location(path)) from error


def _svg(path: Path, data: bytes, flatness: float) -> list[ReadOutline]:
    from lxml import etree

    try:
        from svg.path import parse_path
    except ImportError as error:
        raise UsageError(
            "SVG needs svg.path, which is not installed: pip install 'assetpipe[polygon]'"
        ) from error
    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False)
    try:
        root = etree.fromstring(data, parser)
    except etree.XMLSyntaxError as error:
        raise InputError(f"not XML: {error}", location=Location(path)) from error
    found: list[ReadOutline] = []
    for element in root.iter("{*}path"):
        line = element.sourceline
        place = Location(path, line if isinstance(line, int) else None)
        try:
            commands = parse_path(element.get("d") or "")
            rings = _subpaths(commands, flatness)
        except _UNREADABLE as error:
            why = str(error) or "commands that cannot stand where they do"
            raise InputError(f"bad path: {why}", location=place) from error
        closed = tuple(ring for ring in rings if len(ring) > 2)
        if closed:
            found.append(ReadOutline(element.get("id") or str(len(found)), closed))
    return found


def _subpaths(commands: Any, flatness: float) -> list[NDArray[np.float64]]:
    """Subpaths as points; a curve in as many chords as its control polygon's length asks for."""
    ends = [p for c in commands for p in (c.start, c.end)]
    size = max((abs(p - ends[0]) for p in ends), default=0.0) or 1.0
    # Lengths are measured by halving until they stay the same to within this.
    error = 1e-3 * max([size, *(_reach(c) for c in commands)])
    rings: list[list[complex]] = []
    for command in commands:
        kind = type(command).__name__
        if kind == "Move" or not rings:
            rings.append([command.end if kind == "Move" else command.start])
        if kind in ("Line", "Close"):
            rings[-1].append(command.end)
        elif kind != "Move":
            # the sagitta of m equal chords falls with 1/m²; an arc of the size of the path
            # needs about sqrt(π² / (8 · flatness)) of them
            share = min(1.0, command.length(error=error) / size)
            m = max(2, int(np.ceil(np.sqrt(10.0 * share / (8.0 * flatness)))))
            rings[-1].extend(command.point(k / m) for k in range(1, m + 1))
    return [np.array([[p.real, p.imag] for p in ring], dtype=np.float64) for ring in rings]


def _reach(command: Any) -> float:
    """How far a curve's control points or radii reach from its start, at most."""
    controls = (getattr(command, name, None) for name in ("control", "control1", "control2"))
    reach = [abs(p - command.start) for p in controls if p is not None]
    return float(max([*reach, abs(getattr(command, "radius", 0.0))]))


def _ring(path: Path, points: Any) -> NDArray[np.float64]:
    try:
        ring = np.array([[float(p[0]), float(p[1])] for p in points], dtype=np.float64)
    except (TypeError, ValueError, IndexError, KeyError, OverflowError) as error:
        raise InputError(f"bad coordinates: {error}", location=Location(path)) from error
    if len(ring) < 3:
        raise InputError(f"a ring of {len(ring)} points", location=Location(path))
    return ring
