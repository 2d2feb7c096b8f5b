"""OBJ, OFF and PLY files, content against ending, and OBJ writing."""

import struct
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from assetpipe.errors import InputError, LimitError, MeshError
from assetpipe.geometry import FileLimits, Mesh, obj_text, read_mesh, write_obj

SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


def read(tmp_path: Path, text: str | bytes, name: str = "a.obj") -> Mesh:
    path = tmp_path / name
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return read_mesh(path).mesh


@pytest.mark.parametrize(
    "face",
    [
        "f 1 2 3",
        "f 1/1/1 2/2/2 3/3/3",
        "f 1//1 2//2 3//3",
        "f 1/4 2/5 3/6",
        "f -4 -3 -2",
        "\tf  1  2\t3  # comment",
        "f 1 2 \\\n3",
        "fo 1 2 3",
    ],
)
def test_obj_faces_in_every_spelling(tmp_path: Path, face: str) -> None:
    mesh = read(tmp_path, SQUARE + face + "\n")
    assert mesh.faces.tolist() == [[0, 1, 2]]
    assert mesh.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0]]


def test_obj_indented_with_carriage_returns_and_colours(tmp_path: Path) -> None:
    text = "\ufeff# x\r\n  v 0 0 0 1 0 0\r\n\tv 1 0 0 1.0\r\nv 1 1 0\r\n  f 1 2 3\r\n"
    assert read(tmp_path, text).faces.tolist() == [[0, 1, 2]]


def test_obj_keeps_vertices_together_across_texture_seams_and_groups(tmp_path: Path) -> None:
    text = SQUARE + (
        "vt 0 0\nvt 1 1\nmtllib a.mtl\no x\nusemtl m\nf 1/1 2/1 3/1\no y\nusemtl n\nf 1/2 3/2 4/2\n"
    )
    mesh = read(tmp_path, text)
    assert len(mesh.vertices) == 4
    assert mesh.faces.tolist() == [[0, 1, 2], [0, 2, 3]]


def test_negative_indices_count_from_the_vertices_before(tmp_path: Path) -> None:
    text = SQUARE + "f -4 -3 -2\nv 5 5 5\nv 6 5 5\nv 5 6 5\nf -3 -2 -1\n"
    mesh = read(tmp_path, text)
    assert mesh.faces.tolist() == [[0, 1, 2], [3, 4, 5]]
    assert mesh.vertices[3:].tolist() == [[5, 5, 5], [6, 5, 5], [5, 6, 5]]


def test_concave_polygons_are_not_folded_over(tmp_path: Path) -> None:
    arrow = "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 3.5 0.5 0\nv 0 4 0\nf 1 2 3 4 5\n"
    mesh = read(tmp_path, arrow)
    signed = np.cross(
        mesh.vertices[mesh.faces[:, 1]] - mesh.vertices[mesh.faces[:, 0]],
        mesh.vertices[mesh.faces[:, 2]] - mesh.vertices[mesh.faces[:, 0]],
    )[:, 2]
    x, y = np.array([[0, 0], [4, 0], [4, 4], [3.5, 0.5], [0, 4]]).T
    shoelace = 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))
    assert (signed > 0).all()
    assert signed.sum() / 2 == pytest.approx(shoelace)


@pytest.mark.parametrize(
    ("text", "line", "reason"),
    [
        (SQUARE + "f 1 2 5\n", 5, "names vertex 5, but the file has 4"),
        (SQUARE + "f 0 1 2\n", 5, "names vertex 0"),
        (SQUARE + "f -5 1 2\n", 5, "names vertex -5"),
        (SQUARE + "f 1 2 99999999999999999999\n", 5, "not a number"),
        (SQUARE + "\nf 1 2 x\n", 6, "'x' is not a number"),
        ("v 0 0 0\nv 1 0\nv 1 1 0\nf 1 2 3\n", 2, "2 coordinates"),
        ("v 0 0 0\nv 1 0 0,5\nv 1 1 0\nf 1 2 3\n", 2, "'0,5' is not a number"),
    ],
)
def test_broken_obj_is_located(tmp_path: Path, text: str, line: int, reason: str) -> None:
    with pytest.raises(InputError, match=reason) as caught:
        read(tmp_path, text)
    assert caught.value.location is not None
    assert caught.value.location.line == line


