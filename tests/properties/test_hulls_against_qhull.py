"""Our hulls against Qhull, which shares no code with them."""

from __future__ import annotations

import hypothesis.strategies as st
import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings

from assetpipe import _core

scipy_spatial = pytest.importorskip("scipy.spatial")

Points = npt.NDArray[np.float64]


def volume(vertices: Points, faces: npt.NDArray[np.int64]) -> float:
    a, b, c = (vertices[faces[:, i]] - vertices[0] for i in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


@st.composite
def point_sets(draw: st.DrawFn) -> Points:
    """Scattered, on a sphere, on a grid, on a prism; stretched and moved."""
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    count = draw(st.integers(8, 300))
    family = draw(st.sampled_from(("cube", "sphere", "grid", "prism")))
    if family == "cube":
        points = random.uniform(-1, 1, (count, 3))
    elif family == "sphere":
        points = random.normal(size=(count, 3))
        points /= np.linalg.norm(points, axis=1, keepdims=True)
    elif family == "grid":
        points = random.integers(0, draw(st.integers(3, 9)), (count, 3)).astype(float)
    else:
        angle = 2 * np.pi * np.arange(count) / count
        ring = np.column_stack((np.cos(angle), np.sin(angle)))
        points = np.vstack([np.column_stack((ring, np.full(count, z))) for z in (0.0, 1.0)])
    stretch = 10.0 ** random.uniform(-3, 3, 3) if draw(st.booleans()) else 1.0
    return np.ascontiguousarray(points * stretch + draw(st.sampled_from((0.0, 10.0))))


@settings(deadline=None, max_examples=150)
@given(point_sets())
def test_same_volume_and_no_more_vertices(points: Points) -> None:
    try:
        oracle = scipy_spatial.ConvexHull(points)
    except scipy_spatial.QhullError:
        return  # flat for Qhull
    vertices, faces = _core.convex_hull(points)
    scale = float(np.prod(np.ptp(points, axis=0)))
    assert volume(vertices, faces) == pytest.approx(oracle.volume, rel=1e-9, abs=1e-9 * scale)
    # Each is an input point, and each of Qhull's is on or very near our hull:
    # Qhull merges facets that are flat but for rounding, we do not.
    assert {tuple(v) for v in vertices} <= {tuple(p) for p in points}
    normals = np.cross(
        vertices[faces[:, 1]] - vertices[faces[:, 0]], vertices[faces[:, 2]] - vertices[faces[:, 0]]
    )
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = normals / lengths
    heights = points @ normals.T - np.einsum("ij,ij->i", normals, vertices[faces[:, 0]])
    size = float(np.abs(points).max())
    good = lengths[:, 0] > 1e-9 * lengths.max()
    assert heights[:, good].max() <= 1e-9 * size


@pytest.mark.parametrize("count", [10_000, 200_000])
def test_large_sets(count: int) -> None:
    points = np.random.default_rng(count).normal(size=(count, 3))
    oracle = scipy_spatial.ConvexHull(points)
    vertices, faces = _core.convex_hull(points)
    assert len(vertices) == len(oracle.vertices)
    assert {tuple(v) for v in vertices} == {tuple(points[i]) for i in oracle.vertices}
    assert volume(vertices, faces) == pytest.approx(oracle.volume, rel=1e-12)
