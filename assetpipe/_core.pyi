"""Types of the native module."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import numpy.typing as npt

_Floats = npt.NDArray[np.float64]
_Ints = npt.NDArray[np.int64]
_Bounds = tuple[float, float]
_Hull = tuple[_Floats, _Ints, float, _Bounds, _Bounds | None, tuple[int, int] | None]

__version__: str

def decompose(
    vertices: _Floats,
    faces: _Ints,
    epsilon: float,
    settings: Mapping[str, str | float],
    threads: int,
    on_progress: Callable[[float], object] | None = None,
) -> tuple[list[_Hull], int]: ...
def thickening(
    vertices: _Floats,
    faces: _Ints,
    hulls: Sequence[_Floats],
    on_progress: Callable[[float], object] | None = None,
) -> list[_Bounds]: ...
def convex_hull(vertices: _Floats) -> tuple[_Floats, _Ints]: ...
