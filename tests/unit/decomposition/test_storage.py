"""Decompositions in files."""

from __future__ import annotations

import hashlib
import json

import numpy as np
import pytest

import assetpipe
from assetpipe.decomposition import Decomposition
from assetpipe.decomposition.storage import KIND, decode, encode
from assetpipe.errors import InputError


def stairs():
    import trimesh

    steps = [(0.03, 0.02, 0.01 * (k + 1)) for k in range(4)]
    import manifold3d

    solid = manifold3d.Manifold()
    for k, size in enumerate(steps):
        solid += manifold3d.Manifold.cube(list(size)).translate([0.03 * k, 0.0, 0.0])
    made = solid.to_mesh64()
    return trimesh.Trimesh(np.array(made.vert_properties)[:, :3], np.array(made.tri_verts))


@pytest.fixture(scope="module")
def found() -> Decomposition:
    return assetpipe.decompose(stairs(), 0.001)


@pytest.fixture
def stored(found, tmp_path):
    path = tmp_path / "stairs.apd"
    found.save(path)
    return path


def same(a: Decomposition, b: Decomposition) -> bool:
    return len(a.hulls) == len(b.hulls) and all(
        np.array_equal(x.vertices, y.vertices)
        and np.array_equal(x.faces, y.faces)
        and x.volume == y.volume
        and x.certificate == y.certificate
        for x, y in zip(a.hulls, b.hulls, strict=True)
    )


def test_what_is_read_is_what_was_written(found, stored):
    read = Decomposition.load(stored)
    assert same(read, found)
    assert read.certificate == found.certificate
    assert read.coverage == found.coverage
    assert (read.engine, read.tolerance, read.epsilon) == (
        found.engine,
        found.tolerance,
        found.epsilon,
    )
    assert read.as_dict() == found.as_dict()


def test_coarser_levels_are_read_without_the_mesh(found, stored):
    read = Decomposition.load(stored)
    for count in range(1, len(found.hulls) + 1):
        assert same(read.at(max_hulls=count), found.at(max_hulls=count))
    assert same(read.at(tolerance=0.02), found.at(tolerance=0.02))


def test_a_level_is_stored_as_a_level(found, tmp_path):
    level = found.at(max_hulls=2)
    level.save(tmp_path / "level.apd")
    read = Decomposition.load(tmp_path / "level.apd")
    assert same(read, level)
    assert same(read.at(max_hulls=1), found.at(max_hulls=1))


def test_equal_values_give_equal_bytes(found, stored):
    again = assetpipe.decompose(stairs(), 0.001, threads=1)
    assert encode(again) == stored.read_bytes()
    assert encode(Decomposition.load(stored)) == stored.read_bytes()


def test_a_repair_is_told_in_numbers(tmp_path):
    mesh = stairs()
    mesh.faces = mesh.faces[1:]
    found = assetpipe.decompose(mesh, 0.001)
    assert found.repair is not None
    found.save(tmp_path / "repaired.apd")
    read = Decomposition.load(tmp_path / "repaired.apd")
    assert read.repair is not None
    assert read.repair.moved == found.repair.moved
    assert read.repair.as_dict() == found.repair.as_dict()


def test_hulls_of_other_engines_have_no_levels(tmp_path):
    found = assetpipe.decomposition.decompose_with("hull", stairs(), 0.001)
    found.save(tmp_path / "hull.apd")
    read = Decomposition.load(tmp_path / "hull.apd")
    assert same(read, found)
    assert read.nodes == ()


def changed(data: bytes, **values) -> bytes:
    """The file with another head, and a digest that fits."""
    start, _, body = data.split(b"\n", 2)
    line, _, arrays = body.partition(b"\n")
    head = json.loads(line)
    for name, value in values.items():
        at = head
        *way, last = name.split("__")
        for step in way:
            at = at[int(step) if step.isdigit() else step]
        at[int(last) if last.isdigit() else last] = value
    body = json.dumps(head).encode() + b"\n" + arrays
    return start + b"\n" + hashlib.sha256(body).hexdigest().encode() + b"\n" + body


@pytest.mark.parametrize(
    ("values", "where"),
    [
        ({"engine": "magic"}, "head: engine"),
        ({"more": 1}, "head: more"),
        ({"epsilon": -1.0}, "head: epsilon"),
        ({"epsilon": float("nan")}, "head"),
        ({"nodes__0__vertices": 10**6}, "arrays"),
        ({"nodes__0__vertices": 2}, "head: nodes.0.vertices"),
        ({"nodes__0__thickening": [2.0, 1.0]}, "nodes.0.thickening"),
        ({"nodes__0__children": [0, 1]}, "nodes.0.children"),
        ({"nodes__4__children": [0, 0]}, "nodes.4.children"),
        ({"nodes__5__children": [0, 1], "nodes__6__children": [0, 1]}, "nodes.[56].children"),
        ({"level": [0, 1]}, "level"),
        ({"level": [0, 0, 1, 2, 3]}, "level.1"),
        ({"level": [99]}, "level.0"),
        ({"nodes__0__primitive": {"kind": "sphere", "frame": [[0.0] * 4] * 4, "size": [1.0, 1.0]}},
         "nodes.0.primitive"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_named(found, stored, values, where):
    assert len(found.hulls) == 4, "the places above are those of four hulls"
    with pytest.raises(InputError, match=where):
        decode(changed(stored.read_bytes(), **values))


def test_vertices_that_are_not_finite_are_named(stored):
    start, _, body = stored.read_bytes().split(b"\n", 2)
    line, _, arrays = body.partition(b"\n")
    body = line + b"\n" + np.array([np.nan]).tobytes() + arrays[8:]
    data = start + b"\n" + hashlib.sha256(body).hexdigest().encode() + b"\n" + body
    with pytest.raises(InputError, match=r"nodes\.0: vertex 0 is not finite"):
        decode(data)


def test_damage_another_version_and_other_files_are_told_apart(stored, tmp_path):
    data = stored.read_bytes()
    place = tmp_path / "wrong.apd"
    for wrong, said in (
        (data[:-1], "damaged"),
        (data[:40], "damaged"),
        (data.replace(KIND + b"1", KIND + b"2", 1), "version '2'"),
        (b"solid thing\n", "no decomposition"),
        (b"", "no decomposition"),
    ):
        place.write_bytes(wrong)
        with pytest.raises(InputError, match=said) as caught:
            Decomposition.load(place)
        assert caught.value.location.file == place


def test_a_place_that_cannot_be_written_is_named(found, tmp_path):
    with pytest.raises(InputError, match="cannot be written"):
        found.save(tmp_path / "no" / "such" / "folder.apd")
    assert list(tmp_path.iterdir()) == []
