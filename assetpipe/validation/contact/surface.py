"""A closed surface as FCL sees it: yes/no contact and separation, nothing else.

FCL answers some questions well and others badly; what is asked here was measured:

- GJK (any query with ``fcl.Convex`` or ``fcl.Box``) stops at an *absolute* tolerance:
  about 1e-4 in the separation. Shapes of a millimetre get answers wrong by 30%, and
  the second solver (``GST_INDEP``) even a wrong yes/no. Axis-aligned polytopes get
  separations up to 15% too large at any scale, with both solvers.
- Triangle against triangle (``BVHModel`` on both sides) and sphere against triangle
  are closed forms: exact to rounding, but for an absolute 1e-6 in triangle pairs.
- A triangle without area touches spheres that are centimetres away. Such triangles
  are left out; their edges belong to their neighbours as well.

So both sides are triangle meshes or spheres here, in units in which the diagonal is
:data:`UNITS`; ``fcl.Convex`` serves penetration depth only, which nothing else gives.
A mesh is a surface to FCL: a probe wholly inside has no contact and a positive
separation, so every question is paired with an inside test.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from assetpipe.errors import MeshError
from assetpipe.geometry.mesh import FloatArray, IntArray

UNITS = 1000.0
"""Diagonal of the geometry in FCL's units (see the module's text)."""


SLIVER = 1e-9
"""Height over longest edge below which a triangle counts as one without area."""


class ConvexShape(Protocol):
    """Anything with ``vertices`` (k, 3) and outward ``faces`` (f, 3), such as a hull."""

    @property
    def vertices(self) -> FloatArray: ...  # noqa: D102
    @property
    def faces(self) -> IntArray: ...  # noqa: D102


def bvh_geometry(vertices: FloatArray, faces: IntArray) -> Any:
    """An ``fcl.BVHModel`` of a triangle mesh, units as given."""
    import fcl

    if not len(faces):
        raise MeshError("a mesh without faces has no surface to touch")
    points = np.asarray(vertices, dtype=np.float64)
    solid = np.asarray(faces, dtype=np.int64)
    corners = points[solid]
    edges = corners - np.roll(corners, 1, axis=1)
    longest = (edges**2).sum(axis=2).max(axis=1)
    doubled = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    solid = solid[doubled > SLIVER * longest]
    if not len(solid):
        raise MeshError("no face of the mesh has an area")
    model = fcl.BVHModel()
    model.beginModel(len(solid), len(points))
    model.addSubModel(points, solid)
    model.endModel()
    return model


def convex_geometry(vertices: FloatArray, faces: IntArray) -> Any:
    """An ``fcl.Convex``; its faces are one flat list ``[3, a, b, c, 3, d, e, f, …]``.

    FCL does not check them: a wrong layout reads past the end of the list.
    """
    import fcl

    triangles = np.asarray(faces)
    if triangles.ndim != 2 or triangles.shape[1] != 3 or not len(triangles):
        raise MeshError(f"a convex shape needs faces of shape (f, 3), not {triangles.shape}")
    if triangles.min() < 0 or triangles.max() >= len(vertices):
        raise MeshError("a convex shape's face names a vertex that does not exist")
    flat = np.hstack([np.full((len(triangles), 1), 3), triangles]).astype(np.int32).ravel()
    return fcl.Convex(np.asarray(vertices, dtype=np.float64), len(triangles), flat)


@dataclass(frozen=True, eq=False)
class Frame:
    """The scaled frame in which FCL is asked: ``x ↦ (x - centre) * scale``."""

    centre: FloatArray
    scale: float

    @classmethod
    def around(cls, vertices: FloatArray) -> Frame:
        """The frame that centres the points and makes their diagonal :data:`UNITS`."""
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        diagonal = float(np.linalg.norm(high - low))
        if not diagonal > 0.0:
            raise MeshError("all vertices are one point")
        return cls((low + high) / 2.0, UNITS / diagonal)

    def points(self, x: FloatArray) -> FloatArray:
        """Points (…, 3), metres, in FCL's units."""
        scaled: FloatArray = (np.asarray(x, dtype=np.float64) - self.centre) * self.scale
        return scaled

    def metres(self, length: float) -> float:
        """A length in FCL's units, in metres."""
        return length / self.scale


