"""FCL lets a triangle without area touch spheres far away; the contact truth must not."""

import numpy as np

from assetpipe.geometry import Mesh
from assetpipe.validation.contact import contact_truth


def plate(size, centre):
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    faces = np.array(
        [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
         [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
    )  # fmt: skip
    return Mesh(corners * np.asarray(size) / 2 + np.asarray(centre), faces)


def with_collinear_vertex(mesh):
    """The same box with a vertex in the middle of an edge, joined by a face without area."""
    middle = (mesh.vertices[0] + mesh.vertices[1]) / 2
    faces = [f for f in mesh.faces.tolist() if f != [0, 5, 1]]
    return Mesh(
        np.vstack([mesh.vertices, middle]), np.array([*faces, [0, 5, 8], [8, 5, 1], [0, 8, 1]])
    )


def test_exact_hulls_of_plates_have_no_clearance_error():
    plates = [
        plate((0.36, 0.45, 0.01), (0.0, 0.0, 0.005)),
        plate((0.36, 0.01, 0.2), (0.0, 0.22, 0.11)),
        plate((0.36, 0.01, 0.2), (0.0, -0.22, 0.11)),
    ]
    joined = Mesh(
        np.vstack([p.vertices for p in plates]),
        np.vstack([p.faces + 8 * k for k, p in enumerate(plates)]),
    )
    hulls = [with_collinear_vertex(p) for p in plates]
    truth = contact_truth(joined, hulls, 0.007, samples=1500, seed=3)
    assert truth.beyond.count == 0
    assert truth.clearance_error.greatest < 1e-8
