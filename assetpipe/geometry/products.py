"""Products of rows and small matrices, in one order.

``@``, ``einsum`` and ``norm`` of a single vector leave the order of sums, and whether a product
is rounded before it is added, to the processor's own kernels: their last digit differs from
machine to machine. What ends up in a result is multiplied here.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]


def products(a: FloatArray, b: FloatArray) -> FloatArray:
    """Scalar products of rows (n, 3) with rows (n, 3) or with one vector (3,): (n,)."""
    result: FloatArray = (a[:, 0] * b[..., 0] + a[:, 1] * b[..., 1]) + a[:, 2] * b[..., 2]
    return result


def added(values: Iterable[float]) -> float:
    """The sum from left to right: Python's own compensates for rounding from 3.12 on."""
    result = 0.0
    for value in values:
        result += value
    return result


def length(vector: FloatArray) -> float:
    """Euclidean length of one vector (n,)."""
    return math.sqrt(added(x * x for x in vector.tolist()))


def turned(points: FloatArray, linear: FloatArray) -> FloatArray:
    """Points (n, 3) under a linear map (3, 3)."""
    return np.stack([products(points, row) for row in linear], axis=1)


def composed(first: FloatArray, second: FloatArray) -> FloatArray:
    """The product of two square matrices (n, n)."""
    result: FloatArray = first[:, 0, None] * second[0]
    for k in range(1, len(second)):
        result = result + first[:, k, None] * second[k]
    return result


def moved(points: FloatArray, matrix: FloatArray) -> FloatArray:
    """Points (n, 3) under an affine map (4, 4)."""
    result: FloatArray = turned(points, matrix[:3, :3]) + matrix[:3, 3]
    return result
