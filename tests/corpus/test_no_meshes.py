"""Arrays that are no mesh: each door refuses them with a typed, located error."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from hard_solids import angle_plate
from mesh_parts import box

from assetpipe import decompose
from assetpipe.decomposition import certify, inner_hulls
from assetpipe.errors import LimitError, MeshError
from assetpipe.geometry import Mesh, repair

VERTICES, FACES = box()


def with_vertex(value: float) -> np.ndarray:
    vertices = VERTICES.copy()
    vertices[5, 1] = value
    return vertices


def with_index(value: int) -> np.ndarray:
    faces = FACES.copy()
    faces[7, 2] = value
    return faces


@dataclass(frozen=True)
class NoMesh:
    """Vertices, faces, and what the error must say."""

    name: str
    vertices: Any
    faces: Any
    says: str


ROWS = (
    NoMesh("NaN", with_vertex(np.nan), FACES, "vertex 5 is not finite"),
    NoMesh("Inf", with_vertex(np.inf), FACES, "vertex 5 is not finite"),
    NoMesh("-Inf", with_vertex(-np.inf), FACES, "vertex 5 is not finite"),
    NoMesh("index too large", VERTICES, with_index(8), r"face 7 names vertex \[.*8\]"),
    NoMesh("index far too large", VERTICES, with_index(2**62), "face 7 names vertex"),
    NoMesh("index below zero", VERTICES, with_index(-1), r"face 7 names vertex \[.*-1\]"),
    NoMesh("faces without vertices", np.zeros((0, 3)), FACES, "face 0 names vertex"),
    NoMesh("faces of four corners", VERTICES, np.array([[0, 1, 2, 3]]), r"shape \(m, 3\)"),
    NoMesh("vertices in the plane", VERTICES[:, :2], FACES, r"shape \(n, 3\)"),
    NoMesh("faces that are no integers", VERTICES, FACES + 0.5, "integers"),
    NoMesh("words", [["a", "b", "c"]], FACES, "arrays of numbers"),
)

DOORS = {
    "Mesh": Mesh,
    "decompose": lambda vertices, faces: decompose((vertices, faces), 0.01),
    "inner_hulls": lambda vertices, faces: inner_hulls((vertices, faces), 0.01),
}


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.name)
@pytest.mark.parametrize("door", DOORS.values(), ids=DOORS.keys())
def test_what_is_no_mesh_is_refused(row: NoMesh, door):
    with pytest.raises(MeshError, match=row.says):
        door(row.vertices, row.faces)


@pytest.mark.parametrize(
    "mesh",
    [
        Mesh(np.zeros((0, 3)), np.zeros((0, 3), dtype=int)),
        Mesh(VERTICES, np.zeros((0, 3), dtype=int)),
    ],
    ids=["empty", "vertices without faces"],
)
def test_nothing_is_no_solid(mesh: Mesh):
    with pytest.raises(MeshError):
        decompose(mesh, 0.01)
    with pytest.raises(MeshError):
        certify(mesh, [Mesh(VERTICES, FACES)])
    with pytest.raises(MeshError):
        repair(mesh)


def test_nothing_is_certified_towards_what_is_open():
    hull = Mesh(VERTICES, FACES)
    assert certify(hull, [hull])[0].upper < 1e-6
    with pytest.raises(MeshError, match="closed"):
        certify(Mesh(VERTICES, FACES[1:]), [hull])


@pytest.mark.parametrize("factor", [1e-320, 1e-160, 1e-100, 1e-50, 1e50, 1e100, 1e150, 1e300])
def test_sizes_beyond_what_products_of_lengths_can_hold_are_refused_or_right(factor: float):
    angle = Mesh(*angle_plate(0.2)).scaled(factor)
    if not 1e-60 < factor < 1e60:
        with pytest.raises(LimitError, match="volumes can be computed"):
            decompose(angle, "2%")
        return
    d = decompose(angle, "2%")
    assert len(d.hulls) == 2
    assert 0 <= d.certificate.lower <= d.certificate.upper <= d.epsilon
