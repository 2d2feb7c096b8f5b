"""Products of rows and small matrices, in one order.

``@``, ``einsum`` and ``norm`` of a single vector leave the order of sums, and whether a product
is rounded before it is added, to the processor's own kernels: their last digit differs from
machine to machine. What ends up in a result is multiplied here.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]


def products(a: FloatArray, b: FloatArray) -> FloatArray:
    """Scalar products of rows (n, 3) with rows (n, 3) or with one vector (3,): (n,)."""
    result: FloatArray = (a[:, 0] * b[..., 0] + a[:, 1] * b[..., 1]) + a[:, 2] * b[..., 2]
    return result


def length(vector: FloatArray) -> float:
    """Euclidean length of one vector (3,)."""
    return math.sqrt(float(products(vector[None], vector)[0]))


def turned(points: FloatArray, linear: FloatArray) -> FloatArray:
    """Points (n, 3) under a linear map (3, 3)."""
    return np.stack([products(points, row) for row in linear], axis=1)


def moved(points: FloatArray, matrix: FloatArray) -> FloatArray:
    """Points (n, 3) under an affine map (4, 4)."""
    result: FloatArray = turned(points, matrix[:3, :3]) + matrix[:3, 3]
    return result
