"""What is known of a mesh file changes with every file that it is read from."""

import json
import struct
from pathlib import Path

import pytest

from assetpipe.errors import InputError
from assetpipe.pipeline.identity import digest_file, digest_mesh
from assetpipe.pipeline.output import provenance_of
from assetpipe.pipeline.record import read_record


def gltf(*uris: object) -> bytes:
    return json.dumps({"asset": {"version": "2.0"}, "buffers": [{"uri": u} for u in uris]}).encode()


def glb(*uris: object) -> bytes:
    text = gltf(*uris)
    text += b" " * (-len(text) % 4)
    return struct.pack("<4sIIII", b"glTF", 2, 20 + len(text), len(text), 0x4E4F534A) + text


@pytest.mark.parametrize(("name", "make"), [("a.gltf", gltf), ("a.glb", glb)])
def test_buffers_belong_to_a_mesh_however_they_are_named(tmp_path: Path, name: str, make) -> None:
    (tmp_path / "b c.bin").write_bytes(b"1")
    (tmp_path / name).write_bytes(make("b%20c.bin"))
    before = digest_mesh(tmp_path / name)
    (tmp_path / "b c.bin").write_bytes(b"2")
    assert digest_mesh(tmp_path / name) != before


def test_other_peoples_files_are_no_buffers(tmp_path: Path) -> None:
    folder = tmp_path / "in"
    folder.mkdir()
    (tmp_path / "secret").write_bytes(b"1")
    path = folder / "a.gltf"
    path.write_bytes(gltf("../secret", str(tmp_path / "secret"), "%00", "//[", "a" * 5000, 5, []))
    assert digest_mesh(path) == digest_file(path)
    for text in ("[" * 100_000, "[]", "{}", '{"buffers": 5}', '{"buffers": [5]}', "\\"):
        path.write_text(text)
        assert digest_mesh(path) == digest_file(path)


def test_records_without_end_are_none(tmp_path: Path) -> None:
    for name in ("assetpipe.json", "report.json"):
        (tmp_path / name).write_text("[" * 100_000)
    assert provenance_of(tmp_path) is None
    with pytest.raises(InputError, match="not JSON"):
        read_record(tmp_path)
