"""Inner hulls: convex polytopes proved to be inside a solid."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from assetpipe.decomposition.polytope import Polytope
from assetpipe.errors import UsageError
from assetpipe.geometry.mesh import Mesh

if TYPE_CHECKING:
    import trimesh

MOST = 400
"""Polytopes, if nothing else is said."""

_MOST_VERTICES = 256
_SAMPLES = 4000


@dataclass(frozen=True, eq=False)
class InnerHull(Polytope):
    """A convex polytope wholly inside a solid: contact with it is contact with the solid.

    Proved for the vertices as they stand, by exact predicates: the polytope's interior
    meets no face of the solid, and one of its points is inside.
    """


def inner_hulls(
    mesh: Mesh | trimesh.Trimesh | tuple[Any, Any],
    gap: float,
    *,
    most: int = MOST,
    on_progress: Callable[[float], object] | None = None,
) -> tuple[InnerHull, ...]:
    """Convex polytopes inside a closed solid that leave little of it out.

    Bodies grow from the medial axis until planes stop them on all sides (the kernel
    dilation of Chassery & Coeurjolly 2005, §5, in three dimensions; ``docs/inner.md``).
    That each is inside is proved; how large they are and how many is heuristic.

    Args:
        mesh: a closed solid, wound outward, metres.
        gap: metres; polytopes are added until sampled points of the surface are this near
            to one, as far as that is found.
        most: at most so many; those that reach most of the surface are kept.
        on_progress: called with the share done; returning ``False`` stops the work.

    Returns:
        Largest first; neighbours may overlap. Empty if nothing was found.

    Raises:
        UsageError: a gap or a number that is not positive.
        MeshError: the mesh is not closed.
        CancelledError: ``on_progress`` returned ``False``.
    """
    from assetpipe import _core

    if not (gap > 0 and np.isfinite(gap)):
        raise UsageError(f"the gap must be a positive length, not {gap}")
    if most < 1:
        raise UsageError(f"most must be at least 1, not {most}")
    solid = Mesh.of(mesh)
    found, _ = _core.inner_polytopes(
        np.ascontiguousarray(solid.vertices),
        np.ascontiguousarray(solid.faces),
        float(gap),
        most,
        _MOST_VERTICES,
        _SAMPLES,
        on_progress,
    )
    return tuple(InnerHull(vertices, faces, volume) for vertices, faces, volume in found)


def united_volume(hulls: Sequence[InnerHull]) -> float:
    """How much the hulls fill together, m³: what several share counts once.

    By manifold3d; hulls too thin for it count nothing.
    """
    import manifold3d

    from assetpipe.geometry.repair.unite import arrays_of, manifold_of

    if not hulls:
        return 0.0
    corners = np.vstack([hull.vertices for hull in hulls])
    middle, size = corners.mean(axis=0), float(np.ptp(corners, axis=0).max())
    bodies = [manifold_of((hull.vertices - middle) / size, hull.faces) for hull in hulls]
    union = manifold3d.Manifold.batch_boolean(
        [body for body in bodies if body is not None], manifold3d.OpType.Add
    )
    if union.is_empty():
        return 0.0
    return Mesh(*arrays_of(union)).volume * size**3
