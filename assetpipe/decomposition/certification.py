"""Certificates for hulls of any origin."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from assetpipe.decomposition.certificate import Certificate, Interval
from assetpipe.decomposition.engine import is_closed
from assetpipe.errors import MeshError
from assetpipe.geometry.mesh import Mesh


def certify(
    solid: Mesh | Any,
    hulls: Iterable[Any],
    *,
    on_progress: Callable[[float], object] | None = None,
) -> tuple[Certificate, ...]:
    """Bound how far each hull reaches out of a solid.

    Args:
        solid: a closed mesh, metres.
        hulls: point sets, each a Hull, a Mesh, a ``trimesh.Trimesh``, a pair (vertices,
            faces) or an array (k, 3); the convex hull of each is measured.
        on_progress: as in :func:`decompose`.

    Returns:
        One certificate for each hull, in order; ``concavity`` is ``None``, because a hull
        of other origin has no part.

    Raises:
        MeshError: the solid is not closed, a hull spans no volume, or values are not finite.
    """
    from assetpipe import _core

    mesh = Mesh.of(solid)
    if not len(mesh.faces) or not is_closed(mesh):
        raise MeshError("certificates are towards a closed solid, and the mesh is none: repair it")
    points = [_points(hull) for hull in hulls]
    bounds = _core.thickening(
        np.ascontiguousarray(mesh.vertices), np.ascontiguousarray(mesh.faces), points, on_progress
    )
    return tuple(Certificate(Interval(*pair), None) for pair in bounds)


def _points(hull: Any) -> np.ndarray[Any, np.dtype[np.float64]]:
    if isinstance(hull, tuple | list) and len(hull) == 2:
        hull = hull[0]
    vertices = getattr(hull, "vertices", hull)
    return np.ascontiguousarray(np.asarray(vertices, dtype=np.float64))
