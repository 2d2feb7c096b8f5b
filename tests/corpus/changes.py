"""Ways to hand in the same solid that must not matter, or only by rounding."""

from __future__ import annotations

import numpy as np
import trimesh

from assetpipe.geometry import Mesh

_ROTATION = trimesh.transformations.rotation_matrix(1.1, [0.3, -0.7, 0.2])[:3, :3]


def plain(mesh: Mesh) -> Mesh:
    return mesh


def rotated(mesh: Mesh) -> Mesh:
    return Mesh(mesh.vertices @ _ROTATION.T, mesh.faces)


def mirrored(mesh: Mesh) -> Mesh:
    return mesh.scaled((-1, 1, 1))


def duplicated(mesh: Mesh) -> Mesh:
    """Every vertex and every face twice, as exporters of double-sided parts leave them."""
    n = len(mesh.vertices)
    return Mesh(np.tile(mesh.vertices, (2, 1)), np.vstack([mesh.faces, mesh.faces + n]))


def permuted(mesh: Mesh) -> Mesh:
    """Other orders of vertices and faces, and other first corners."""
    random = np.random.default_rng(3)
    order = random.permutation(len(mesh.vertices))
    faces = np.argsort(order)[mesh.faces][random.permutation(len(mesh.faces))]
    corner = random.integers(0, 3, len(faces))[:, None] + np.arange(3)
    return Mesh(mesh.vertices[order], np.take_along_axis(faces, corner % 3, axis=1))


def tiny(mesh: Mesh) -> Mesh:
    """A micrometre instead of a metre."""
    return mesh.scaled(1e-6)


def huge(mesh: Mesh) -> Mesh:
    """A kilometre instead of a metre."""
    return mesh.scaled(1e3)


def far(mesh: Mesh) -> Mesh:
    """Ten thousand times its size from the origin."""
    return Mesh(mesh.vertices + np.array([1e4, -2e4, 1.5e4]), mesh.faces)


def stored(mesh: Mesh) -> Mesh:
    """Turned, then as a binary STL holds it: flat faces are flat to single precision only."""
    return Mesh(rotated(mesh).vertices.astype(np.float32), mesh.faces)


CHANGES = (plain, rotated, mirrored, duplicated, permuted, tiny, huge, far)
