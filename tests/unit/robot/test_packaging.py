"""OUT is complete: every reference resolves from where the new URDF lies."""

import shutil
from pathlib import Path, PurePosixPath

import numpy as np
import pytest
import trimesh
import yourdfpy

from assetpipe.robot import (
    HullMesh,
    Layout,
    MeshShape,
    NewCollision,
    Resolver,
    Robot,
    lay_out,
    read_robot,
    write_urdf,
)
from assetpipe.robot.packaging import safe_name

MESH = trimesh.creation.box((0.1, 0.2, 0.3)).export(file_type="obj")


def mesh(path: Path) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(MESH)
    return path


def urdf(path: Path, *, collisions: tuple[str, ...], visuals: tuple[str, ...] = ()) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    shape = '<{0}><geometry><mesh filename="{1}"/></geometry></{0}>'
    inside = "".join(shape.format("visual", uri) for uri in visuals)
    inside += "".join(shape.format("collision", uri) for uri in collisions)
    inertia = '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
    inside += f'<inertial><mass value="1"/>{inertia}</inertial>'
    path.write_text(f'<robot name="r"><link name="Arm link">{inside}</link></robot>')
    return path


def manifest(folder: Path, name: str) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "package.xml").write_text(f"<package><name>{name}</name></package>")


def build(description: Path, out: Path, *, shelf: str = "") -> tuple[Robot, Layout]:
    """What a pipeline does with a layout; every collision mesh gets two hulls."""
    robot = read_robot(description, resolver=Resolver()).robot
    keys = [
        (link.name, c.index)
        for link in robot.links
        for c in link.collisions
        if isinstance(c.shape, MeshShape) and c.shape.path
    ]
    layout = lay_out(robot, replaced=keys, shelf=shelf)
    for copy in layout.copies:
        (out / copy.to).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(copy.source, out / copy.to)
    new = {}
    for key in keys:
        place = layout.hulls[("collision", *key)]
        new[key] = [NewCollision(HullMesh(place.uri(k))) for k in range(2)]
        for k in range(2):
            assert not (out / place.path(k)).exists()
            mesh(out / place.path(k))
    (out / layout.urdf).parent.mkdir(parents=True, exist_ok=True)
    (out / layout.urdf).write_bytes(write_urdf(robot, new))
    return robot, layout


def check(out: Path, layout: Layout) -> None:
    """All references resolve inside of OUT, for us, PyBullet and (but for packages that are
    called like a folder of meshes) yourdfpy."""
    path = out / layout.urdf
    robot = read_robot(path, resolver=Resolver()).robot
    assert robot.references
    for reference in robot.references:
        found = reference.resolution
        assert found.path is not None, (reference.uri, found.tried)
        assert found.path.resolve().is_relative_to(out.resolve())
        assert any(_bullet(folder, reference.uri) for folder in path.parents)
    assert len(robot.links[0].collisions) == 2 * len(robot.links[0].collisions) // 2


def _bullet(folder: Path, uri: str) -> bool:
    """PyBullet looks for what follows ``package://`` in every folder above the URDF."""
    plain = uri.removeprefix("package://").removeprefix("model://")
    return (folder / plain).is_file()


def yourdfpy_misses(path: Path) -> list[str]:
    model = yourdfpy.URDF.load(str(path), build_scene_graph=False, load_meshes=False)
    return [
        c.geometry.mesh.filename
        for link in model.robot.links
        for c in [*link.collisions, *link.visuals]
        if not Path(model._filename_handler(fname=c.geometry.mesh.filename)).is_file()
    ]


def test_relative_references_below_the_urdf(tmp_path: Path) -> None:
    mesh(tmp_path / "in" / "meshes" / "a.obj")
    source = urdf(
        tmp_path / "in" / "robot.urdf", collisions=("meshes/a.obj",), visuals=("meshes/a.obj",)
    )
    _, layout = build(source, tmp_path / "out")
    assert layout.urdf == PurePosixPath("robot.urdf")
    assert [str(c.to) for c in layout.copies] == ["meshes/a.obj"]
    place = layout.hulls["collision", "Arm link", 0]
    assert str(place.path(7)).startswith("meshes/collision_hulls/Arm_link_")
    assert place.uri(7) == str(place.path(7))
    assert place.name(7).endswith("_0_hull_007.obj")
    check(tmp_path / "out", layout)
    assert yourdfpy_misses(tmp_path / "out" / layout.urdf) == []


