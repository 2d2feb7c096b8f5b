"""Files with random damage: read or refused with a typed error, never anything else."""

import random
import warnings
from pathlib import Path

import pytest
import trimesh

from assetpipe.errors import AssetpipeError
from assetpipe.geometry import FileLimits, Mesh, read_mesh

WORDS = [b"-1", b"99999999999", b"1e999", b"nan", b"", b"<", b">", b'"', b"{", b"]", b"null"]
WORDS += [b"\0", b"\xff\xff\xff\xff", b"#x", b" ", b"\n", b"/"]


def damaged(data: bytes, chance: random.Random) -> bytes:
    text = bytearray(data)
    for _ in range(chance.choice([1, 1, 2, 6])):
        at = chance.randrange(len(text))
        kind = chance.random()
        if kind < 0.3:
            text[at : at + 1] = bytes([chance.randrange(256)])
        elif kind < 0.5:
            del text[at : at + chance.randrange(1, 40)]
        elif kind < 0.8:
            text[at : at + chance.randrange(6)] = chance.choice(WORDS)
        elif kind < 0.9:
            text[at:at] = text[at : at + chance.randrange(1, 200)]
        else:
            del text[at:]
        if not text:
            return b"\0"
    return bytes(text)


def outcome(path: Path) -> Mesh | AssetpipeError:
    try:
        return read_mesh(path, limits=FileLimits(max_faces=10_000)).mesh
    except AssetpipeError as error:
        return error


@pytest.mark.parametrize("kind", ["stl", "stl_ascii", "obj", "off", "ply", "dae", "glb", "gltf"])
def test_damage_is_survived(tmp_path: Path, kind: str) -> None:
    shape = trimesh.creation.icosphere(subdivisions=1)
    exported = shape.export(file_type=kind)
    if isinstance(exported, dict):
        (tmp_path / "gltf_buffer_0.bin").write_bytes(exported["gltf_buffer_0.bin"])
        exported = exported["model.gltf"]
    data = exported.encode() if isinstance(exported, str) else exported
    path = tmp_path / f"a.{kind.removesuffix('_ascii')}"
    chance = random.Random(kind)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for _ in range(150):
            path.write_bytes(damaged(data, chance))
            result = outcome(path)
            if isinstance(result, Mesh):
                assert 0 < len(result.faces) <= 10_000
            else:
                assert result.location is not None
                assert result.location.file == path
