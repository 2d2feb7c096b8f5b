"""Decompositions in files: hulls, certificates and every coarser level.

The format is described in ``docs/decomposition_file.md``; it holds numbers only, and
everything is checked on reading, for a file may come from a stranger.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from assetpipe.decomposition.certificate import Certificate, Interval
from assetpipe.decomposition.decomposition import (
    Coverage,
    Decomposition,
    EngineName,
    Node,
    RepairRecord,
)
from assetpipe.decomposition.hull import Hull
from assetpipe.decomposition.params import Metric
from assetpipe.decomposition.primitives import Kind, Primitive
from assetpipe.decomposition.reach import Closing
from assetpipe.decomposition.seams import Seams
from assetpipe.decomposition.tolerance import Tolerance
from assetpipe.errors import InputError, LimitError, Location, MeshError
from assetpipe.geometry.mesh import Mesh

KIND = b"assetpipe decomposition "
VERSION = b"1"
MAX_BYTES = 256 * 2**20
"""What is read of a stranger's file, as of a mesh file."""

_DIGEST = 64

Length = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
Bounds = tuple[Length, Length]
Count = Annotated[int, Field(ge=0)]


class _Record(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)


class _Coverage(_Record):
    proof: Literal["construction", "sample"]
    uncovered: Length
    samples: Count


class _Tolerance(_Record):
    value: Annotated[float, Field(gt=0.0)]
    unit: Literal["metres", "relative", "coacd"]


class _Closing(_Record):
    reach: Length
    pockets: Count
    volume: Length
    spacing: Length


class _Seams(_Record):
    overlap: Length
    widened: Count
    open: Count


Coordinate = Annotated[float, Field(allow_inf_nan=False)]
Row = tuple[Coordinate, Coordinate, Coordinate, Coordinate]


class _Primitive(_Record):
    kind: Kind
    frame: tuple[Row, Row, Row, Row]
    size: Annotated[tuple[Length, ...], Field(min_length=1, max_length=3)]


class _Node(_Record):
    vertices: Annotated[int, Field(ge=4, le=2**31 - 1)]
    faces: Annotated[int, Field(ge=4, le=2**31 - 1)]
    thickening: Bounds
    concavity: Bounds | None
    volume: Length
    primitive: _Primitive | None
    children: tuple[Count, Count] | None


class _Head(_Record):
    engine: EngineName
    tolerance: _Tolerance
    epsilon: Annotated[float, Field(gt=0.0)]
    metric: Metric
    coverage: _Coverage
    repair: dict[str, Any] | None
    closed: _Closing | None
    seams: _Seams | None
    hierarchy: Literal["complete", "none"]
    level: tuple[Count, ...]
    nodes: tuple[_Node, ...]


def save(decomposition: Decomposition, path: str | os.PathLike[str]) -> None:
    """Write a decomposition with all its levels; equal values give equal bytes.

    The file appears whole or not at all.

    Raises:
        InputError: the place cannot be written to.
    """
    target = Path(path)
    data = encode(decomposition)
    part = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        with open(part, "xb") as file:
            file.write(data)
        os.replace(part, target)
    except OSError as error:
        raise InputError(
            f"cannot be written: {error.strerror}", location=Location(target)
        ) from error
    finally:
        part.unlink(missing_ok=True)


def load(path: str | os.PathLike[str]) -> Decomposition:
    """Read what :func:`save` wrote.

    Structure, counts, digest and finiteness are checked. That the numbers are true is
    not: :func:`assetpipe.decomposition.certify` proves hulls of any origin anew.

    Raises:
        InputError: unreadable, not such a file, of another version, damaged or
            inconsistent; says where.
        LimitError: larger than 256 MiB.
    """
    place = Path(path)
    location = Location(place)
    try:
        with open(place, "rb") as file:
            data = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", location=location) from error
    if len(data) > MAX_BYTES:
        raise LimitError(f"larger than {MAX_BYTES} bytes", location=location)
    try:
        return decode(data)
    except InputError as error:
        raise InputError(error.message, location=location) from error


