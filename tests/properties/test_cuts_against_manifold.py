"""Our cuts against manifold3d, which shares no code with them."""

from __future__ import annotations

import hypothesis.strategies as st
import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings

from assetpipe import _core
from assetpipe.errors import MeshError

manifold3d = pytest.importorskip("manifold3d")

Arrays = tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]


def arrays(solid: manifold3d.Manifold) -> Arrays:
    mesh = solid.to_mesh64()
    vertices = np.ascontiguousarray(mesh.vert_properties[:, :3], dtype=np.float64)
    return vertices, np.ascontiguousarray(mesh.tri_verts, dtype=np.int64)


def volume(piece: Arrays | None) -> float:
    if piece is None:
        return 0.0
    vertices, faces = piece
    middle = vertices.mean(axis=0)
    a, b, c = (vertices[faces[:, i]] - middle for i in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def is_closed_manifold(piece: Arrays) -> bool:
    _, faces = piece
    edges = np.vstack((faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]))
    once = {tuple(e) for e in edges.tolist()}
    return len(once) == len(edges) and all((b, a) in once for a, b in once)


@st.composite
def solids(draw: st.DrawFn) -> manifold3d.Manifold:
    """Unions and differences of boxes, balls and cylinders: holes, cavities, islands."""
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    shapes = (
        lambda s: manifold3d.Manifold.cube(s, True),
        lambda s: manifold3d.Manifold.sphere(s[0], 16),
        lambda s: manifold3d.Manifold.cylinder(s[0], s[1] / 2, s[1] / 2, 12, True),
    )
    solid = manifold3d.Manifold.cube((2, 2, 2), True)
    for _ in range(draw(st.integers(0, 8))):
        shape = shapes[random.integers(3)](random.uniform(0.2, 1.5, 3))
        if draw(st.booleans()):
            shape = shape.rotate(random.uniform(0, 360, 3))
        shape = shape.translate(np.round(random.uniform(-1, 1, 3), 1))
        solid = solid + shape if random.integers(2) else solid - shape
    return solid


@settings(deadline=None, max_examples=120)
@given(solids(), st.integers(0, 5), st.integers(0, 2**32 - 1))
def test_pieces_are_those_of_manifold(solid: manifold3d.Manifold, kind: int, seed: int) -> None:
    vertices, faces = arrays(solid)
    if not len(faces):
        return
    random = np.random.default_rng(seed)
    if kind < 3:
        normal = np.eye(3)[kind]
        # Half of the planes go through a vertex, and so through faces and edges.
        through = vertices[random.integers(len(vertices))]
        offset = float(through[kind] if random.integers(2) else random.uniform(-1, 1))
    else:
        normal = random.normal(size=3)
        normal /= np.linalg.norm(normal)
        offset = float(random.uniform(-1, 1))
    below, above = _core.split(vertices, faces, tuple(normal.tolist()), offset)
    upper, lower = solid.split_by_plane(tuple(normal.tolist()), offset)
    whole = volume((vertices, faces))
    assert volume(below) + volume(above) == pytest.approx(whole, rel=1e-12)
    # Manifold rounds positions at 1e-12 of the size.
    assert volume(below) == pytest.approx(lower.volume(), abs=1e-9 * whole)
    assert volume(above) == pytest.approx(upper.volume(), abs=1e-9 * whole)
    assert all(is_closed_manifold(piece) for piece in (below, above) if piece is not None)


def test_an_open_mesh_is_refused_with_its_edge() -> None:
    vertices, faces = arrays(manifold3d.Manifold.cube((1, 1, 1), True))
    with pytest.raises(MeshError, match="edge"):
        _core.split(vertices, faces[1:], (1.0, 0.0, 0.0), 0.1)
