"""Writing: every byte outside of the named collision elements stays."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lxml import etree

from assetpipe.errors import UsageError
from assetpipe.robot import (
    Box,
    Capsule,
    Cylinder,
    HullMesh,
    NewCollision,
    Resolver,
    Robot,
    Sphere,
    read_robot,
    write_urdf,
)
from assetpipe.robot.splice import Edit, spliced
from assetpipe.robot.writer import roll_pitch_yaw

SOURCE = b"""<?xml version='1.0' encoding="utf-8"?>
<!-- <collision> in a comment -->
<robot   name="r"\txmlns:gz='urn:x'>
  <link name="a" >
    <collision name='shell'>
      <origin rpy="0 0 1" xyz = '1 2 3'/>
      <geometry><mesh scale="1 -1 1" filename="meshes/a.stl" extra='1'/></geometry>
      <contact/><!-- why -->
    </collision>
    <collision><geometry><box size="1 1 1"/></geometry></collision>
  </link>
  <link name="b"><visual><geometry><sphere radius="1"/></geometry></visual></link>
  <link name="c"/>
  <link name="d">
  </link>
  <gazebo reference="a"><collision name="x"/></gazebo>
</robot>
<!-- end -->
"""


def robot(tmp_path: Path, source: bytes = SOURCE) -> Robot:
    path = tmp_path / "r.urdf"
    path.write_bytes(source)
    return read_robot(path, resolver=Resolver()).robot


def hulls(*uris: str) -> list[NewCollision]:
    return [NewCollision(HullMesh(uri)) for uri in uris]


def test_nothing_asked_nothing_changed(tmp_path: Path) -> None:
    assert write_urdf(robot(tmp_path), {}) == SOURCE


def test_copies_keep_everything_but_name_and_mesh(tmp_path: Path) -> None:
    written = write_urdf(robot(tmp_path), {("a", 0): hulls("h/0.obj", "h/1.obj")})
    old = SOURCE[SOURCE.index(b"<collision name") : SOURCE.index(b"</collision>") + 12]
    copies = [
        old.replace(b"'shell'", f"'shell_{k}'".encode())
        .replace(b' scale="1 -1 1"', b"")
        .replace(b"meshes/a.stl", f"h/{k}.obj".encode())
        for k in range(2)
    ]
    assert written == SOURCE.replace(old, copies[0] + b"\n    " + copies[1])


def test_a_single_replacement_keeps_its_name(tmp_path: Path) -> None:
    written = write_urdf(robot(tmp_path), {("a", 0): hulls("h.obj")})
    assert b"<collision name='shell'>" in written
    assert written.count(b"<collision") == SOURCE.count(b"<collision")


def test_names_stay_unique(tmp_path: Path) -> None:
    source = SOURCE.replace(
        b"<collision><geometry><box", b'<collision name="shell_1"><geometry><box'
    )
    written = write_urdf(robot(tmp_path, source), {("a", 0): hulls("0", "1", "2")})
    names = [c.get("name") for c in etree.fromstring(written).findall("link/collision")]
    assert names == ["shell_0", "shell_2", "shell_3", "shell_1"]


def test_line_endings_and_indentation_are_the_files_own(tmp_path: Path) -> None:
    source = SOURCE.replace(b"    <collision name", b"\t\t<collision name").replace(b"\n", b"\r\n")
    written = write_urdf(robot(tmp_path, source), {("a", 0): hulls("0", "1")})
    assert b"</collision>\r\n\t\t<collision name='shell_1'>" in written
    assert b"\n" not in written.replace(b"\r\n", b"")


def test_elements_on_one_line_get_a_line_each(tmp_path: Path) -> None:
    source = (
        b'<robot name="r"><link name="a"><collision><geometry><mesh filename="a.stl"/>'
        b"</geometry></collision></link></robot>"
    )
    written = write_urdf(robot(tmp_path, source), {("a", 0): hulls("0", "1")})
    assert written.count(b"</collision>\n<collision>") == 1
    assert written.count(b"\n") == 1


def test_primitives_take_the_place_of_a_mesh_with_an_origin_of_their_own(tmp_path: Path) -> None:
    pose = np.eye(4)
    pose[:3, 3] = [0.1, 0, -2]
    new = [
        NewCollision(Box((1.0, 2.0, 0.1)), pose),
        NewCollision(Cylinder(0.5, 1.0), pose),
        NewCollision(Sphere(0.25)),
        NewCollision(Capsule(0.5, 1.0)),
    ]
    root = etree.fromstring(write_urdf(robot(tmp_path), {("a", 0): new}))
    found = root.findall("link[@name='a']/collision")
    assert [dict(c.find("geometry")[0].attrib) for c in found[:4]] == [
        {"size": "1.0 2.0 0.1"},
        {"radius": "0.5", "length": "1.0"},
        {"radius": "0.25"},
        {"radius": "0.5", "length": "1.0"},
    ]
    assert found[0].find("origin").attrib == {"xyz": "0.1 0.0 -2.0", "rpy": "0.0 0.0 0.0"}
    assert found[2].find("origin").attrib == {"rpy": "0 0 1", "xyz": "1 2 3"}
    assert all(c.find("contact") is not None for c in found[:4])


def test_an_origin_is_put_before_the_geometry_where_there_is_none(tmp_path: Path) -> None:
    written = write_urdf(robot(tmp_path), {("a", 1): [NewCollision(Sphere(1.0), np.eye(4))]})
    assert (
        b'<collision><origin xyz="0.0 0.0 0.0" rpy="0.0 0.0 0.0"/><geometry>'
        b'<sphere radius="1.0"/></geometry></collision>'
    ) in written


def test_none_takes_the_element_away_and_nothing_else(tmp_path: Path) -> None:
    written = write_urdf(robot(tmp_path), {("a", 1): []})
    assert written == SOURCE.replace(
        b'<collision><geometry><box size="1 1 1"/></geometry></collision>', b""
    )


@pytest.mark.parametrize("link", ["a", "b", "c", "d"])
def test_additions_change_no_other_byte(tmp_path: Path, link: str) -> None:
    new = [NewCollision(HullMesh(f"{k}.obj"), np.eye(4)) for k in range(2)]
    written = write_urdf(robot(tmp_path), {}, {link: new})
    root = etree.fromstring(written)
    found = root.findall(f"link[@name='{link}']/collision")
    assert [c.find("geometry/mesh").get("filename") for c in found[-2:]] == ["0.obj", "1.obj"]
    for collision in found[-2:]:
        collision.getparent().remove(collision)
    canonical = [
        b"".join(etree.tostring(tree, method="c14n").split())
        for tree in (root, etree.fromstring(SOURCE))
    ]
    assert canonical[0] == canonical[1]
    if link != "c":
        pieces = written.split(b"<collision><origin xyz")
        assert SOURCE.startswith(pieces[0].rstrip())


def test_additions_beside_elements_that_go(tmp_path: Path) -> None:
    new = [NewCollision(HullMesh("h.obj"), np.eye(4))]
    written = write_urdf(robot(tmp_path), {("a", 0): [], ("a", 1): []}, {"a": new})
    link = etree.fromstring(written).find("link[@name='a']")
    assert [c.find("geometry/mesh").get("filename") for c in link.findall("collision")] == ["h.obj"]


def test_what_is_asked_must_be_there(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="link 'aa' not found; did you mean 'a'"):
        write_urdf(robot(tmp_path), {("aa", 0): []})
    with pytest.raises(UsageError, match="link 'a' has no collision 2; it has 2"):
        write_urdf(robot(tmp_path), {("a", 2): []})
    with pytest.raises(UsageError, match="needs an origin"):
        write_urdf(robot(tmp_path), {}, {"b": hulls("x")})


def test_values_are_escaped_for_their_quotes(tmp_path: Path) -> None:
    source = SOURCE.replace(b'filename="meshes/a.stl"', b"filename='meshes/a.stl'")
    uri = "a&b<c>\"d'\n.obj"
    written = write_urdf(robot(tmp_path, source), {("a", 0): hulls(uri), ("a", 1): hulls(uri)})
    found = [m.get("filename") for m in etree.fromstring(written).iter("mesh")]
    assert found == [uri, uri]


@pytest.mark.parametrize("encoding", ["utf-16", "utf-8-sig", "iso-8859-1", "cp1252", "shift_jis"])
def test_other_encodings_come_back_to_the_byte(tmp_path: Path, encoding: str) -> None:
    word = {"shift_jis": "日本"}.get(encoding, "Größe")
    text = SOURCE.decode().replace("utf-8", encoding.replace("-sig", "")).replace("why", word)
    source = text.encode(encoding)
    read = robot(tmp_path, source)
    assert write_urdf(read, {}) == source
    written = write_urdf(read, {("a", 1): hulls("h.obj")})
    box = '<box size="1 1 1"/>'
    assert written == text.replace(box, '<mesh filename="h.obj"/>').encode(encoding)


def test_bytes_that_are_no_text_stay(tmp_path: Path) -> None:
    source = SOURCE.replace(b"why", b"\xff\xfe\x80").replace(
        b"in a comment", b"-- in a --- comment"
    )
    written = write_urdf(robot(tmp_path, source), {("a", 1): hulls("h.obj")})
    assert written == source.replace(b'<box size="1 1 1"/>', b'<mesh filename="h.obj"/>')


space = st.sampled_from(["", " ", "\n", "\n  ", "\r\n\t", "<!-- c -->", "<?pi?>"])
shapes = st.sampled_from(
    [
        '<mesh filename="a.stl"/>',
        "<mesh filename='a.stl' scale='1 2 3'></mesh>",
        '<box size="1 1 1"/>',
    ]
)
parts = st.sampled_from(["<contact/>", "<verbose value='x'/>", "<origin xyz='1 2 3'/>", ""])


@st.composite
def urdfs(draw: st.DrawFn) -> tuple[str, list[int]]:
    text = "<robot name='r'>"
    counts = []
    for k in range(draw(st.integers(1, 4))):
        text += draw(space) + f'<link name="l{k}">'
        counts.append(draw(st.integers(0, 3)))
        for _ in range(counts[-1]):
            name = draw(st.sampled_from(["", " name='n'", '\n name = "m"']))
            text += draw(space) + f"<collision{name}>" + draw(parts) + draw(space)
            text += f"<geometry>{draw(space)}{draw(shapes)}</geometry>"
            text += draw(parts) + "</collision>"
        text += draw(space) + "<inertial/></link>" + draw(space)
    return text + "</robot>" + draw(space.filter(lambda s: "pi" not in s)), counts


@given(urdfs(), st.data())
def test_any_replacement_changes_collision_elements_only(
    urdf: tuple[str, list[int]], data: st.DataObject
) -> None:
    text, counts = urdf
    source = text.encode()
    read = Robot("r", Path("r.urdf"), source, (), (), None, Path(), ())
    keys = [(f"l{k}", i) for k, n in enumerate(counts) for i in range(n)]
    chosen = data.draw(st.lists(st.sampled_from(keys), unique=True)) if keys else []
    sizes = {key: data.draw(st.integers(0, 4)) for key in chosen}
    written = write_urdf(read, {key: hulls(*map(str, range(n))) for key, n in sizes.items()})
    before, after = outside(source), outside(written)
    # between copies stands white space; all else is the same
    assert b"".join(b"".join(before).split()) == b"".join(b"".join(after).split())
    if all(n == 1 for n in sizes.values()):
        assert before == after
    expected = sum(counts) + sum(n - 1 for n in sizes.values())
    assert len(after) - 1 == expected
    names = [n for n in collision_names(written) if n is not None]
    if len(set(collision_names(source))) == len(collision_names(source)):
        assert len(names) == len(set(names))


def outside(source: bytes) -> list[bytes]:
    """The bytes around and between the links' collision elements, found by another parser."""
    pieces, position = [], 0
    while (start := source.find(b"<collision", position)) >= 0:
        pieces.append(source[position:start])
        position = source.index(b"</collision>", start) + len(b"</collision>")
    return [*pieces, source[position:]]


