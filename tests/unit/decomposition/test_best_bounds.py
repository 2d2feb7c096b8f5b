"""What ``effort="best"`` says about its hulls is sharp."""

import numpy as np
import pytest
import trimesh
from manifold3d import Manifold

import assetpipe


def arrays(solid: Manifold) -> tuple[np.ndarray, np.ndarray]:
    mesh = solid.to_mesh64()
    return np.asarray(mesh.vert_properties)[:, :3].copy(), np.asarray(mesh.tri_verts).astype(int)


def lens_and_post() -> tuple[np.ndarray, np.ndarray]:
    post = Manifold.cube([0.3, 0.3, 1.4]).translate([-0.15, -0.15, -0.2])
    return arrays(Manifold.sphere(0.6, 24).scale([1.0, 0.8, 0.4]) + post)


def ring() -> tuple[np.ndarray, np.ndarray]:
    mesh = trimesh.creation.torus(1.0, 0.4, major_sections=24, minor_sections=12)
    return mesh.vertices, mesh.faces


@pytest.mark.parametrize("shape", [lens_and_post, ring])
@pytest.mark.parametrize("metric", ["thickening", "concavity"])
def test_both_ends_of_every_bound_are_within_half_a_percent(shape, metric: str) -> None:
    found = assetpipe.decompose(shape(), 0.1, effort="best", metric=metric)
    assert len(found.hulls) > 1
    for hull in found.hulls:
        for bound in (hull.certificate.thickening, hull.certificate.concavity):
            assert bound is not None
            # Of what is nothing beside the tolerance no share is meant.
            assert bound.upper <= 1.005 * bound.lower + 1e-4 * found.epsilon
