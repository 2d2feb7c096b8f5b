"""STL files: what kind they are, and what is wrong with broken ones."""

import struct
from pathlib import Path

import numpy as np
import pytest
import trimesh

from assetpipe.errors import InputError, LimitError, MeshError
from assetpipe.geometry import FileLimits, read_mesh

FACET = """facet normal 0 0 1
 outer loop
  vertex 0 0 0
  vertex 1 0 0
  vertex 0 1 0
 endloop
endfacet
"""


def binary(triangles: np.ndarray, header: bytes = b"", count: int | None = None) -> bytes:
    records = b"".join(
        struct.pack("<12fH", 0, 0, 0, *t.reshape(-1), 0) for t in triangles.astype(np.float32)
    )
    number = len(triangles) if count is None else count
    return header.ljust(80, b" ")[:80] + struct.pack("<I", number) + records


@pytest.fixture
def triangles() -> np.ndarray:
    return np.arange(36, dtype=np.float32).reshape(4, 3, 3) ** 2


@pytest.mark.parametrize("header", [b"", b"solid exported by someone", b"solid facet normal"])
def test_length_decides_that_a_file_is_binary(
    tmp_path: Path, triangles: np.ndarray, header: bytes
) -> None:
    path = tmp_path / "a.stl"
    path.write_bytes(binary(triangles, header))
    loaded = read_mesh(path)
    assert loaded.format == "stl"
    np.testing.assert_array_equal(loaded.mesh.vertices[loaded.mesh.faces], triangles)


def test_ascii(tmp_path: Path) -> None:
    path = tmp_path / "a.STL"
    path.write_text(f"solid a\n{FACET}endsolid a\nsolid b\r\n{FACET.upper()}ENDSOLID b\n")
    loaded = read_mesh(path)
    assert loaded.mesh.faces.tolist() == [[0, 1, 2], [3, 4, 5]]
    assert loaded.mesh.vertices[:3].tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]


def test_agrees_with_trimesh(tmp_path: Path) -> None:
    shape = trimesh.creation.annulus(0.1, 0.3, 0.2)
    for kind in ("stl", "stl_ascii"):
        path = tmp_path / f"{kind}.stl"
        exported = shape.export(file_type=kind)
        path.write_bytes(exported.encode() if isinstance(exported, str) else exported)
        mesh = read_mesh(path).mesh
        oracle = trimesh.load(path, process=False)
        np.testing.assert_allclose(mesh.vertices[mesh.faces], oracle.triangles, rtol=1e-7)


def test_a_count_that_lies_is_no_crash(tmp_path: Path, triangles: np.ndarray) -> None:
    path = tmp_path / "a.stl"
    path.write_bytes(binary(triangles, count=4_000_000_000))
    with pytest.raises(InputError, match="promises 4,000,000,000 triangles, the file holds 4"):
        read_mesh(path)


def test_bytes_behind_the_last_triangle_are_told(tmp_path: Path, triangles: np.ndarray) -> None:
    path = tmp_path / "a.stl"
    path.write_bytes(binary(triangles) + b"\0" * 7)
    loaded = read_mesh(path)
    assert len(loaded.mesh.faces) == 4
    assert loaded.notes == ("7 bytes after the last triangle ignored",)


@pytest.mark.parametrize(
    ("text", "line", "reason"),
    [
        ("solid\n" + FACET.replace("1 0 0", "1 0 zero") + "endsolid", 5, "'zero' is not a number"),
        ("solid\n" + FACET.replace("1 0 0", "1 0") + "endsolid", 5, "2 coordinates"),
        ("solid\n" + FACET.replace("  vertex 1 0 0\n", "") + "endsolid", 6, "2 vertices"),
        ("solid\n" + FACET + FACET[:60], 11, "truncated"),
    ],
)
def test_broken_ascii_is_located(tmp_path: Path, text: str, line: int, reason: str) -> None:
    path = tmp_path / "a.stl"
    path.write_text(text)
    with pytest.raises(InputError, match=reason) as caught:
        read_mesh(path)
    assert caught.value.location is not None
    assert caught.value.location.file == path
    assert caught.value.location.line == line


@pytest.mark.parametrize(
    ("content", "error", "reason"),
    [
        (b"", InputError, "empty"),
        (b"short", InputError, "shorter than the header"),
        (binary(np.zeros((0, 3, 3))), MeshError, "no triangles"),
        (b"solid nothing\nendsolid nothing\n", MeshError, "no triangles"),
        (binary(np.full((1, 3, 3), np.nan)), MeshError, "not finite"),
        (binary(np.full((1, 3, 3), np.inf)), MeshError, "not finite"),
    ],
)
def test_useless_files(tmp_path: Path, content: bytes, error: type[Exception], reason: str) -> None:
    path = tmp_path / "a.stl"
    path.write_bytes(content)
    with pytest.raises(error, match=reason) as caught:
        read_mesh(path)
    assert str(path) in str(caught.value)


def test_limits(tmp_path: Path, triangles: np.ndarray) -> None:
    path = tmp_path / "a.stl"
    path.write_bytes(binary(triangles))
    with pytest.raises(LimitError, match="4 faces exceed the limit of 3"):
        read_mesh(path, limits=FileLimits(max_faces=3))
    with pytest.raises(LimitError, match="bytes exceed"):
        read_mesh(path, limits=FileLimits(max_bytes=100))


def test_missing_file_and_folder(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        read_mesh(tmp_path / "none.stl")
    with pytest.raises(InputError, match="cannot be read"):
        read_mesh(tmp_path)


def test_a_web_page_is_called_one(tmp_path: Path) -> None:
    page = tmp_path / "a.stl"
    page.write_bytes(b"\n<!DOCTYPE html><html><body>" + b"not found " * 40 + b"</body></html>")
    with pytest.raises(InputError, match="web page"):
        read_mesh(page)
