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
def parts(
    vertices: _Floats,
    faces: _Ints,
    epsilon: float,
    settings: Mapping[str, str | float],
    threads: int,
) -> list[list[tuple[_Floats, _Ints]]]: ...
def thickening(
    vertices: _Floats,
    faces: _Ints,
    hulls: Sequence[_Floats],
    on_progress: Callable[[float], object] | None = None,
) -> list[_Bounds]: ...
def concavity_terms(
    vertices: _Floats,
    faces: _Ints,
    on_progress: Callable[[float], object] | None = None,
) -> tuple[_Bounds, _Bounds, _Bounds]: ...
def thickening_within(
    vertices: _Floats,
    faces: _Ints,
    hulls: Sequence[_Floats],
    epsilon: float,
    on_progress: Callable[[float], object] | None = None,
) -> list[_Bounds | None]: ...
def connections(vertices: _Floats, faces: _Ints) -> tuple[bool, int, _Ints, int]: ...
def crossings(
    vertices: _Floats, faces: _Ints, most: int, second: int | None = None
) -> _Ints | None: ...
def folds(vertices: _Floats, faces: _Ints, unit: float) -> list[tuple[int, int]]: ...
def simplify_within(vertices: _Floats, reach: float) -> tuple[_Floats, _Ints]: ...
def unreachable(
    vertices: _Floats,
    faces: _Ints,
    radius: float,
    threads: int,
    on_progress: Callable[[float], object] | None = None,
) -> tuple[tuple[_Floats, _Ints], int, float]: ...
def enclosing_shapes(
    vertices: _Floats,
) -> list[tuple[str, list[list[float]], list[float], list[float], float]]: ...
def convex_hull(vertices: _Floats) -> tuple[_Floats, _Ints]: ...
def split(
    vertices: _Floats, faces: _Ints, normal: tuple[float, float, float], offset: float
) -> tuple[tuple[_Floats, _Ints] | None, tuple[_Floats, _Ints] | None]: ...

# --- solids from inside ---

_Pose = _Floats

def inner_polytopes(
    vertices: _Floats,
    faces: _Ints,
    gap: float,
    most: int,
    most_vertices: int,
    samples: int,
    on_progress: Callable[[float], object] | None = None,
) -> tuple[list[tuple[_Floats, _Ints, float]], float]: ...
def rigid_inverse(pose: _Pose) -> _Pose: ...
def boxes_apart(a: _Floats, b: _Floats, a_from_b: _Pose, b_from_a: _Pose) -> bool: ...

class SolidIndex:
    def __init__(self, vertices: _Floats, faces: _Ints) -> None: ...
    def contains(self, at: _Floats) -> npt.NDArray[np.bool_]: ...
    def holds_any(self, points: _Floats, own_from_points: _Pose) -> bool: ...

class ConvexSet:
    def __init__(self, polytopes: Sequence[_Floats], reach: float) -> None: ...
    def contains(self, at: _Floats) -> npt.NDArray[np.bool_]: ...
    def holds_any(self, points: _Floats, own_from_points: _Pose) -> bool: ...

# --- polygons (crates/polygon) ---

_Bools = npt.NDArray[np.bool_]
_Labels = npt.NDArray[np.uint32]
_Graph = list[list[bool]]

class PolygonHierarchy:
    def at(self, tolerance: float) -> tuple[list[tuple[list[_Floats], float]], float]: ...
    def descents(self) -> list[tuple[float, float]]: ...

def decompose_polygon(
    rings: Sequence[_Floats],
    tolerance: float,
    concavity: str,
    hole_axis: str,
    weights: tuple[float, float],
) -> PolygonHierarchy: ...
def convex_subset_polygon(rings: Sequence[_Floats]) -> tuple[_Floats, str]: ...
def polygon_kernel(ring: _Floats) -> tuple[_Floats, list[float]]: ...
def convex_pixels(shape: _Bools, connectivity: int) -> _Bools: ...
def pixel_hausdorff(p: _Bools, q: _Bools, connectivity: int) -> int | None: ...
def hv_regions(shape: _Bools) -> tuple[_Labels, _Labels, _Graph, _Graph]: ...
def hv_convex_pixels(shape: _Bools, steps: int) -> tuple[_Bools, list[int], bool]: ...

class Solid:
    def __init__(self, vertices: _Floats, faces: _Ints) -> None: ...
    def closest(self, points: _Floats) -> tuple[_Floats, _Ints, _Floats]: ...
    def contains(self, points: _Floats) -> npt.NDArray[np.bool_]: ...
    def winding(self, points: _Floats) -> _Ints: ...
