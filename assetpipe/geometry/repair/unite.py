"""Closed shells made one solid: nesting, cavities, union.

The union is manifold3d's: Smith, J. "Guaranteed-manifold mesh Boolean operations",
run in float64 on a centred unit copy.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np

from assetpipe.geometry.health.topology import Edges, face_components, groups
from assetpipe.geometry.mesh import FloatArray, IntArray
from assetpipe.geometry.products import added, products
from assetpipe.geometry.repair.deadline import NEVER, Deadline
from assetpipe.geometry.repair.rows import as_rows
from assetpipe.geometry.repair.surface import Corners, Surface, no_corners
from assetpipe.geometry.strays import referenced

_BELOW = 1e-4
"""How far below a face to look, in proportion to the face."""
_OUTSIDE = 0.1
"""Fast winding number below which a point is outside of a closed shell for sure."""


@dataclass(frozen=True, eq=False)
class Shell:
    """One connected, closed, consistently wound piece of surface, in units.

    Attributes:
        vertices: (n, 3).
        faces: (m, 3).
        volume: signed; negative for one that faces inward.
    """

    vertices: FloatArray
    faces: IntArray
    volume: float

    @classmethod
    def of(cls, vertices: FloatArray, faces: IntArray) -> Shell:
        """A shell of its own arrays."""
        vertices, faces = referenced(vertices, faces)
        return cls(vertices, faces, signed_volume(vertices, faces))

    @property
    def outward(self) -> Shell:
        """The same surface, facing out of what it encloses."""
        return self if self.volume >= 0.0 else self.reversed()

    def reversed(self) -> Shell:
        """The same surface, facing the other way."""
        return Shell(self.vertices, self.faces[:, ::-1], -self.volume)


@dataclass(frozen=True, eq=False)
class Nest:
    """How shells lie in each other.

    Attributes:
        shells: outermost ones turned outward, with them what lies inside.
        inverted: how many outermost shells were inside-out.
        parent: index of the smallest shell around each shell, or -1.
        touching: pairs whose boxes overlap without one lying wholly inside the other.
    """

    shells: tuple[Shell, ...]
    inverted: int
    parent: tuple[int, ...]
    touching: int


def signed_volume(vertices: FloatArray, faces: IntArray) -> float:
    """Volume that (vertices, faces) enclose, about their own centre."""
    if not len(faces):
        return 0.0
    centre = (vertices.min(axis=0) + vertices.max(axis=0)) / 2.0
    a, b, c = (vertices[faces[:, k]] - centre for k in range(3))
    return float(products(a, np.cross(b, c)).sum() / 6.0)


def shells_of(vertices: FloatArray, faces: IntArray) -> list[Shell]:
    """Each edge-connected component on its own, in the order of its first face."""
    number, label = face_components(Edges.of(faces, len(vertices)))
    if number == 1:
        return [Shell.of(vertices, faces)]
    return [Shell.of(vertices, faces[chosen]) for chosen in groups(label, number)]


def nest(shells: list[Shell], deadline: Deadline = NEVER) -> Nest:
    """Find which shell lies in which, and turn the outermost outward.

    A shell that lies inside another keeps its winding *relative* to the outermost one
    around it, so that a mirrored file with a cavity stays a part with a cavity.
    """
    number = len(shells)
    low = np.array([shell.vertices.min(axis=0) for shell in shells])
    high = np.array([shell.vertices.max(axis=0) for shell in shells])
    size = np.array([abs(shell.volume) for shell in shells])
    fields = [Surface(shell.vertices, shell.faces) for shell in shells]
    parent = [-1] * number
    roots = list(range(number))
    touching = 0
    for i in range(number):
        deadline.check()
        around = np.flatnonzero((low <= low[i]).all(axis=1) & (high >= high[i]).all(axis=1))
        around = around[(around != i) & (size[around] > size[i])]
        holders = [int(j) for j in around if _contains(fields[int(j)], shells[i])]
        if holders:
            parent[i] = min(holders, key=lambda j: (size[j], j))
        overlap = ((low <= high[i]) & (high >= low[i])).all(axis=1)
        overlap[i] = False
        overlap[[j for j in holders if j != i]] = False
        touching += int(overlap.sum())
    for i in range(number):
        while parent[roots[i]] >= 0:
            roots[i] = parent[roots[i]]
    turned = [
        shell.reversed() if shells[root].volume < 0.0 else shell
        for shell, root in zip(shells, roots, strict=True)
    ]
    inverted = sum(1 for i in range(number) if parent[i] < 0 and shells[i].volume < 0.0)
    return Nest(tuple(turned), inverted, tuple(parent), touching)


def _contains(outer: Surface, inner: Shell) -> bool:
    """Whether ``inner`` lies within ``outer``; it may touch it from inside.

    Judged at 32 points just below its faces, whichever way it is wound.
    """
    import igl

    corners = inner.vertices[inner.faces[:: max(1, len(inner.faces) // 32)]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normal, axis=1)
    down = -np.sign(inner.volume) * _BELOW / np.sqrt(np.maximum(length, np.finfo(float).tiny))
    points = corners.mean(axis=1) + down[:, None] * normal
    # Fast winding numbers tell what is far outside; exact ones are dear.
    if (np.abs(outer.winding(points)) < _OUTSIDE).any():
        return False
    winding = igl.winding_number(outer.vertices, outer.faces, points)
    return bool((np.abs(winding) > 0.5).all())


def nothing() -> tuple[FloatArray, IntArray]:
    """Arrays of no surface."""
    return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)


@dataclass(frozen=True, eq=False)
class United:
    """Shells made one.

    Attributes:
        vertices: (n, 3) units.
        faces: (m, 3).
        inverted: outermost shells that were inside-out.
        cavities: enclosed voids found.
        enclosed: what all shells enclose, voids less, each for itself.
        buried: shells that lay wholly inside others and facing outward.
        joined: ``"alone"``: a single shell; ``"apart"``: shells that don't overlap, put side
            by side; ``"union"``.
        gone: triangles of shells that a union has not, corner for corner.
        put: those that it has instead.
        taken: vertices and faces of the shells that went into a union.
    """

    vertices: FloatArray
    faces: IntArray
    inverted: int = 0
    cavities: int = 0
    enclosed: float = 0.0
    buried: int = 0
    joined: Literal["alone", "apart", "union"] = "alone"
    gone: Corners = field(default_factory=no_corners)
    put: Corners = field(default_factory=no_corners)
    taken: tuple[FloatArray, IntArray] = field(default_factory=nothing)


def unite(
    shells: tuple[Shell, ...], cavities: Literal["keep", "fill"], deadline: Deadline = NEVER
) -> United | None:
    """The union of all bodies, each an outward shell less the cavities right inside it.

    Returns:
        ``None`` if manifold3d refuses a shell.
    """
    nested = nest(list(shells), deadline)
    shells, parent = nested.shells, nested.parent
    every = range(len(shells))
    hollow = [parent[i] >= 0 and shells[i].volume < 0.0 for i in every]
    voids = [i for i in every if hollow[i] and not hollow[parent[i]]]
    if cavities == "keep":
        kept = voids
        covered = [i for i in every if not hollow[i] and parent[i] >= 0 and not hollow[parent[i]]]
    else:
        kept = []
        covered = [i for i in every if not hollow[i] and parent[i] >= 0]
    buried = set(covered)
    bodies = [i for i in every if not hollow[i] and i not in buried]
    found = United(
        *nothing(),
        inverted=nested.inverted,
        cavities=len(voids),
        enclosed=added(shell.volume for shell in shells),
        buried=len(covered),
    )
    if nested.touching == 0:
        vertices, faces = put_together([shells[i] for i in sorted([*bodies, *kept])])
        joined: Literal["alone", "apart"] = "alone" if len(bodies) + len(kept) == 1 else "apart"
        return replace(found, vertices=vertices, faces=faces, joined=joined)
    merged = _boolean(shells, bodies + covered, kept, parent, deadline)
    if merged is None:
        return None
    return replace(
        compared(*merged),
        inverted=found.inverted,
        cavities=found.cavities,
        enclosed=found.enclosed,
        buried=found.buried,
        joined="union",
    )


def compared(solid: Any, taken: tuple[FloatArray, IntArray]) -> United:
    """What manifold3d made of shells, and what of them it has not or has instead."""
    vertices, faces = arrays_of(solid)
    gone, put = different(*taken, vertices, faces)
    return United(
        vertices, faces, gone=taken[0][taken[1][gone]], put=vertices[faces[put]], taken=taken
    )


def put_together(parts: list[Shell]) -> tuple[FloatArray, IntArray]:
    """Arrays of all parts, one after the other."""
    offsets = np.cumsum([0, *(len(part.vertices) for part in parts)])
    return (
        np.concatenate([part.vertices for part in parts]),
        np.concatenate([part.faces + at for part, at in zip(parts, offsets, strict=False)]),
    )


def manifold_of(vertices: FloatArray, faces: IntArray) -> Any | None:
    """A manifold3d solid of closed arrays, or ``None`` if it refuses them."""
    import manifold3d

    # Mesh64 refuses read-only arrays.
    solid = manifold3d.Manifold(
        manifold3d.Mesh64(
            np.array(vertices, dtype=np.float64, order="C"),
            np.array(faces, dtype=np.uint64, order="C"),
        )
    )
    if solid.status() != manifold3d.Error.NoError or solid.is_empty():
        return None
    return solid


def arrays_of(solid: Any) -> tuple[FloatArray, IntArray]:
    """Vertices and faces of a manifold3d solid."""
    mesh = solid.to_mesh64()
    vertices = np.array(mesh.vert_properties[:, :3], dtype=np.float64)
    faces = np.array(mesh.tri_verts, dtype=np.int64)
    if len(mesh.merge_from_vert):
        to = np.arange(len(vertices))
        to[np.array(mesh.merge_from_vert, dtype=np.int64)] = np.array(
            mesh.merge_to_vert, dtype=np.int64
        )
        faces = to[faces]
    return referenced(vertices, faces)


def _boolean(
    shells: tuple[Shell, ...],
    bodies: list[int],
    voids: list[int],
    parent: tuple[int, ...],
    deadline: Deadline,
) -> tuple[Any, tuple[FloatArray, IntArray]] | None:
    """The union of bodies less the voids in them, and the arrays of all that went into it.

    manifold3d replaces faces that are degenerate to it, refuses some shells whole, and moves
    the surface where shells cross themselves: none of it may go unmeasured.
    """
    import manifold3d

    taken: list[Shell] = []

    def solid_of(shell: Shell) -> Any | None:
        taken.append(shell)
        return manifold_of(shell.vertices, shell.faces)

    solids: list[Any] = []
    for i in bodies:
        deadline.check()
        solid = solid_of(shells[i].outward)
        for j in voids:
            if parent[j] == i:
                hole = solid_of(shells[j].reversed())
                solid = solid if hole is None or solid is None else solid - hole
        if solid is not None:
            solids.append(solid)
    union = manifold3d.Manifold.batch_boolean(solids, manifold3d.OpType.Add)
    if union.status() != manifold3d.Error.NoError or union.is_empty():
        return None
    return union, put_together(taken)


def different(
    vertices: FloatArray, faces: IntArray, others: FloatArray, other_faces: IntArray
) -> tuple[IntArray, IntArray]:
    """Indices of faces that the other surface has not, corner for corner, and the reverse."""
    _, names = np.unique(as_rows(np.concatenate([vertices, others])), return_inverse=True)
    mine, theirs = names[: len(vertices)][faces], names[len(vertices) :][other_faces]
    keys = np.sort(np.concatenate([mine, theirs]), axis=1)
    number = np.int64(names.max() + 1)
    # Two numbers for three names: at most 2⁶³ for two million vertices.
    _, pair = np.unique(keys[:, 0] * number + keys[:, 1], return_inverse=True)
    key = pair.astype(np.int64) * number + keys[:, 2]
    own, other = key[: len(faces)], key[len(faces) :]
    return np.flatnonzero(~np.isin(own, other)), np.flatnonzero(~np.isin(other, own))