def test_obj_without_faces_or_with_nan(tmp_path: Path) -> None:
    with pytest.raises(MeshError, match="no triangles"):
        read(tmp_path, SQUARE)
    with pytest.raises(MeshError, match="vertex 1 is not finite"):
        read(tmp_path, "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n")


def test_obj_limits_count_triangles_of_polygons(tmp_path: Path) -> None:
    path = tmp_path / "a.obj"
    path.write_text(SQUARE + "f 1 2 3 4\n")
    with pytest.raises(LimitError, match="2 faces"):
        read_mesh(path, limits=FileLimits(max_faces=1))


@pytest.mark.parametrize("header", ["OFF", "COFF", "# made by hand\nOFF", "NOFF #x"])
def test_off(tmp_path: Path, header: str) -> None:
    text = f"{header}\n# c\n4 2 0\n0 0 0 9\n1 0 0\n\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3 255 0 0\n"
    assert read(tmp_path, text, "a.off").faces.tolist() == [[0, 1, 2], [0, 2, 3]]


@pytest.mark.parametrize(
    ("text", "line", "reason"),
    [
        ("OFF\n4 1 0\n0 0 0\n", 2, "4 vertices and 1 faces promised"),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1\n3 0 1 2\n", 5, "2 coordinates"),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n", 6, "names vertex 7"),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n9 0 1 2\n", 6, "3 of 9 corners"),
        ("OFF\nx y z\n", 2, "'x' is not a number"),
    ],
)
def test_broken_off_is_located(tmp_path: Path, text: str, line: int, reason: str) -> None:
    with pytest.raises(InputError, match=reason) as caught:
        read(tmp_path, text, "a.off")
    assert caught.value.location is not None
    assert caught.value.location.line == line


@pytest.mark.parametrize("encoding", ["ascii", "binary"])
def test_ply(tmp_path: Path, encoding: str) -> None:
    shape = trimesh.creation.icosphere(subdivisions=2, radius=0.3)
    path = tmp_path / "a.PLY"
    path.write_bytes(shape.export(file_type="ply", encoding=encoding))
    mesh = read_mesh(path).mesh
    np.testing.assert_allclose(mesh.vertices, shape.vertices, rtol=1e-6, atol=1e-9)
    np.testing.assert_array_equal(mesh.faces, shape.faces)


CUBE = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
QUADS = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]


@pytest.mark.parametrize("order", ["ascii", "binary_little_endian", "binary_big_endian"])
@pytest.mark.parametrize("sizes", ["quads", "quads and triangles"])
def test_ply_of_polygons(tmp_path: Path, order: str, sizes: str) -> None:
    faces = list(QUADS)
    if sizes == "quads and triangles":
        faces[2:4] = [part for a, b, c, d in faces[2:4] for part in ([a, b, c], [a, c, d])]
    header = (
        f"ply\nformat {order} 1.0\ncomment by hand\nelement vertex 8\nproperty float x\n"
        "property float y\nproperty float z\nproperty uchar red\nelement edge 1\n"
        f"property int vertex1\nproperty int vertex2\nelement face {len(faces)}\n"
        "property list uchar float texcoord\nproperty uchar flags\n"
        "property list uchar int vertex_indices\nend_header\n"
    )
    if order == "ascii":
        rows = [" ".join(map(str, [*point, 255])) for point in CUBE] + ["0 1"]
        rows += [" ".join(map(str, [1, 0.5, 7, len(face), *face])) for face in faces]
        data = ("\n".join(rows) + "\n").encode()
    else:
        e = "<" if order == "binary_little_endian" else ">"
        data = b"".join(struct.pack(f"{e}3fB", *point, 255) for point in CUBE)
        data += struct.pack(f"{e}2i", 0, 1)
        for face in faces:
            data += struct.pack(f"{e}BfBB{len(face)}i", 1, 0.5, 7, len(face), *face)
    path = tmp_path / "a.ply"
    path.write_bytes(header.encode() + data)
    mesh = read_mesh(path).mesh
    assert len(mesh.faces) == 12
    assert mesh.volume == pytest.approx(1.0)
    path.write_bytes(header.encode() + data[:-7])
    with pytest.raises(InputError, match="truncated"):
        read_mesh(path)


