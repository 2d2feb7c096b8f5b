"""The mesh value that every room passes on."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from assetpipe.errors import LimitError, MeshError
from assetpipe.geometry.products import length, moved, products
from assetpipe.geometry.strays import referenced

if TYPE_CHECKING:
    import trimesh

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]


LARGEST = 1e60
"""Metres; and its inverse is the smallest: cubes and squares of areas stay numbers."""


def locked(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Make an array read-only and return it."""
    array.setflags(write=False)
    return array


@dataclass(frozen=True, eq=False)
class Mesh:
    """A triangle mesh: locked arrays in one frame, metres.

    Attributes:
        vertices: (n, 3) float64, metres.
        faces: (m, 3) int64 indices, counter-clockwise seen from outside.

    Raises:
        MeshError: wrong shapes, indices out of range, or values not finite.
    """

    vertices: FloatArray
    faces: IntArray

    def __post_init__(self) -> None:
        try:
            vertices = np.array(self.vertices, dtype=np.float64, order="C", ndmin=2)
            faces = np.array(self.faces, order="C", ndmin=2)
        except (TypeError, ValueError) as error:
            raise MeshError(f"vertices and faces must be arrays of numbers: {error}") from error
        if vertices.size == 0:
            vertices = vertices.reshape(0, 3)
        if faces.size == 0:
            faces = faces.reshape(0, 3).astype(np.int64)
        if vertices.ndim != 2 or vertices.shape[1] != 3:
            raise MeshError(f"vertices must have shape (n, 3), not {vertices.shape}")
        if faces.ndim != 2 or faces.shape[1] != 3:
            raise MeshError(f"faces must have shape (m, 3), not {faces.shape}")
        if not np.issubdtype(faces.dtype, np.integer):
            raise MeshError(f"faces must be integers, not {faces.dtype}")
        faces = faces.astype(np.int64)
        bad = np.flatnonzero(~np.isfinite(vertices).all(axis=1))
        if bad.size:
            raise MeshError(f"vertex {bad[0]} is not finite ({bad.size} such vertices)")
        if faces.size and (faces.min() < 0 or faces.max() >= len(vertices)):
            wrong = int(np.flatnonzero(((faces < 0) | (faces >= len(vertices))).any(axis=1))[0])
            raise MeshError(
                f"face {wrong} names vertex {faces[wrong].tolist()}, "
                f"but the mesh has vertices 0 … {len(vertices) - 1}"
            )
        object.__setattr__(self, "vertices", locked(vertices))
        object.__setattr__(self, "faces", locked(faces))

    @classmethod
    def of(cls, source: Mesh | trimesh.Trimesh | tuple[Any, Any]) -> Mesh:
        """A mesh from a Mesh, a ``trimesh.Trimesh`` or a ``(vertices, faces)`` pair."""
        if isinstance(source, Mesh):
            return source
        if isinstance(source, tuple | list) and len(source) == 2:
            return cls(source[0], source[1])
        if hasattr(source, "vertices") and hasattr(source, "faces"):
            return cls(np.asarray(source.vertices), np.asarray(source.faces))
        raise MeshError(
            "a mesh must be an assetpipe.Mesh, a trimesh.Trimesh or a pair "
            f"(vertices, faces), not {type(source).__name__}"
        )

    @cached_property
    def bounds(self) -> FloatArray:
        """(2, 3) smallest and largest corner of the faces (of the points, if there are none),
        metres."""
        points = referenced(self.vertices, self.faces)[0] if len(self.faces) else self.vertices
        if not len(points):
            return locked(np.zeros((2, 3)))
        return locked(np.stack([points.min(axis=0), points.max(axis=0)]))

    def without_strays(self) -> Mesh:
        """The mesh without vertices that no face uses; itself if there are none.

        The other vertices keep their order and their bits.
        """
        vertices, faces = referenced(self.vertices, self.faces)
        return self if vertices is self.vertices else Mesh(vertices, faces)

    def check_size(self) -> None:
        """See whether areas, volumes and their products can be computed.

        Raises:
            LimitError: coordinates beyond :data:`LARGEST`, or all below its inverse.
        """
        size = float(np.abs(self.bounds).max()) if len(self.vertices) else 0.0
        if size > LARGEST or 0.0 < size < 1.0 / LARGEST:
            raise LimitError(
                f"coordinates of the mesh are up to {size:g} m; volumes can be computed from "
                f"{1.0 / LARGEST:g} m to {LARGEST:g} m"
            )

    @cached_property
    def diagonal(self) -> float:
        """Length of the bounding box's diagonal, metres."""
        return length(self.bounds[1] - self.bounds[0])

    @cached_property
    def volume(self) -> float:
        """Signed volume, m³; meaningful for closed meshes."""
        if not len(self.faces):
            return 0.0
        centre = self.bounds.mean(axis=0)
        a, b, c = (self.vertices[self.faces[:, k]] - centre for k in range(3))
        return float(products(a, np.cross(b, c)).sum() / 6.0)

    @cached_property
    def area(self) -> float:
        """Surface area, m²."""
        if not len(self.faces):
            return 0.0
        a, b, c = (self.vertices[self.faces[:, k]] for k in range(3))
        return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2.0)

    @cached_property
    def digest(self) -> str:
        """SHA-256 over the arrays' bytes, in hex: equal meshes, equal digests."""
        state = hashlib.sha256()
        for array in (self.vertices, self.faces):
            state.update(np.asarray(array.shape, dtype="<i8").tobytes())
            state.update(
                np.ascontiguousarray(array.astype(array.dtype.newbyteorder("<"))).tobytes()
            )
        return state.hexdigest()

    def transformed(self, matrix: npt.ArrayLike) -> Mesh:
        """The mesh under a (4, 4) affine matrix.

        A mirroring matrix (negative determinant) also flips the winding, so that
        faces stay outward.
        """
        m = np.asarray(matrix, dtype=np.float64)
        faces = self.faces[:, ::-1] if np.linalg.det(m[:3, :3]) < 0 else self.faces
        return Mesh(moved(self.vertices, m), faces)

    def scaled(self, factors: npt.ArrayLike) -> Mesh:
        """The mesh scaled along x, y, z; a mirroring scale flips the winding."""
        f = np.broadcast_to(np.asarray(factors, dtype=np.float64), (3,))
        faces = self.faces[:, ::-1] if np.prod(np.sign(f)) < 0 else self.faces
        return Mesh(self.vertices * f, faces)

    def to_trimesh(self) -> trimesh.Trimesh:
        """A ``trimesh.Trimesh`` copy, not processed."""
        import trimesh  # slow to import

        return trimesh.Trimesh(self.vertices.copy(), self.faces.copy(), process=False)
