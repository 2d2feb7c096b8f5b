"""Vertices that no face uses."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt


def referenced(
    vertices: npt.NDArray[np.float64], faces: npt.NDArray[np.int64]
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    """Drop vertices that no face uses; the others keep their order and their bits."""
    used = np.zeros(len(vertices), dtype=bool)
    used[faces] = True
    if used.all():
        return vertices, faces
    rank = np.cumsum(used) - 1
    return vertices[used], rank[faces]
