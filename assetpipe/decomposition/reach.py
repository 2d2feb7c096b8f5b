"""Navigable space: what nothing can enter counts as solid.

A ball of radius R that comes from far away without overlapping the solid reaches some of
the free space; the rest (screw holes, gaps between shells, sealed voids) can matter to no
collision with anything thicker than 2 R. ``crates/decompose/src/reach`` finds it on a
lattice and proves that every point of the pockets it returns is out of reach or in the
solid; here the solid is united with them.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from assetpipe.errors import MeshError, UsageError
from assetpipe.geometry.mesh import FloatArray, Mesh
from assetpipe.geometry.repair.frame import Frame

_ROUNDING = 1e-9
"""Of the bounding box's volume: what a union may round."""


@dataclass(frozen=True)
class Closing:
    """What was closed.

    Attributes:
        reach: the ball's radius, metres.
        pockets: how many connected spaces count as solid now.
        volume: of them, m³.
        spacing: of the lattice, metres; pockets begin up to about twice of it late.
    """

    reach: float
    pockets: int
    volume: float
    spacing: float

    def undone(self) -> Closing:
        """The same search, and nothing closed."""
        return Closing(self.reach, 0, 0.0, self.spacing)

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready, lengths in metres."""
        return {
            "reach": self.reach,
            "pockets": self.pockets,
            "volume": self.volume,
            "spacing": self.spacing,
        }


@dataclass(frozen=True, eq=False)
class Closed:
    """A solid without the space that a ball cannot enter.

    Attributes:
        solid: contains the given solid; what it holds beyond that is out of reach.
        closing: what was closed.
    """

    solid: Mesh
    closing: Closing


def close_unreachable(
    solid: Mesh,
    reach: float,
    *,
    threads: int | None = None,
    on_progress: Callable[[float], object] | None = None,
) -> Closed:
    """Unite a solid with the space that no ball of radius ``reach`` can enter from outside.

    Args:
        solid: a closed mesh, metres.
        reach: radius of the ball, metres, positive.
        threads: at most so many threads; no influence on the result.
        on_progress: as in :func:`assetpipe.decompose`.

    Raises:
        UsageError: a reach that is not a positive, finite number.
        LimitError: a reach that is too small for the size of the mesh; names one that is not.
        MeshError: not a solid, or one that cannot be united with anything.
        CancelledError: ``on_progress`` returned ``False``.
    """
    from assetpipe import _core

    check_reach(reach)
    if reach == 0.0:
        raise UsageError("reach must be positive to close anything")
    (vertices, faces), pockets, spacing = _core.unreachable(
        np.ascontiguousarray(solid.vertices),
        np.ascontiguousarray(solid.faces),
        reach,
        threads or 0,
        on_progress,
    )
    if not pockets:
        return Closed(solid, Closing(reach, 0, 0.0, spacing))
    closed = _united(solid, Mesh(vertices, faces))
    volume = max(closed.volume - solid.volume, 0.0)
    return Closed(closed, Closing(reach, pockets, volume, spacing))


def check_reach(reach: float) -> None:
    """Refuse what is no length.

    Raises:
        UsageError: negative or not finite.
    """
    if not 0.0 <= reach < math.inf:
        raise UsageError(f"reach must be a length of 0 or more metres, not {reach}")


def _united(solid: Mesh, pockets: Mesh) -> Mesh:
    """The union, with the solid's vertices to the very bit."""
    import manifold3d

    frame = Frame.around(solid.vertices)
    parts = []
    for mesh in (solid, pockets):
        part = manifold3d.Manifold(
            manifold3d.Mesh64(
                np.array(frame.inward(mesh.vertices)), np.array(mesh.faces, dtype=np.uint64)
            )
        )
        if part.status() != manifold3d.Error.NoError or part.is_empty():
            raise MeshError(f"pockets cannot be closed: the solid is refused ({part.status()})")
        parts.append(part)
    made = (parts[0] + parts[1]).to_mesh64()
    united, _ = frame.restored(
        np.asarray(made.vert_properties, dtype=np.float64)[:, :3], solid.vertices
    )
    result = Mesh(united, np.asarray(made.tri_verts, dtype=np.int64))
    _check(solid, pockets, result)
    return result


def _check(solid: Mesh, pockets: Mesh, united: Mesh) -> None:
    """A union that lost something, or made something up, is refused."""
    sides: FloatArray = solid.bounds[1] - solid.bounds[0]
    slack = _ROUNDING * float(np.prod(np.maximum(sides, 1e-3 * sides.max())))
    if not solid.volume - slack <= united.volume <= solid.volume + pockets.volume + slack:
        raise MeshError(
            "pockets cannot be closed: the solid overlaps itself; repair it, or set reach to 0"
        )


__all__ = ["Closed", "Closing", "check_reach", "close_unreachable"]
