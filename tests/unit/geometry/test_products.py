"""Numbers that end up in results do not depend on the processor's own kernels."""

import os
import subprocess
import sys

import pytest

from assetpipe.geometry.products import added
from assetpipe.geometry.repair.frame import doublings

DIAGONALS = """
import math
import numpy as np
from assetpipe.geometry import Mesh

for x, y, z in np.random.default_rng(0).random((500, 3)).tolist():
    mesh = Mesh([[0.0, 0.0, 0.0], [x, y, z]], np.zeros((0, 3), dtype=int))
    assert mesh.diagonal == math.sqrt(x * x + y * y + z * z), (x, y, z)
"""


@pytest.mark.parametrize("kernels", ["Nehalem", "Prescott", "Haswell"])
def test_a_diagonal_is_the_same_whatever_blas_takes(kernels: str) -> None:
    environment = {
        **os.environ,
        "OPENBLAS_CORETYPE": kernels,
        "PYTHONPATH": os.pathsep.join(sys.path),
    }
    command = [sys.executable, "-c", DIAGONALS]
    done = subprocess.run(command, env=environment, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr.decode()


def test_sums_are_taken_from_left_to_right() -> None:
    # Python 3.12 and later compensate sums: theirs is 2.
    assert added([1e16, 1.0, 1.0, -1e16]) == 0.0
    assert added([]) == 0.0


@pytest.mark.parametrize(
    ("number", "exponent"),
    [(1.0, 0), (1.0 + 2.0**-52, 1), (2.0, 1), (3.0, 2), (0.5, -1), (0.3, -1), (2.0**-1000, -1000)],
)
def test_doublings_are_exact_beside_powers_of_two(number: float, exponent: int) -> None:
    assert doublings(number) == exponent
