"""Points compared bit for bit."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from assetpipe.geometry.mesh import FloatArray

_ROW = np.dtype((np.void, 24))


def as_rows(points: FloatArray) -> npt.NDArray[Any]:
    """(n,) the bits of each of (n, 3) points as one value, which sorts and compares; minus zero
    is zero."""
    return np.ascontiguousarray(points + 0.0).view(_ROW).ravel()