def collision_names(source: bytes) -> list[str | None]:
    return [c.get("name") for c in etree.fromstring(source).findall("link/collision")]


@given(st.binary(max_size=30), st.data())
def test_splicing_is_what_slicing_says(text: bytes, data: st.DataObject) -> None:
    cuts = sorted(data.draw(st.lists(st.integers(0, len(text)), max_size=6)))
    spans = list(zip(cuts[::2], cuts[1::2], strict=False))
    edits = [Edit(a, b, data.draw(st.binary(max_size=4))) for a, b in spans]
    expected, position = b"", 0
    for edit in edits:
        expected += text[position : edit.start] + edit.text
        position = edit.end
    expected += text[position:]
    assert (
        spliced(text, list(reversed(edits)) if len(set(cuts)) == len(cuts) else edits) == expected
    )


def test_overlapping_edits_are_an_error() -> None:
    with pytest.raises(ValueError, match="overlaps"):
        spliced(b"0123456789", [Edit(0, 5, b""), Edit(4, 6, b"")])


@given(st.tuples(*[st.floats(-7, 7)] * 3))
def test_roll_pitch_yaw_come_back(angles: tuple[float, float, float]) -> None:
    import trimesh.transformations as tra

    matrix = tra.euler_matrix(*angles, axes="sxyz")
    found = tra.euler_matrix(*roll_pitch_yaw(matrix[:3, :3]), axes="sxyz")
    np.testing.assert_allclose(found, matrix, atol=1e-8)
