"""Points of a surface that have no solid beside them.

Where a surface runs over an edge and back in its own plane it encloses nothing: a flap
without thickness. A solid is what its surface encloses, so nothing has to cover a flap.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from assetpipe.geometry.mesh import FloatArray
from assetpipe.validation.contact.surface import Surface

_ASIDE = 10.0 ** -np.arange(1, 8)
"""How far beside the surface to look, as shares of the distance within which solid counts."""
_LEAST = 1e-11
"""Share of the diagonal nearer than which winding numbers are rounding."""
_AT_ONCE = 16
_ON = 1e-9
"""Share of the diagonal within which a point lies on a face."""


def beside_solid(surface: Surface, points: FloatArray, within: FloatArray) -> npt.NDArray[np.bool_]:
    """Which points of a surface have solid nearer to them than ``within``.

    Asked of winding numbers on both sides of each face that a point lies on. Once some are
    found that do, the others are taken to, too.

    Args:
        surface: closed.
        points: (k, 3) on it, metres.
        within: (k,) metres.

    Returns:
        (k,) mask; ``False`` is proved by samples, ``True`` may also mean not asked.
    """
    result = np.ones(len(points), dtype=bool)
    corners = surface.vertices[surface.faces]
    size = float(np.linalg.norm(np.ptp(surface.vertices, axis=0)))
    low, high = corners.min(axis=1) - _ON * size, corners.max(axis=1) + _ON * size
    for start in range(0, len(points), _AT_ONCE):
        chosen = slice(start, start + _AT_ONCE)
        asked = [
            _beside(corners[((low <= point) & (high >= point)).all(axis=1)], point, reach, size)
            for point, reach in zip(points[chosen], within[chosen], strict=True)
        ]
        numbers = surface.exact_winding(np.vstack(asked))
        owner = np.repeat(np.arange(len(asked)), [len(each) for each in asked])
        result[chosen] = np.bincount(owner, numbers > 0.5, len(asked)) > 0
        if result[chosen].any():
            break
    return result


def _beside(near: FloatArray, point: FloatArray, within: float, size: float) -> FloatArray:
    """(l, 3) places near a point, on both sides of those faces, (k, 3, 3), that it lies on."""
    cross = np.cross(near[:, 1] - near[:, 0], near[:, 2] - near[:, 0])
    length = np.linalg.norm(cross, axis=1)
    near, unit = near[length > 0.0], cross[length > 0.0] / length[length > 0.0, None]
    on = np.abs(((point - near[:, 0]) * unit).sum(axis=1)) <= _ON * size
    near, unit = near[on], unit[on]
    # From a corner or an edge into the face, where what it bounds has some room.
    inward = near.mean(axis=1) - point
    reach = np.linalg.norm(inward, axis=1)
    share = np.minimum(0.5, 0.5 * within / np.maximum(reach, np.finfo(float).tiny))
    starts = point + share[:, None] * inward
    steps = np.maximum((share * reach)[:, None] * _ASIDE, _LEAST * size)
    away = steps[:, :, None] * unit[:, None, :]
    places = np.concatenate([starts[:, None] + away, starts[:, None] - away])
    flat: FloatArray = places.reshape(-1, 3)
    return flat