def test_relative_references_above_the_urdf(tmp_path: Path) -> None:
    mesh(tmp_path / "in" / "meshes" / "collision" / "a.obj")
    uri = "../meshes/collision/a.obj"
    source = urdf(tmp_path / "in" / "urdf" / "robot.urdf", collisions=(uri,), visuals=(uri,))
    _, layout = build(source, tmp_path / "out")
    assert layout.urdf == PurePosixPath("urdf/robot.urdf")
    place = layout.hulls["collision", "Arm link", 0]
    assert place.prefix.startswith("../meshes/collision_hulls/")
    check(tmp_path / "out", layout)
    assert yourdfpy_misses(tmp_path / "out" / layout.urdf) == []


def test_a_package_with_relative_references_keeps_its_places(tmp_path: Path) -> None:
    manifest(tmp_path / "in", "arm")
    mesh(tmp_path / "in" / "meshes" / "a.obj")
    source = urdf(tmp_path / "in" / "robots" / "x" / "r.urdf", collisions=("../../meshes/a.obj",))
    _, layout = build(source, tmp_path / "out")
    assert layout.urdf == PurePosixPath("robots/x/r.urdf")
    # the mesh itself is replaced by its hulls and needed by nobody
    assert [str(c.to) for c in layout.copies] == ["package.xml"]
    check(tmp_path / "out", layout)


@pytest.mark.parametrize("declared", [True, False])
def test_package_references_get_a_folder_of_that_name(tmp_path: Path, declared: bool) -> None:
    root = tmp_path / "in" / ("another name" if declared else "arm")
    if declared:
        manifest(root, "arm")
    mesh(root / "meshes" / "a.obj")
    mesh(root / "meshes" / "v.obj")
    source = urdf(
        root / "urdf" / "r.urdf",
        collisions=("package://arm/meshes/a.obj",),
        visuals=("package://arm/meshes/v.obj", "../meshes/v.obj"),
    )
    _, layout = build(source, tmp_path / "out")
    assert layout.urdf == PurePosixPath("arm/urdf/r.urdf")
    expected = ["arm/meshes/v.obj"] + (["arm/package.xml"] if declared else [])
    assert [str(c.to) for c in layout.copies] == expected
    place = layout.hulls["collision", "Arm link", 0]
    assert place.prefix.startswith("package://arm/meshes/collision_hulls/")
    check(tmp_path / "out", layout)
    assert yourdfpy_misses(tmp_path / "out" / layout.urdf) == []


def test_a_package_name_that_is_a_folder_beside_the_urdf(tmp_path: Path) -> None:
    mesh(tmp_path / "in" / "meshes" / "collision" / "a.obj")
    source = urdf(tmp_path / "in" / "r.urdf", collisions=("package://meshes/collision/a.obj",))
    _, layout = build(source, tmp_path / "out")
    assert layout.urdf == PurePosixPath("r.urdf")
    place = layout.hulls["collision", "Arm link", 0]
    assert place.prefix.startswith("package://meshes/collision_hulls/")
    assert str(place.folder).startswith("meshes/collision_hulls/")
    check(tmp_path / "out", layout)


def test_several_packages_and_an_undeclared_name(tmp_path: Path) -> None:
    manifest(tmp_path / "ws" / "arm", "arm")
    manifest(tmp_path / "ws" / "more" / "grip_folder", "grip")
    mesh(tmp_path / "ws" / "arm" / "meshes" / "a.obj")
    mesh(tmp_path / "ws" / "more" / "grip_folder" / "g.obj")
    uris = ("package://arm/meshes/a.obj", "package://grip/g.obj", "package://old/meshes/a.obj")
    source = urdf(tmp_path / "ws" / "arm" / "urdf" / "r.urdf", collisions=uris, visuals=uris)
    _, layout = build(source, tmp_path / "out")
    assert [str(c.to) for c in layout.copies] == [
        "arm/meshes/a.obj",
        "arm/package.xml",
        "grip/g.obj",
        "grip/package.xml",
        "old/meshes/a.obj",
        "old/package.xml",
    ]
    check(tmp_path / "out", layout)


def test_references_into_a_neighbouring_package(tmp_path: Path) -> None:
    manifest(tmp_path / "ws" / "arm", "arm")
    manifest(tmp_path / "ws" / "grip", "grip")
    mesh(tmp_path / "ws" / "grip" / "meshes" / "g.obj")
    uri = "../../grip/meshes/g.obj"
    source = urdf(tmp_path / "ws" / "arm" / "urdf" / "r.urdf", collisions=(uri,), visuals=(uri,))
    _, layout = build(source, tmp_path / "out")
    assert layout.urdf == PurePosixPath("arm/urdf/r.urdf")
    check(tmp_path / "out", layout)


