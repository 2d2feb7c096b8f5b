"""COLLADA: the scene of a document with every instance's transform applied.

Own reading on lxml rather than pycollada: that rounds to single precision, lets entities
expand, and drops what it does not know. Its answers serve as an oracle in the tests.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, cast

import numpy as np

from assetpipe import secure_xml
from assetpipe.errors import InputError, LimitError, Location
from assetpipe.geometry.formats.dae_geometry import Document, child, children, local, surface
from assetpipe.geometry.formats.raw import Axis, FileLimits, Part, RawMesh, floats, joined
from assetpipe.geometry.mesh import FloatArray
from assetpipe.geometry.products import composed, length

if TYPE_CHECKING:
    from lxml.etree import _Element as Element

_PYCOLLADA_DATE = re.compile(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{6}")


def looks_like(data: bytes) -> bool:
    """Whether the text has a COLLADA root element near its beginning."""
    head = data[:4096].replace(b"\0", b"")
    return b"<COLLADA" in head


def read(data: bytes, path: Path, limits: FileLimits) -> RawMesh:
    """Read a COLLADA document.

    Raises:
        InputError: with the line: not well formed, entities, broken or cyclic references,
            content that cannot be read.
        LimitError: more nodes, vertices or triangles than allowed, instances counted each.
    """
    root = secure_xml.parse(data, path)
    if local(root) != "COLLADA":
        raise InputError(
            f"root element is <{local(root)}>, not <COLLADA>",
            location=Location(path, cast("int | None", root.sourceline)),
        )
    document = Document.of(root, path, limits)
    scene = _Scene(document)
    for node, matrix in _roots(document, root, scene.notes):
        scene.add(node, matrix)
    scene.notes += document.notes
    whole = joined(scene.parts)
    metres, axis, habit = _asset(document, root)
    return RawMesh(
        whole.vertices, whole.faces, metres, axis, habit, tuple(dict.fromkeys(scene.notes))
    )


def _roots(document: Document, root: Element, notes: list[str]) -> list[tuple[Element, FloatArray]]:
    """The nodes of the document's scene; without a scene, all of its geometries."""
    scenes = [s for lib in children(root, "library_visual_scenes") for s in lib]
    scenes = [s for s in scenes if local(s) == "visual_scene"]
    entry = child(root, "scene")
    instance = child(entry, "instance_visual_scene") if entry is not None else None
    if instance is not None:
        chosen = document.target(instance, "url", "visual_scene")
    elif len(scenes) == 1:
        chosen = scenes[0]
        notes.append("no <scene>: its only visual scene was taken")
    elif not scenes:
        notes.append("no visual scene: all geometries were taken as they are")
        geometries = [g for lib in children(root, "library_geometries") for g in lib]
        return [(g, np.eye(4)) for g in geometries if local(g) == "geometry"]
    else:
        raise InputError(
            f"{len(scenes)} visual scenes and none instantiated", location=document.at(root)
        )
    return [(node, np.eye(4)) for node in children(chosen, "node")]


class _Scene:
    """Collects the placed surfaces of a walk over nodes."""

    def __init__(self, document: Document) -> None:
        self.parts: list[Part] = []
        self.notes: list[str] = []
        self._document = document
        self._known: dict[Element, Part] = {}
        self._nodes = 0
        self._vertices = 0
        self._faces = 0

    def add(self, element: Element, above: FloatArray) -> None:
        """Place a node or geometry and everything under it."""
        nowhere: frozenset[Element] = frozenset()
        stack = [(element, above, nowhere)]
        while stack:
            node, matrix, within = stack.pop()
            self._nodes += 1
            self._document.limits.check("nodes", self._nodes, self._document.file)
            if local(node) == "geometry":
                self._place(node, matrix)
                continue
            if node in within:
                raise InputError("node contains itself", location=self._document.at(node))
            if len(within) >= self._document.limits.max_depth:
                raise LimitError(
                    f"nodes nest deeper than {self._document.limits.max_depth}",
                    location=self._document.at(node),
                )
            inside = within | {node}
            own = composed(matrix, _transform(self._document, node))
            below = [pair for part in node for pair in self._below(part, own)]
            stack.extend((part, m, inside) for part, m in reversed(below))

    def _below(self, part: Element, own: FloatArray) -> list[tuple[Element, FloatArray]]:
        kind = local(part)
        if kind == "node":
            return [(part, own)]
        if kind == "instance_node":
            return [(self._document.target(part, "url", "node"), own)]
        if kind == "instance_geometry":
            return [(self._document.target(part, "url", "geometry"), own)]
        if kind == "instance_controller":
            return [self._skin(self._document.target(part, "url", "controller"), own)]
        return []

    def _skin(self, controller: Element, own: FloatArray) -> tuple[Element, FloatArray]:
        """A skinned mesh as it was bound: its joints stay where they are."""
        skin = child(controller, "skin")
        if skin is None:
            raise InputError(
                "controller that is no skin is unsupported", location=self._document.at(controller)
            )
        self.notes.append("skinned mesh taken in its bind pose")
        bind = child(skin, "bind_shape_matrix")
        matrix = np.eye(4) if bind is None else _matrix(self._document, bind)
        return self._document.target(skin, "source", "geometry"), composed(own, matrix)

    def _place(self, geometry: Element, matrix: FloatArray) -> None:
        if geometry not in self._known:
            self._known[geometry], notes = surface(self._document, geometry)
            self.notes.extend(notes)
        part = self._known[geometry]
        self._vertices += len(part.vertices)
        self._faces += len(part.faces)
        self._document.limits.check("vertices", self._vertices, self._document.file)
        self._document.limits.check("faces", self._faces, self._document.file)
        self.parts.append(part.placed(matrix))