@dataclass(frozen=True, eq=False)
class Surface:
    """A closed triangle surface to ask about contact and separation.

    Attributes:
        vertices: (n, 3) metres.
        faces: (m, 3), outward.
        frame: the scaled frame shared by everything asked together.
    """

    vertices: FloatArray
    faces: IntArray
    frame: Frame

    @classmethod
    def of_hulls(cls, hulls: Sequence[ConvexShape], frame: Frame) -> Surface:
        """The surfaces of all hulls as one: one query instead of one a hull."""
        if not hulls:
            raise MeshError("there are no hulls to touch")
        offsets = np.cumsum([0, *(len(h.vertices) for h in hulls[:-1])])
        return cls(
            np.vstack([h.vertices for h in hulls]),
            np.vstack([np.asarray(h.faces) + o for h, o in zip(hulls, offsets, strict=True)]),
            frame,
        )

    @cached_property
    def _object(self) -> Any:
        import fcl

        return fcl.CollisionObject(bvh_geometry(self.frame.points(self.vertices), self.faces))

    def crosses(self, probe: Any) -> bool:
        """Whether the probe (an ``fcl.CollisionObject`` in scaled units) meets the surface."""
        import fcl

        result = fcl.CollisionResult()
        fcl.collide(self._object, probe, fcl.CollisionRequest(), result)
        return bool(result.is_collision)

    def gap(self, probe: Any) -> float:
        """Distance from the probe to the surface in metres; 0 where they meet."""
        import fcl

        result = fcl.DistanceResult()
        value = fcl.distance(self._object, probe, fcl.DistanceRequest(), result)
        # FCL says -1 (box) or a denormal number (sphere) for contact.
        return self.frame.metres(max(0.0, float(value)))

    def winding(self, points: FloatArray) -> FloatArray:
        """Generalized winding number (Jacobson et al. 2013) at points (k, 3): 1 inside."""
        import igl

        if not len(points):
            return np.zeros(0)
        # One call for all points: igl rebuilds its tree at every call.
        number = igl.fast_winding_number(
            np.ascontiguousarray(self.vertices),
            np.ascontiguousarray(self.faces),
            np.ascontiguousarray(points, dtype=np.float64),
        )
        return np.asarray(number, dtype=np.float64).ravel()

    def exact_winding(self, points: FloatArray) -> FloatArray:
        """As :meth:`winding`, right next to the surface too; every face for every point."""
        import igl

        if not len(points):
            return np.zeros(0)
        number = igl.winding_number(
            np.ascontiguousarray(self.vertices),
            np.ascontiguousarray(self.faces),
            np.ascontiguousarray(points, dtype=np.float64),
        )
        return np.asarray(number, dtype=np.float64).ravel()

    def distances(self, points: FloatArray) -> FloatArray:
        """Unsigned distances (k,) in metres from points (k, 3) to the surface."""
        import igl

        if not len(points):
            return np.zeros(0)
        squared = igl.point_mesh_squared_distance(
            np.ascontiguousarray(points, dtype=np.float64),
            np.ascontiguousarray(self.vertices),
            np.ascontiguousarray(self.faces),
        )[0]
        return np.sqrt(np.maximum(np.asarray(squared, dtype=np.float64).ravel(), 0.0))


def facet_planes(hull: ConvexShape) -> tuple[FloatArray, FloatArray]:
    """Unit normals (f, 3) and offsets (f,) of a hull's facets: inside is ``n·x ≤ d``.

    Facets without area are left out; they bound nothing.
    """
    v, f = np.asarray(hull.vertices, dtype=np.float64), np.asarray(hull.faces)
    centre = v.mean(axis=0)
    a, b, c = (v[f[:, k]] - centre for k in range(3))
    normals = np.cross(b - a, c - a)
    length = np.linalg.norm(normals, axis=1)
    size = float(np.ptp(v, axis=0).max())
    keep = length > 1e-14 * size * size
    unit = normals[keep] / length[keep, None]
    # The farthest vertex, not the facet's own corner: rounding must not cut vertices off.
    offsets = (unit @ (v - centre).T).max(axis=1)
    return unit, offsets + unit @ centre


def outside_hulls(points: FloatArray, hulls: Sequence[ConvexShape]) -> FloatArray:
    """(k,) least facet excess over the hulls in metres: ≤ 0 inside some hull.

    A lower bound of the distance to the hulls for points outside all of them.
    """
    points = np.asarray(points, dtype=np.float64)
    least = np.full(len(points), np.inf)
    for hull in hulls:
        normals, offsets = facet_planes(hull)
        if not len(normals):
            continue
        for start in range(0, len(points), 4096):
            block = points[start : start + 4096]
            excess = (block @ normals.T - offsets).max(axis=1)
            least[start : start + 4096] = np.minimum(least[start : start + 4096], excess)
    return least