def test_file_references_stay_and_their_hulls_are_relative(tmp_path: Path) -> None:
    path = mesh(tmp_path / "in" / "meshes" / "a.obj")
    source = urdf(tmp_path / "in" / "r.urdf", collisions=(f"file://{path}",), visuals=(str(path),))
    _, layout = build(source, tmp_path / "out")
    assert layout.copies == ()
    place = layout.hulls["collision", "Arm link", 0]
    assert place.prefix.startswith("collision_hulls/")
    read = read_robot(
        tmp_path / "out" / layout.urdf, resolver=Resolver(allow_roots=(tmp_path / "in",))
    )
    assert read.findings == ()


def test_upward_references_lie_beside_the_urdf_afterwards(tmp_path: Path) -> None:
    mesh(tmp_path / "in" / "other" / "a.obj")
    source = urdf(tmp_path / "in" / "deep" / "r.urdf", collisions=(), visuals=("other/a.obj",))
    _, layout = build(source, tmp_path / "out")
    assert [str(c.to) for c in layout.copies] == ["other/a.obj"]
    check(tmp_path / "out", layout)


def test_companions_come_along(tmp_path: Path) -> None:
    folder = tmp_path / "in" / "meshes"
    mesh(folder / "a.obj")
    (folder / "a.obj").write_text("mtllib mat lib.mtl other.mtl\n" + MESH)
    (folder / "mat lib.mtl").write_text("newmtl x\nmap_Kd -s 1 1 1 ../textures/wood grain.png\n")
    (folder / "other.mtl").write_text("bump n.png\nmap_Ks /etc/passwd\nmap_Ka ../../../out.png\n")
    (folder / "n.png").write_text("x")
    (tmp_path / "in" / "textures").mkdir()
    (tmp_path / "in" / "textures" / "wood grain.png").write_text("x")
    (tmp_path / "out.png").write_text("secret")
    (folder / "b.dae").write_text(
        "<COLLADA><library_images><image><init_from>../textures/t%201.jpg</init_from></image>"
        "<image><init_from>file://../../../out.png</init_from></image></library_images></COLLADA>"
    )
    (tmp_path / "in" / "textures" / "t 1.jpg").write_text("x")
    (folder / "c.gltf").write_text(
        '{"buffers":[{"uri":"c.bin"},{"uri":"data:,"}],"images":[{"uri":"i.png"},{"uri":"../.env"}]}'
    )
    (folder / "c.bin").write_text("x")
    (folder / "i.png").write_text("x")
    (tmp_path / "in" / ".env").write_text("secret")
    manifest(tmp_path / "in", "arm")
    visuals = ("../meshes/a.obj", "../meshes/b.dae", "../meshes/c.gltf")
    source = urdf(tmp_path / "in" / "urdf" / "r.urdf", collisions=(), visuals=visuals)
    layout = lay_out(read_robot(source, resolver=Resolver()).robot)
    assert [str(c.to) for c in layout.copies] == [
        "meshes/a.obj",
        "meshes/b.dae",
        "meshes/c.bin",
        "meshes/c.gltf",
        "meshes/i.png",
        "meshes/mat lib.mtl",
        "meshes/n.png",
        "meshes/other.mtl",
        "package.xml",
        "textures/t 1.jpg",
        "textures/wood grain.png",
    ]


def test_what_was_built_can_be_built_again(tmp_path: Path) -> None:
    manifest(tmp_path / "in", "arm")
    mesh(tmp_path / "in" / "meshes" / "a.obj")
    source = urdf(tmp_path / "in" / "urdf" / "r.urdf", collisions=("package://arm/meshes/a.obj",))
    _, first = build(source, tmp_path / "one")
    robot, second = build(tmp_path / "one" / first.urdf, tmp_path / "two")
    assert first.urdf == second.urdf
    check(tmp_path / "two", second)
    # with the first hull kept and the second replaced nothing is overwritten
    layout = lay_out(robot, replaced=[("Arm link", 1)])
    kept = {str(c.to.parent) for c in layout.copies}
    assert str(layout.hulls["collision", "Arm link", 1].folder) not in kept


def test_inner_hulls_lie_beside_hulls_and_never_where_something_is_copied_to(
    tmp_path: Path,
) -> None:
    mesh(tmp_path / "meshes" / "a.obj")
    mesh(tmp_path / "meshes" / "inner_hulls" / "Arm_link_0" / "b.obj")
    text = '<robot name="r"><link name="Arm_link">{}</link></robot>'
    shape = '<{0}><geometry><mesh filename="{1}"/></geometry></{0}>'
    both = shape.format("collision", "meshes/a.obj") + shape.format(
        "visual", "meshes/inner_hulls/Arm_link_0/b.obj"
    )
    (tmp_path / "plain.urdf").write_text(text.format(shape.format("collision", "meshes/a.obj")))
    (tmp_path / "taken.urdf").write_text(text.format(both))
    found = []
    for name in ("plain.urdf", "taken.urdf"):
        layout = lay_out(read_robot(tmp_path / name, resolver=Resolver()).robot)
        place = layout.hulls["collision", "Arm_link", 0]
        found.append((str(place.path(0)), str(place.inner_path(12))))
    assert found == [
        (
            f"meshes/collision_hulls/{stem}/{stem}_hull_000.obj",
            f"meshes/inner_hulls/{stem}/{stem}_inner_012.obj",
        )
        for stem in ("Arm_link_0", "Arm_link_0_2")
    ]


