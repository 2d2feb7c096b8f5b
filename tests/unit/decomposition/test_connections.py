"""What the engine's edges say about a surface, against those of the repair ladder."""

import numpy as np
import pytest
import trimesh

from assetpipe import _core
from assetpipe.geometry.health.topology import Edges, face_components


def torn(seed: int, kept: float) -> tuple[np.ndarray, np.ndarray]:
    """Balls that share vertices, edges or nothing; some faces turned over, doubled or left out."""
    random = np.random.default_rng(seed)
    ball = trimesh.creation.icosphere(subdivisions=1)
    faces = np.vstack([ball.faces + k * len(ball.vertices) for k in range(4)]).astype(np.int64)
    vertices = np.vstack([ball.vertices + 3.0 * k for k in range(4)])
    joined = random.integers(0, len(vertices), 6)
    faces = np.where(np.isin(faces, joined), joined.min(), faces)
    faces = faces[random.random(len(faces)) < kept]
    turned = random.random(len(faces)) < 0.1 * (kept < 1.0)
    faces[turned] = faces[turned][:, ::-1]
    faces = np.vstack([faces, faces[random.random(len(faces)) < 0.1 * (kept < 1.0)]])
    whole = (
        (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    )
    return vertices, np.ascontiguousarray(random.permutation(faces[whole]))


@pytest.mark.parametrize("kept", [1.0, 0.9, 0.3])
def test_they_agree(kept: float) -> None:
    for seed in range(20):
        vertices, faces = torn(seed, kept)
        closed, count, component, _ = _core.connections(vertices, faces)
        edges = Edges.of(faces, len(vertices))
        number, labels = face_components(edges)
        assert (closed, count) == (not edges.balance.any(), len(edges.ends))
        assert component.max() + 1 == number
        assert np.array_equal(component, labels)


def test_closed_surfaces_are_closed() -> None:
    ball = trimesh.creation.icosphere(subdivisions=2)
    closed, count, component, folds = _core.connections(ball.vertices, ball.faces)
    assert (closed, count, folds) == (True, 480, 0)
    assert not component.any()
    assert not _core.connections(ball.vertices, ball.faces[1:])[0]
