"""glTF 2.0 and GLB: the triangles of the default scene with every node's transform applied.

Own reading, because trimesh ignores sparse accessors and triangle fans, puts zeros for
compressed geometry that it cannot decode and trusts counts. Materials, cameras, skins and
animations don't matter to a shape and are not looked at.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from assetpipe.errors import LimitError, Location
from assetpipe.geometry.formats.gltf_buffers import Gltf
from assetpipe.geometry.formats.polygons import fan_triangles, strip_triangles
from assetpipe.geometry.formats.raw import FileLimits, Part, RawMesh, joined
from assetpipe.geometry.mesh import FloatArray, IntArray
from assetpipe.geometry.products import composed, length

_DECODED_NOWHERE = {
    "KHR_draco_mesh_compression": "Draco compression",
    "EXT_meshopt_compression": "meshopt compression",
    "KHR_meshopt_compression": "meshopt compression",
}


def looks_like(data: bytes) -> bool:
    """Whether the data are a GLB or begin like the JSON of a glTF."""
    if data[:4] == b"glTF":
        return True
    head = data[: 1 << 16].lstrip(b"\xef\xbb\xbf \t\r\n")
    return head.startswith(b"{") and b'"asset"' in data


def read(data: bytes, path: Path, limits: FileLimits) -> RawMesh:
    """Read a GLB or glTF; its buffers must lie in its folder or below.

    Raises:
        InputError: broken JSON, accessors beyond their buffers, cycles, compression.
        LimitError: more bytes, nodes, vertices or triangles than allowed.
    """
    document = Gltf.load(data, path, limits)
    required = document.tree.get("extensionsRequired", [])
    for name, what in _DECODED_NOWHERE.items():
        if isinstance(required, list) and name in required:
            raise document.wrong(f"{what} is unsupported")
    notes: list[str] = []
    whole = joined(_Walk(document, limits, notes).parts())
    generator = str(document.mapping(document.tree, "asset").get("generator", ""))
    habit = "trimesh" if "mikedh/trimesh" in generator else None
    return RawMesh(whole.vertices, whole.faces, 1.0, "Y_UP", habit, tuple(dict.fromkeys(notes)))


class _Walk:
    """Places the meshes of a scene's nodes."""

    def __init__(self, document: Gltf, limits: FileLimits, notes: list[str]) -> None:
        self._document = document
        self._limits = limits
        self._notes = notes
        self._known: dict[tuple[int, int], Part | None] = {}

    def parts(self) -> list[Part]:
        """All parts of the scene in order."""
        document, limits = self._document, self._limits
        found: list[Part] = []
        vertices = faces = nodes = 0
        stack = [(index, np.eye(4), frozenset[int]()) for index in reversed(self._roots())]
        while stack:
            index, above, within = stack.pop()
            node = document.item("nodes", index)
            nodes += 1
            limits.check("nodes", nodes, document.path)
            if index in within:
                raise document.wrong(f"node {index} contains itself")
            if len(within) >= limits.max_depth:
                raise LimitError(
                    f"nodes nest deeper than {limits.max_depth}", location=Location(document.path)
                )
            matrix = composed(above, self._matrix(node))
            # Counted one by one: many primitives may name the same large accessor.
            for part in self._mesh(node["mesh"]) if "mesh" in node else ():
                vertices += len(part.vertices)
                faces += len(part.faces)
                limits.check("vertices", vertices, document.path)
                limits.check("faces", faces, document.path)
                found.append(part.placed(matrix))
            inside = within | {index}
            stack.extend((i, matrix, inside) for i in reversed(self._indices(node, "children")))
        return found

    def _roots(self) -> list[int]:
        document = self._document
        scenes = document.items("scenes")
        if scenes:
            return self._indices(document.item("scenes", document.tree.get("scene", 0)), "nodes")
        self._notes.append("no scene: all root nodes were taken")
        below = {
            child for node in document.items("nodes") for child in self._indices(node, "children")
        }
        return [k for k in range(len(document.items("nodes"))) if k not in below]

    def _indices(self, owner: dict[str, Any], name: str) -> list[int]:
        value = owner.get(name, [])
        if not isinstance(value, list) or not all(type(v) is int for v in value):
            raise self._document.wrong(f"'{name}' is no list of indices")
        return value

    def _matrix(self, node: dict[str, Any]) -> FloatArray:
        """The node's matrix, or translation · rotation · scale (§3.5.3)."""
        if "matrix" in node:
            columns = self._numbers(node, "matrix", 16).reshape(4, 4)
            return np.ascontiguousarray(columns.T)
        result = np.eye(4)
        if "rotation" in node:
            result[:3, :3] = _rotation(self._numbers(node, "rotation", 4))
        if "scale" in node:
            result[:3, :3] = result[:3, :3] * self._numbers(node, "scale", 3)
        if "translation" in node:
            result[:3, 3] = self._numbers(node, "translation", 3)
        return result

    def _numbers(self, node: dict[str, Any], name: str, count: int) -> FloatArray:
        value = node[name]
        plain = isinstance(value, list) and all(type(v) in (int, float) for v in value)
        if not plain or len(value) != count:
            raise self._document.wrong(f"node {name} is not {count} numbers")
        try:
            return np.array(value, dtype=np.float64)
        except OverflowError:
            raise self._document.wrong(f"node {name} holds a number out of range") from None

    def _mesh(self, index: object) -> Iterator[Part]:
        mesh = self._document.item("meshes", index)
        key = int(index) if isinstance(index, int) else -1
        primitives = mesh.get("primitives", [])
        if not isinstance(primitives, list) or not all(isinstance(p, dict) for p in primitives):
            raise self._document.wrong(f"mesh {key} has unreadable primitives")
        for k, primitive in enumerate(primitives):
            if (key, k) not in self._known:
                self._known[key, k] = self._primitive(primitive, key)
            part = self._known[key, k]
            if part is not None:
                yield part

    def _primitive(self, primitive: dict[str, Any], mesh: int) -> Part | None:
        document = self._document
        mode = primitive.get("mode", 4)
        if mode in (0, 1, 2, 3):
            self._notes.append(f"points or lines in mesh {mesh} ignored")
            return None
        for name in document.mapping(primitive, "extensions"):
            if name in _DECODED_NOWHERE:
                raise document.wrong(f"mesh {mesh}: {_DECODED_NOWHERE[name]} is unsupported")
        if "targets" in primitive:
            self._notes.append(f"morph targets of mesh {mesh} ignored")
        position = document.mapping(primitive, "attributes").get("POSITION")
        vertices = document.accessor(position)
        if vertices.shape[1] != 3:
            raise document.wrong(f"mesh {mesh}: positions with {vertices.shape[1]} components")
        if "indices" in primitive:
            found = document.accessor(primitive["indices"])
            if found.dtype != np.int64 or found.shape[1] != 1:
                raise document.wrong(f"mesh {mesh}: indices are no whole numbers")
            corners = found[:, 0].astype(np.int64)
        else:
            corners = np.arange(len(vertices), dtype=np.int64)
        if len(corners) and (corners.min() < 0 or corners.max() >= len(vertices)):
            raise document.wrong(
                f"mesh {mesh} names vertex {int(corners.max())}, but has {len(vertices):,}"
            )
        return Part(vertices.astype(np.float64), self._triangles(mode, corners, mesh))

    def _triangles(self, mode: object, corners: IntArray, mesh: int) -> IntArray:
        if mode == 4:
            if len(corners) % 3:
                raise self._document.wrong(
                    f"mesh {mesh}: {len(corners):,} corners are no multiple of 3"
                )
            return corners.reshape(-1, 3)
        if mode == 5:
            return strip_triangles(corners)
        if mode == 6:
            return fan_triangles(corners)
        raise self._document.wrong(f"mesh {mesh}: unknown mode {str(mode)[:40]}")


def _rotation(quaternion: FloatArray) -> FloatArray:
    """A quaternion (x, y, z, w) to a matrix."""
    size = length(quaternion)
    if size == 0.0:
        return np.eye(3)
    x, y, z, w = quaternion / size
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