def encode(decomposition: Decomposition) -> bytes:
    """The bytes of the file."""
    nodes = decomposition.nodes or tuple(Node(hull, None) for hull in decomposition.hulls)
    position = {id(node.hull): index for index, node in enumerate(nodes)}
    certificates = [node.hull.certificate for node in nodes]
    head = _Head(
        engine=decomposition.engine,
        tolerance=_Tolerance(
            value=decomposition.tolerance.value, unit=decomposition.tolerance.unit
        ),
        epsilon=decomposition.epsilon,
        metric=decomposition.metric,
        coverage=_Coverage(
            proof=decomposition.coverage.proof,
            uncovered=decomposition.coverage.uncovered,
            samples=decomposition.coverage.samples,
        ),
        repair=decomposition.repair.as_dict() if decomposition.repair else None,
        closed=_Closing(**decomposition.closed.as_dict()) if decomposition.closed else None,
        seams=_Seams(**decomposition.seams.as_dict()) if decomposition.seams else None,
        hierarchy="complete" if decomposition.nodes else "none",
        level=tuple(position[id(hull)] for hull in decomposition.hulls),
        nodes=tuple(
            _Node(
                vertices=len(node.hull.vertices),
                faces=len(node.hull.faces),
                thickening=(proved.thickening.lower, proved.thickening.upper),
                concavity=(proved.concavity.lower, proved.concavity.upper)
                if proved.concavity
                else None,
                volume=node.hull.volume,
                primitive=_primitive_record(node.hull.primitive),
                children=node.children,
            )
            for node, proved in zip(nodes, certificates, strict=True)
        ),
    )
    text = json.dumps(head.model_dump(), sort_keys=True, separators=(",", ":"), allow_nan=False)
    parts = [text.encode(), b"\n"]
    for node in nodes:
        parts.append(node.hull.vertices.astype("<f8").tobytes())
        parts.append(node.hull.faces.astype("<i4").tobytes())
    body = b"".join(parts)
    digest = hashlib.sha256(body).hexdigest().encode()
    return KIND + VERSION + b"\n" + digest + b"\n" + body


def decode(data: bytes) -> Decomposition:
    """A decomposition from the bytes of a file.

    Raises:
        InputError: as :func:`load`, without the file.
    """
    head, arrays = _opened(data)
    _check_tree(head)
    nodes = tuple(
        Node(hull, record.children)
        for hull, record in zip(_hulls(head.nodes, arrays), head.nodes, strict=True)
    )
    closed, seams, cover = head.closed, head.seams, head.coverage
    return Decomposition(
        tuple(nodes[index].hull for index in head.level),
        Coverage(cover.proof, cover.uncovered, cover.samples),
        head.engine,
        Tolerance(head.tolerance.value, head.tolerance.unit),
        head.epsilon,
        head.metric,
        RepairRecord(head.repair) if head.repair is not None else None,
        nodes if head.hierarchy == "complete" else (),
        closed=Closing(closed.reach, closed.pockets, closed.volume, closed.spacing)
        if closed
        else None,
        seams=Seams(seams.overlap, seams.widened, seams.open) if seams else None,
    )


