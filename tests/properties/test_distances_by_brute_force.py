"""Distances and nearest points of surfaces, crumpled ones too, by every face in long doubles."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from assetpipe.geometry.repair.surface import Surface

_SEEDS = st.integers(0, 2**32 - 1)
Long = np.longdouble


def crumpled(r: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Triangles between random points; in some cases on a grid, in a plane, or nearly needles."""
    points = r.normal(size=(r.integers(3, 40), 3))
    kind = r.integers(4)
    if kind == 1:
        points = np.round(points)
    elif kind == 2:
        points[:, 2] = 0.0
    elif kind == 3:
        points[:, 1:] *= 10.0 ** -r.uniform(3, 9)
    faces = np.array([r.choice(len(points), 3, replace=False) for _ in range(r.integers(1, 60))])
    return points, faces


def to_segments(points: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    along = end - start
    squared = (along * along).sum(axis=-1)
    share = ((points - start) * along).sum(axis=-1) / np.where(squared > 0, squared, 1)
    foot = start + np.clip(share, 0, 1)[..., None] * along
    return np.sqrt(((points - foot) ** 2).sum(axis=-1))


def to_triangles(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Distance of (…, 3) points from (…, 3, 3) triangles."""
    a, b, c = (corners[..., k, :].astype(Long) for k in range(3))
    points = points.astype(Long)
    edges = [to_segments(points, *ends) for ends in ((a, b), (b, c), (c, a))]
    normal = np.cross(b - a, c - a)
    length = np.sqrt((normal * normal).sum(axis=-1))
    over = length > 0
    for start, end in ((a, b), (b, c), (c, a)):
        over = over & ((np.cross(end - start, points - start) * normal).sum(axis=-1) >= 0)
    height = np.abs(((points - a) * normal).sum(axis=-1)) / np.where(over, length, 1)
    nearest = np.min(edges, axis=0)
    return np.asarray(np.where(over, np.minimum(height, nearest), nearest), dtype=float)


@settings(max_examples=200, deadline=None)
@given(_SEEDS)
def test_distances_are_the_smallest_to_any_face(seed: int) -> None:
    r = np.random.default_rng(seed)
    vertices, faces = crumpled(r)
    far = 10.0 ** r.uniform(-6, 2)
    points = np.vstack([r.normal(size=(30, 3)) * far, vertices, vertices[faces].mean(axis=1)])
    distance, face, foot = Surface(vertices, faces).closest(points)
    each = to_triangles(points[:, None], vertices[faces][None])
    size = np.abs(points).max() + np.abs(vertices).max()
    # Too large by rounding, next to needles; never too small.
    excess = distance - each.min(axis=1)
    assert excess.min() >= -1e-15 * size
    assert excess.max() <= 1e-10 * size
    np.testing.assert_allclose(np.linalg.norm(points - foot, axis=1), distance, atol=1e-15 * size)
    assert to_triangles(foot, vertices[faces[face]]).max() <= 1e-14 * size
