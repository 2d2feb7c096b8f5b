"""Vertices that no face uses have no influence: neither on sizes nor on what is made of a mesh."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from assetpipe import decompose
from assetpipe.geometry import Mesh, read_mesh, repair


def notched() -> tuple[np.ndarray, np.ndarray]:
    """Two boxes that overlap in part: no solid until they are united."""
    pair = [trimesh.creation.box((1, 1, 0.2)), trimesh.creation.box((0.2, 1, 1))]
    both = trimesh.util.concatenate(pair)
    return np.array(both.vertices), np.array(both.faces)


def with_strays(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same faces; before, between and after their vertices are some far away."""
    far = [[1e3, 0, 0]], [[0, -1e4, 1]], [[7, 7, 7e3]]
    half = len(vertices) // 2
    moved = np.vstack([far[0], vertices[:half], far[1], vertices[half:], far[2]])
    return moved, np.where(faces < half, faces + 1, faces + 2)


def test_sizes_are_of_the_faces() -> None:
    plain, other = Mesh(*notched()), Mesh(*with_strays(*notched()))
    assert other.diagonal == plain.diagonal
    np.testing.assert_array_equal(other.bounds, plain.bounds)
    tidy = other.without_strays()
    np.testing.assert_array_equal(tidy.vertices, plain.vertices)
    np.testing.assert_array_equal(tidy.faces, plain.faces)
    assert tidy.without_strays() is tidy


def test_repair_and_decomposition_are_the_same() -> None:
    plain, other = Mesh(*notched()), Mesh(*with_strays(*notched()))
    first, second = repair(plain), repair(other)
    assert first.as_dict() == second.as_dict()
    assert first.solid is not None
    assert second.solid is not None
    assert first.solid.digest == second.solid.digest
    a, b = decompose(plain, "5%"), decompose(other, "5%")
    assert a.epsilon == b.epsilon == 0.05 * plain.diagonal
    assert [h.vertices.tobytes() for h in a.hulls] == [h.vertices.tobytes() for h in b.hulls]


def test_faces_without_extent_are_no_measure_of_the_budget() -> None:
    """A corner of one lies a kilometre away: the gap of a metre stays open all the same."""
    vertices, faces = notched()
    lid_off = faces[1:]
    far = len(vertices)
    mesh = Mesh(np.vstack([vertices, [[1e3, 0, 0]]]), np.vstack([lid_off, [[0, 0, far]]]))
    plain = repair(Mesh(vertices, lid_off))
    result = repair(mesh)
    assert result.solid is not None
    assert plain.solid is not None
    assert result.solid.volume == plain.solid.volume
    assert result.deviation == plain.deviation


@pytest.mark.parametrize("stray", ["1000 0 0", "nan nan nan", "inf 0 0"])
def test_files_are_read_without_them(stray: str, tmp_path: Path) -> None:
    box = trimesh.creation.box()
    points = "".join(f"v {x} {y} {z}\n" for x, y, z in box.vertices)
    faces = "".join(f"f {a} {b} {c}\n" for a, b, c in box.faces + 2)
    path = tmp_path / "box.obj"
    path.write_text(f"v {stray}\n{points}{faces}")
    mesh = read_mesh(path).mesh
    assert len(mesh.vertices) == 8
    assert mesh.diagonal == pytest.approx(np.sqrt(3))
