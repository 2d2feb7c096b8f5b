"""The ladder as a whole: what becomes of a mesh, and what is said about it."""

import numpy as np
import pytest
import trimesh

from assetpipe.errors import LimitError, MeshError
from assetpipe.findings import Severity
from assetpipe.geometry import Mesh, RepairPolicy, Rung, examine, is_solid, repair


def box(size=(1.0, 1.0, 1.0), at=(0.0, 0.0, 0.0)) -> Mesh:
    mesh = trimesh.creation.box(size)
    mesh.apply_translation(at)
    return Mesh.of(mesh)


def join(*meshes: Mesh) -> Mesh:
    offsets = np.cumsum([0, *(len(m.vertices) for m in meshes)])
    return Mesh(
        np.concatenate([m.vertices for m in meshes]),
        np.concatenate([m.faces + at for m, at in zip(meshes, offsets, strict=False)]),
    )


def inverted(mesh: Mesh) -> Mesh:
    return Mesh(mesh.vertices, mesh.faces[:, ::-1])


def soup(mesh: Mesh) -> Mesh:
    return Mesh(mesh.vertices[mesh.faces].reshape(-1, 3), np.arange(mesh.faces.size).reshape(-1, 3))


def test_a_solid_comes_back_unchanged_bit_for_bit():
    mesh = Mesh.of(trimesh.creation.icosphere(subdivisions=3))
    result = repair(mesh)
    assert result.solid is not None
    assert result.solid.digest == mesh.digest
    assert result.steps == ()
    assert result.moved == 0.0


def test_a_triangle_soup_is_welded_exactly():
    result = repair(soup(box()))
    assert result.solid is not None
    assert len(result.solid.vertices) == 8
    assert result.moved == 0.0
    assert result.rung is Rung.WELD


def test_an_inside_out_box_is_turned():
    result = repair(inverted(box()))
    assert result.solid is not None
    assert result.solid.volume == pytest.approx(1.0, rel=1e-12)


def test_overlapping_boxes_are_united_exactly():
    result = repair(join(box(), box(at=(0.5, 0.25, 0.125))))
    assert result.solid is not None
    assert result.solid.volume == pytest.approx(2 - 0.5 * 0.75 * 0.875, rel=1e-12)
    assert result.moved == 0.0


@pytest.mark.parametrize(("cavities", "volume"), [("keep", 1 - 0.125), ("fill", 1.0)])
def test_an_inward_shell_inside_is_a_cavity(cavities, volume):
    hollow = join(box(), inverted(box((0.5, 0.5, 0.5))))
    for mesh in (hollow, inverted(hollow)):
        result = repair(mesh, policy=RepairPolicy(cavities=cavities))
        assert result.solid is not None
        assert result.solid.volume == pytest.approx(volume, rel=1e-12)
        assert result.cavities_kept + result.cavities_filled == 1


def test_an_outward_shell_inside_is_buried():
    result = repair(join(box(), box((0.5, 0.5, 0.5))))
    assert result.solid is not None
    assert result.solid.volume == pytest.approx(1.0, rel=1e-12)


def test_cubes_that_share_an_edge_or_a_corner_come_apart():
    for at in ((1.0, 1.0, 0.0), (1.0, 1.0, 1.0)):
        result = repair(soup(join(box(), box(at=at))))
        assert result.solid is not None
        assert is_solid(result.solid)
        assert result.solid.volume == pytest.approx(2.0, rel=1e-12)


def test_what_moves_by_rounding_only_is_a_note():
    mesh = soup(box(at=(0.7, 0.1, 0.3)))
    vertices = mesh.vertices.copy()
    vertices[0] = np.nextafter(vertices[0], 2.0)
    result = repair(Mesh(vertices, mesh.faces))
    assert result.moved == 0.0
    assert [f.severity for f in result.findings if f.code == "AP201"] == [Severity.NOTE]


def test_a_flat_tetrahedron_is_no_solid():
    """Closed and manifold, but the volume that a turned one has is rounding."""
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    turn = trimesh.transformations.rotation_matrix(1.1, [0.3, -0.7, 0.2])[:3, :3]
    mesh = Mesh(square @ turn.T, np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]))
    result = repair(mesh)
    assert result.solid is not None
    assert result.solid.volume == pytest.approx(mesh.diagonal / 400, rel=1e-6)
    assert repair(mesh, policy=RepairPolicy(mode="strict")).solid is None


def test_no_faces_is_an_error():
    with pytest.raises(MeshError):
        repair(Mesh(np.zeros((0, 3)), np.zeros((0, 3), dtype=int)))


@pytest.mark.parametrize("size", [1e75, 1e308, 1e-75])
def test_what_is_too_large_or_small_to_measure_is_refused(size: float):
    mesh = box().scaled((size, size, size))
    result = repair(mesh)
    assert result.solid is None
    assert [finding.code for finding in result.findings] == ["AP206"]
    with pytest.raises(LimitError, match="coordinates"):
        examine(mesh)