def test_robots_that_share_a_package_are_kept_apart(tmp_path: Path) -> None:
    manifest(tmp_path / "in", "arm")
    mesh(tmp_path / "in" / "meshes" / "a.obj")
    for name in ("left", "right"):
        source = urdf(
            tmp_path / "in" / "urdf" / f"{name}.urdf", collisions=("package://arm/meshes/a.obj",)
        )
        _, layout = build(source, tmp_path / "out", shelf=name)
        check(tmp_path / "out", layout)


def test_hull_names_are_unique_whatever_the_case(tmp_path: Path) -> None:
    mesh(tmp_path / "a.obj")
    links = "".join(
        f'<link name="{name}"><collision><geometry><mesh filename="a.obj"/></geometry></collision>'
        "</link>"
        for name in ("Hand", "hand", "hand_0", "a/b", "a:b", "..", "con", "ü")
    )
    (tmp_path / "r.urdf").write_text(f'<robot name="r">{links}</robot>')
    layout = lay_out(read_robot(tmp_path / "r.urdf", resolver=Resolver()).robot)
    folders = [str(place.folder).casefold() for place in layout.hulls.values()]
    assert len(folders) == len(set(folders)) == 8
    for folder in folders:
        parts = PurePosixPath(folder).parts
        assert parts[0] == "collision_hulls"
        assert len(parts) == 2
        assert ".." not in parts


@pytest.mark.parametrize(
    ("name", "safe"), [("hand", "hand"), ("a.b-c_D9", "a.b-c_D9"), ("x" * 60, "x" * 60)]
)
def test_safe_names_stay(name: str, safe: str) -> None:
    assert safe_name(name) == safe


@pytest.mark.parametrize(
    "name", ["", "..", ".", "a/b", "a\\b", "a b", "x" * 61, "日本", "-a", "a\0"]
)
def test_other_names_become_safe_and_stay_different(name: str) -> None:
    safe = safe_name(name)
    assert safe != name
    assert safe.isascii()
    assert 0 < len(safe) < 70
    assert not set(safe) & set("/\\ \0:")
    assert safe_name(name + "!") != safe


def test_hulls_load_where_they_are_referred_to(tmp_path: Path) -> None:
    pytest.importorskip("pybullet", reason="PyBullet has no wheels for this Python")
    import subprocess
    import sys

    manifest(tmp_path / "in" / "folder", "arm")
    mesh(tmp_path / "in" / "folder" / "meshes" / "a.obj")
    uri = "package://arm/meshes/a.obj"
    source = urdf(tmp_path / "in" / "folder" / "urdf" / "r.urdf", collisions=(uri,), visuals=(uri,))
    _, layout = build(source, tmp_path / "out")
    script = (
        "import pybullet as p, sys; p.connect(p.DIRECT); b = p.loadURDF(sys.argv[1]); "
        "print('shapes', len(p.getCollisionShapeData(b, -1)), len(p.getVisualShapeData(b)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, str(tmp_path / "out" / layout.urdf)],
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )
    assert "shapes 2 1" in done.stdout
    model = yourdfpy.URDF.load(str(tmp_path / "out" / layout.urdf), load_collision_meshes=True)
    np.testing.assert_allclose(model.scene.bounds[1], [0.05, 0.1, 0.15])


def test_files_that_no_robot_is_drawn_with_are_not_handed_on(tmp_path: Path) -> None:
    home = tmp_path / "drawn_description"
    manifest(home, "drawn_description")
    mesh(home / "meshes/arm.obj")
    (home / "meshes/drawing.WRL").write_text("#VRML")
    (tmp_path / "Documents").mkdir()
    (tmp_path / "Documents/letter.txt").write_text("private")
    description = urdf(
        home / "urdf/arm.urdf",
        collisions=("package://drawn_description/meshes/arm.obj",),
        visuals=(
            "package://drawn_description/meshes/drawing.WRL",
            "package://Documents/letter.txt",
        ),
    )
    robot = read_robot(description, resolver=Resolver()).robot
    layout = lay_out(robot, replaced=[])
    copied = {copy.to.name for copy in layout.copies}
    assert {"arm.obj", "drawing.WRL"} <= copied
    assert "letter.txt" not in copied
    told = [finding for finding in layout.findings if finding.code == "AP102"]
    assert len(told) == 1
    assert "letter.txt" in told[0].message