def _values(document: Document, element: Element, count: int) -> FloatArray:
    values = floats(element.text, local(element), document.at(element))
    if len(values) != count:
        raise InputError(
            f"<{local(element)}> has {len(values)} numbers instead of {count}",
            location=document.at(element),
        )
    return values.astype(np.float64)


def _matrix(document: Document, element: Element) -> FloatArray:
    return _values(document, element, 16).reshape(4, 4)


def _transform(document: Document, node: Element) -> FloatArray:
    """A node's transform elements, applied in the order in which they stand (§5 node)."""
    result = np.eye(4)
    for element in node:
        kind = local(element)
        step = np.eye(4)
        if kind == "matrix":
            step = _matrix(document, element)
        elif kind == "translate":
            step[:3, 3] = _values(document, element, 3)
        elif kind == "scale":
            step[:3, :3] = np.diag(_values(document, element, 3))
        elif kind == "rotate":
            step[:3, :3] = _rotation(_values(document, element, 4))
        elif kind == "lookat":
            step = _looking(_values(document, element, 9))
        elif kind == "skew":
            raise InputError("<skew> is unsupported", location=document.at(element))
        else:
            continue
        result = composed(result, step)
    return result


def _rotation(values: FloatArray) -> FloatArray:
    """Axis and angle in degrees to a matrix (Rodrigues)."""
    size = length(values[:3])
    if size == 0.0:
        return np.eye(3)
    x, y, z = values[:3] / size
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    angle = np.deg2rad(values[3])
    across = composed(cross, cross)
    result: FloatArray = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * across
    return result


def _looking(values: FloatArray) -> FloatArray:
    """Eye, interest and up to a matrix: the node's -z looks at the interest."""
    eye, interest, up = values.reshape(3, 3)
    back = eye - interest
    right = np.cross(up, back)
    back = back / length(back)
    right = right / length(right)
    result = np.eye(4)
    result[:3, :4] = np.stack([right, np.cross(back, right), back, eye], axis=1)
    return result


def _asset(document: Document, root: Element) -> tuple[float, Axis, str | None]:
    """Metres in a unit, the declared up-axis, and who declares it out of habit."""
    asset = child(root, "asset")
    if asset is None:
        return 1.0, "Z_UP", None
    unit = child(asset, "unit")
    metres = 1.0
    if unit is not None and unit.get("meter") is not None:
        text = unit.get("meter", "")
        found = floats(text, "unit meter", document.at(unit))
        if len(found) != 1 or not 0.0 < found[0] < np.inf:
            raise InputError(f"unit of '{text[:40]}' metres", location=document.at(unit))
        metres = float(found[0])
    # the specification's default is Y_UP, but a file that says nothing claims nothing
    up = child(asset, "up_axis")
    declared = (up.text or "").strip() if up is not None else "Z_UP"
    if declared not in ("X_UP", "Y_UP", "Z_UP"):
        location = document.at(up) if up is not None else document.at(asset)
        raise InputError(
            f"up_axis '{declared[:40]}' is none of X_UP, Y_UP, Z_UP", location=location
        )
    return metres, cast("Axis", declared), _habit(asset)


def _habit(asset: Element) -> str | None:
    """MeshLab (VCGLib) and pycollada (also trimesh) write Y_UP always."""
    tools = [
        (tool.text or "")
        for contributor in children(asset, "contributor")
        for tool in children(contributor, "authoring_tool")
    ]
    if any("VCGLib" in tool or "MeshLab" in tool for tool in tools):
        return "MeshLab"
    created = child(asset, "created")
    plain = {local(element) for element in asset} <= {"created", "modified", "up_axis"}
    if plain and created is not None and _PYCOLLADA_DATE.fullmatch((created.text or "").strip()):
        return "pycollada"
    return None