@pytest.mark.parametrize("order", ["ascii", "binary_little_endian"])
def test_ply_with_an_element_of_no_rows(tmp_path: Path, order: str) -> None:
    header = (
        f"ply\nformat {order} 1.0\nelement edge 0\nproperty int vertex1\nproperty int vertex2\n"
        "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 1\nproperty list uchar int vertex_index\nend_header\n"
    )
    data = b"0 0 0 1 0 0 0 1 0 3 0 1 2\n"
    if order != "ascii":
        data = struct.pack("<9fB3i", 0, 0, 0, 1, 0, 0, 0, 1, 0, 3, 0, 1, 2)
    path = tmp_path / "a.ply"
    path.write_bytes(header.encode() + data)
    assert read_mesh(path).mesh.area == pytest.approx(0.5)


def test_a_concave_polygon_of_a_ply_does_not_fold_over(tmp_path: Path) -> None:
    arrow = "0 0 0\n2 0 0\n2 2 0\n1.5 0.5 0\n"
    text = (
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
        "property float z\nelement face 1\nproperty list uchar int vertex_index\nend_header\n"
    )
    assert read(tmp_path, text + arrow + "4 0 1 2 3\n", "a.ply").area == pytest.approx(1.0)


def test_ply_that_lies_is_refused_before_memory_is_asked_for(tmp_path: Path) -> None:
    path = tmp_path / "a.ply"
    data = trimesh.creation.box().export(file_type="ply")
    path.write_bytes(data.replace(b"element vertex 8", b"element vertex 800000"))
    with pytest.raises(InputError, match="truncated"):
        read_mesh(path)
    path.write_bytes(data[:-20])
    with pytest.raises(InputError):
        read_mesh(path)
    path.write_bytes(b"ply\nformat ascii 1.0\nelement vertex x\nend_header\n")
    with pytest.raises(InputError, match="unreadable 'element vertex x'") as caught:
        read_mesh(path)
    assert caught.value.location is not None
    assert caught.value.location.line == 3


def test_content_wins_over_the_ending(tmp_path: Path) -> None:
    path = tmp_path / "a.stl"
    path.write_text(SQUARE + "f 1 2 3\n")
    loaded = read_mesh(path)
    assert loaded.format == "obj"
    assert loaded.notes == ("named '.stl', but its content is OBJ",)
    other = tmp_path / "mesh"
    other.write_bytes(trimesh.creation.box().export(file_type="stl"))
    assert read_mesh(other).format == "stl"


def test_unknown_content_names_the_formats(tmp_path: Path) -> None:
    path = tmp_path / "a.step"
    path.write_text("ISO-10303-21;")
    with pytest.raises(InputError, match=r"mesh format '\.step' not found.*\.dae, \.glb"):
        read_mesh(path)


def test_obj_text_is_shortest_and_the_same_always(tmp_path: Path) -> None:
    mesh = Mesh(np.array([[0.1, -0.0, 1e-30], [1 / 3, 2.0, 1e22], [5.0, 0.5, -7.0]]), [[0, 1, 2]])
    text = obj_text(mesh, comment="one\ntwo")
    assert text == (
        b"# one\n# two\nv 0.1 0.0 1e-30\nv 0.3333333333333333 2.0 1e+22\nv 5.0 0.5 -7.0\nf 1 2 3\n"
    )
    write_obj(mesh, tmp_path / "a.obj", comment="one\ntwo")
    assert (tmp_path / "a.obj").read_bytes() == text


@given(
    st.lists(
        st.tuples(*[st.floats(allow_nan=False, allow_infinity=False)] * 3), min_size=3, max_size=9
    )
)
def test_obj_text_reads_back_to_the_very_same_numbers(points: list[tuple[float, ...]]) -> None:
    from assetpipe.geometry.formats import obj

    mesh = Mesh(np.array(points), [[0, 1, 2]])
    raw = obj.read(obj_text(mesh), Path("a.obj"), FileLimits())
    np.testing.assert_array_equal(raw.vertices, mesh.vertices)
    np.testing.assert_array_equal(raw.faces, mesh.faces)
