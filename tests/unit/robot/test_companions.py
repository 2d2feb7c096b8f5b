"""Files that a stranger's mesh names: those that are there, soon, whatever else it says."""

import json
from pathlib import Path
from time import process_time

import pytest

from assetpipe.robot.companions import companions

NO_NAMES = ("//[", "a%00b.png", "k" * 5000 + ".png", "circle.png", "../../etc/passwd", "/dev/zero")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "a.png").write_bytes(b"png")
    (tmp_path / "circle.png").symlink_to("circle.png")
    return tmp_path


def named(mesh: Path) -> list[str]:
    return [str(companion.reference) for companion in companions(mesh, mesh.parent)]


def test_gltf_images_of_any_name(folder: Path) -> None:
    uris = [*NO_NAMES, "\ud800.png", "a.png"]
    (folder / "m.gltf").write_text(json.dumps({"images": [{"uri": uri} for uri in uris]}))
    assert named(folder / "m.gltf") == ["a.png"]


def test_textures_of_any_name(folder: Path) -> None:
    (folder / "m.obj").write_text("mtllib b.mtl\n")
    lines = "".join(f"map_Kd {name}\n" for name in [*NO_NAMES, "a\0b.png"])
    (folder / "b.mtl").write_text(lines + "map_Kd -s 1 1 1 a.png\n")
    assert named(folder / "m.obj") == ["b.mtl", "a.png"]


def test_names_of_many_words_and_many_names_take_no_time(folder: Path) -> None:
    (folder / "m.obj").write_text("mtllib b.mtl\n" + "mtllib c d e f g h i j k l\n" * 50_000)
    (folder / "b.mtl").write_text("map_Kd " + "x " * 30_000 + "a.png\n" + "bump y z\n" * 50_000)
    clock = process_time()
    assert named(folder / "m.obj") == ["b.mtl", "a.png"]
    assert process_time() - clock < 5.0