def _opened(data: bytes) -> tuple[_Head, memoryview]:
    """The head, and the bytes behind it."""
    first, _, rest = data.partition(b"\n")
    if not first.startswith(KIND):
        raise InputError("is no decomposition of assetpipe: it does not begin like one")
    version = first[len(KIND) :]
    if version != VERSION:
        shown = version[:20].decode("ascii", "replace")
        raise InputError(
            f"is of version '{shown}' of the format; this assetpipe reads {VERSION.decode()}"
        )
    digest, body = rest[:_DIGEST], rest[_DIGEST + 1 :]
    if rest[_DIGEST : _DIGEST + 1] != b"\n" or (
        hashlib.sha256(body).hexdigest().encode() != digest
    ):
        raise InputError("is damaged: its digest is another one")
    line, separator, _ = body.partition(b"\n")
    if not separator:
        raise InputError("head: has no end")
    try:
        head = _Head.model_validate_json(line)
    except ValidationError as error:
        wrong = error.errors(include_url=False, include_input=False)[0]
        where = ".".join(str(step) for step in wrong["loc"])
        raise InputError(f"head{': ' if where else ''}{where}: {wrong['msg']}") from error
    return head, memoryview(body)[len(line) + 1 :]


def _check_tree(head: _Head) -> None:
    """Children come before their parents, nobody has two; the level covers every leaf once."""
    used: set[int] = set()
    for index, node in enumerate(head.nodes):
        for name, bounds in (("thickening", node.thickening), ("concavity", node.concavity)):
            if bounds is not None and bounds[0] > bounds[1]:
                raise InputError(f"nodes.{index}.{name}: its lower end is above the upper one")
        if node.children is None:
            continue
        a, b = node.children
        if not (a < index and b < index and a != b):
            raise InputError(f"nodes.{index}.children: [{a}, {b}] are not two earlier nodes")
        for child in (a, b):
            if child in used:
                raise InputError(f"nodes.{index}.children: {child} has a parent already")
            used.add(child)
    below: set[int] = set()
    for place, index in enumerate(head.level):
        if index >= len(head.nodes):
            raise InputError(f"level.{place}: there is no node {index}")
        stack = [index]
        while stack:
            node_below = stack.pop()
            if node_below in below:
                raise InputError(f"level.{place}: node {index} covers what another one does")
            below.add(node_below)
            stack.extend(head.nodes[node_below].children or ())
    for index, node in enumerate(head.nodes):
        if node.children is None and index not in below:
            raise InputError(f"level: leaf {index} is not covered")


def _hulls(records: Sequence[_Node], arrays: memoryview) -> Iterator[Hull]:
    """Hulls from the arrays, which must be exactly as long as the head says."""
    size = sum(24 * record.vertices + 12 * record.faces for record in records)
    if size != len(arrays):
        raise InputError(f"arrays: {len(arrays)} bytes, but the head tells of {size}")
    at = 0
    for index, record in enumerate(records):
        n, m = record.vertices, record.faces
        vertices = np.frombuffer(arrays, "<f8", 3 * n, at).reshape(n, 3)
        faces = np.frombuffer(arrays, "<i4", 3 * m, at + 24 * n).reshape(m, 3)
        at += 24 * n + 12 * m
        try:
            mesh = Mesh(vertices, faces.astype(np.int64))
        except MeshError as error:
            raise InputError(f"nodes.{index}: {error.message}") from error
        yield Hull(
            mesh.vertices,
            mesh.faces,
            record.volume,
            Certificate(
                Interval(*record.thickening),
                Interval(*record.concavity) if record.concavity else None,
            ),
            _primitive(record.primitive, index),
        )


def _primitive_record(shape: Primitive | None) -> _Primitive | None:
    if shape is None:
        return None
    x, y, z, w = (tuple(float(v) for v in row) for row in shape.frame)
    return _Primitive(kind=shape.kind, frame=(x, y, z, w), size=shape.size)  # type: ignore[arg-type]


_SIZES: dict[Kind, int] = {"box": 3, "cylinder": 2, "capsule": 2, "sphere": 1}


def _primitive(record: _Primitive | None, node: int) -> Primitive | None:
    if record is None:
        return None
    if len(record.size) != _SIZES[record.kind]:
        raise InputError(
            f"nodes.{node}.primitive: a {record.kind} has {_SIZES[record.kind]} sizes, "
            f"not {len(record.size)}"
        )
    return Primitive(record.kind, np.array(record.frame, dtype=np.float64), record.size)
