"""DAE, GLB and glTF: units, axes, transforms, and files that mean harm."""

import io
import json
import struct
from pathlib import Path
from typing import Any

import collada
import numpy as np
import pytest
import trimesh
from gltf_triangle import POINTS, gltf

from assetpipe.errors import InputError, LimitError
from assetpipe.geometry import FileLimits, Mesh, read_mesh

TRIANGLE = """<geometry id="g"><mesh>
  <source id="p"><float_array id="pa" count="9">0 0 0 1 0 0 0 2 0</float_array>
    <technique_common><accessor source="#pa" count="3" stride="3">
      <param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
    </accessor></technique_common></source>
  <vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
  {primitive}
</mesh></geometry>"""
FACE = (
    '<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>'
)


def dae(
    *,
    asset: str = "",
    nodes: str = '<node><instance_geometry url="#g"/></node>',
    primitive: str = FACE,
    head: str = "",
    library: str = "",
) -> str:
    return f"""<?xml version="1.0"?>{head}
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset>{asset}</asset>
<library_geometries>{TRIANGLE.format(primitive=primitive)}</library_geometries>
{library}
<library_visual_scenes><visual_scene id="s">{nodes}</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>"""


def load(tmp_path: Path, text: str | bytes, name: str = "a.dae", **options: Any) -> Mesh:
    path = tmp_path / name
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return read_mesh(path, **options).mesh


UP = {"Z_UP": [0, 2, 0], "Y_UP": [0, 0, 2], "X_UP": [-2, 0, 0]}


@pytest.mark.parametrize("axis", UP)
@pytest.mark.parametrize("metres", [1.0, 0.01, 0.0254])
def test_dae_unit_and_axis_are_applied_once(tmp_path: Path, axis: str, metres: float) -> None:
    asset = f'<unit name="u" meter="{metres}"/><up_axis>{axis}</up_axis>'
    path = tmp_path / "a.dae"
    path.write_text(dae(asset=asset))
    loaded = read_mesh(path)
    np.testing.assert_allclose(loaded.mesh.vertices[2], np.array(UP[axis]) * metres, atol=1e-15)
    assert len(loaded.notes) == (metres != 1.0) + (axis != "Z_UP")


def test_axis_can_be_ignored_or_always_applied(tmp_path: Path) -> None:
    text = dae(asset="<up_axis>Y_UP</up_axis>")
    assert load(tmp_path, text, axes="ignored").vertices[2].tolist() == [0, 2, 0]
    assert load(tmp_path, text, axes="declared").vertices[2].tolist() == [0, 0, 2]


@pytest.mark.parametrize(
    "asset",
    [
        "<contributor><authoring_tool>VCGLib | MeshLab</authoring_tool></contributor>"
        "<up_axis>Y_UP</up_axis>",
        "<created>2013-11-15T10:34:57.029907</created><modified>x</modified><up_axis>Y_UP</up_axis>",
    ],
)
def test_writers_that_say_y_up_of_everything_are_not_believed(tmp_path: Path, asset: str) -> None:
    path = tmp_path / "a.dae"
    path.write_text(dae(asset=asset))
    loaded = read_mesh(path)
    assert loaded.mesh.vertices[2].tolist() == [0, 2, 0]
    assert "not applied" in loaded.notes[0]
    assert read_mesh(path, axes="declared").mesh.vertices[2].tolist() == [0, 0, 2]


@pytest.mark.parametrize("suffix", ["dae", "glb"])
def test_what_trimesh_writes_comes_back_where_it_was(tmp_path: Path, suffix: str) -> None:
    shape = trimesh.creation.box((1, 2, 3))
    path = tmp_path / f"a.{suffix}"
    shape.export(path)
    np.testing.assert_allclose(read_mesh(path).mesh.bounds, shape.bounds, atol=1e-7)


def test_dae_transforms_in_order_and_instances(tmp_path: Path) -> None:
    nodes = """<node id="n"><translate>1 0 0</translate><rotate>0 0 1 90</rotate>
      <scale>2 1 1</scale><instance_geometry url="#g"/>
      <node><matrix>1 0 0 0 0 1 0 0 0 0 1 5 0 0 0 1</matrix><instance_geometry url="#g"/></node>
    </node><node><translate>0 0 9</translate><instance_node url="#n"/></node>"""
    mesh = load(tmp_path, dae(nodes=nodes))
    assert len(mesh.faces) == 4
    # x is doubled, turned to y and then moved
    np.testing.assert_allclose(mesh.vertices[1], [1, 2, 0], atol=1e-12)
    np.testing.assert_allclose(mesh.vertices[4], [1, 2, 5], atol=1e-12)
    np.testing.assert_allclose(mesh.vertices[7], [1, 2, 9], atol=1e-12)


def test_mirrored_instances_keep_their_faces_outward(tmp_path: Path) -> None:
    nodes = '<node><scale>-1 1 1</scale><instance_geometry url="#g"/></node>'
    assert load(tmp_path, dae(nodes=nodes)).faces.tolist() == [[2, 1, 0]]


@pytest.mark.parametrize(
    ("primitive", "faces"),
    [
        ('<polylist count="1">{i}<vcount>3</vcount><p>0 1 2</p></polylist>', [[0, 1, 2]]),
        ("<polygons>{i}<p>0 1 2</p><p>0 2 1</p></polygons>", [[0, 1, 2], [0, 2, 1]]),
        ("<tristrips>{i}<p>0 1 2 0</p></tristrips>", [[0, 1, 2], [2, 1, 0]]),
        ("<trifans>{i}<p>0 1 2 1</p></trifans>", [[0, 1, 2], [0, 2, 1]]),
        ("<lines>{i}<p>0 1</p></lines><triangles>{i}<p>0 1 2</p></triangles>", [[0, 1, 2]]),
    ],
)
def test_dae_primitives(tmp_path: Path, primitive: str, faces: list[list[int]]) -> None:
    vertex = '<input semantic="VERTEX" source="#v" offset="0"/>'
    mesh = load(tmp_path, dae(primitive=primitive.format(i=vertex)))
    assert mesh.faces.tolist() == faces


def unit(vector: np.ndarray) -> np.ndarray:
    return vector / np.linalg.norm(vector)


@pytest.mark.filterwarnings("ignore:the matrix subclass")
def two_geometries(second: str) -> str:
    """A document merged from two: each geometry has the same ids in it."""
    one = TRIANGLE.format(primitive=FACE)
    other = one.replace('id="g"', f'id="{second}"').replace(
        "0 0 0 1 0 0 0 2 0", "5 0 0 7 0 0 5 3 0"
    )
    nodes = "".join(f'<node><instance_geometry url="#{g}"/></node>' for g in ("g", second))
    text = dae(nodes=nodes)
    return text.replace(one, one + other)


def test_each_geometry_means_its_own_sources_where_ids_repeat(tmp_path: Path) -> None:
    ours = load(tmp_path, two_geometries("h")).vertices
    assert ours[:, 0].tolist() == [0, 1, 0, 5, 7, 5]
    theirs = collada.Collada(str(tmp_path / "a.dae")).scene.objects("geometry")
    points = np.vstack([p.vertex for g in theirs for p in g.primitives()])
    np.testing.assert_array_equal(ours, points)


def test_a_geometry_that_is_named_like_another_is_told(tmp_path: Path) -> None:
    load(tmp_path, two_geometries("g"))
    notes = read_mesh(tmp_path / "a.dae").notes
    assert any("several <geometry> are called 'g'" in note for note in notes)


def test_the_same_id_on_elements_of_two_kinds_is_no_matter(tmp_path: Path) -> None:
    text = dae(nodes='<node id="g"><instance_geometry url="#g"/></node>')
    nodes_first = text.replace("<library_geometries>", "<extra id='g'/><library_geometries>")
    assert len(load(tmp_path, nodes_first).faces) == 1


def test_dae_agrees_with_pycollada(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    document = collada.Collada()
    shape = trimesh.creation.icosphere(subdivisions=1)
    points = collada.source.FloatSource("p", shape.vertices.reshape(-1), ("X", "Y", "Z"))
    normals = collada.source.FloatSource("n", shape.vertex_normals.reshape(-1), ("X", "Y", "Z"))
    geometry = collada.geometry.Geometry(document, "g", "g", [points, normals])
    inputs = collada.source.InputList()
    inputs.addInput(0, "VERTEX", "#p")
    inputs.addInput(1, "NORMAL", "#n")
    index = np.repeat(shape.faces.reshape(-1), 2)
    geometry.primitives.append(geometry.createTriangleSet(index, inputs, "m"))
    document.geometries.append(geometry)
    nodes = []
    for k in range(3):
        moved = [
            collada.scene.TranslateTransform(*rng.normal(size=3)),
            # pycollada does not normalise axes
            collada.scene.RotateTransform(*unit(rng.normal(size=3)), rng.uniform(0, 360)),
            collada.scene.ScaleTransform(*rng.uniform(0.5, 2, size=3)),
        ]
        inside = collada.scene.GeometryNode(geometry, [])
        nodes.append(collada.scene.Node(f"n{k}", children=[inside], transforms=moved))
    nodes[0].children.append(nodes.pop())
    document.scenes.append(collada.scene.Scene("s", nodes))
    document.scene = document.scenes[0]
    file = io.BytesIO()
    document.write(file)
    mesh = load(tmp_path, file.getvalue())
    oracle = [
        np.asarray(primitive.vertex)[primitive.vertex_index]
        for bound in collada.Collada(io.BytesIO(file.getvalue())).scene.objects("geometry")
        for primitive in bound.primitives()
    ]
    ours = mesh.vertices[mesh.faces]
    np.testing.assert_allclose(ours, np.concatenate(oracle), atol=2e-6)


BOMB = "<!DOCTYPE COLLADA [" + "".join(
    f'<!ENTITY e{k} "{f"&e{k - 1};" * 10 if k else "ha"}">' for k in range(30)
)


@pytest.mark.parametrize(
    "head", [BOMB + "]>", '<!DOCTYPE COLLADA [<!ENTITY x SYSTEM "file:///etc/passwd">]>']
)
def test_entities_are_refused(tmp_path: Path, head: str) -> None:
    with pytest.raises(InputError, match="entities may be bombs"):
        load(tmp_path, dae(head=head))


def test_entities_in_other_encodings_are_refused_too(tmp_path: Path) -> None:
    text = dae(head=BOMB + "]>")
    with pytest.raises(InputError, match="entities may be bombs"):
        load(tmp_path, text.encode("utf-16"))
    hidden = text.replace('<?xml version="1.0"?>', '<?xml version="1.0" encoding="UTF-7"?>')
    with pytest.raises(InputError, match="unknown encoding 'UTF-7'"):
        load(tmp_path, hidden)


def test_a_plain_doctype_is_harmless(tmp_path: Path) -> None:
    assert len(load(tmp_path, dae(head='<!DOCTYPE COLLADA SYSTEM "http://x/y.dtd">')).faces) == 1


def test_instances_of_instances_do_not_multiply_without_end(tmp_path: Path) -> None:
    pairs = "".join(
        f'<node id="n{k}"><instance_node url="#n{k + 1}"/><instance_node url="#n{k + 1}"/></node>'
        for k in range(40)
    )
    library = f'<library_nodes>{pairs}<node id="n40"/></library_nodes>'
    with pytest.raises(LimitError, match="nodes exceed the limit"):
        load(
            tmp_path,
            dae(nodes='<node><instance_node url="#n0"/></node>', library=library),
            limits=FileLimits(max_nodes=2000),
        )


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"nodes": '<node id="a"><instance_node url="#a"/></node>'}, "contains itself"),
        ({"nodes": '<node><instance_geometry url="#none"/></node>'}, "does not exist"),
        ({"nodes": '<node><instance_geometry url="other.dae#g"/></node>'}, "within the file"),
        ({"nodes": "<node><matrix>1 2 3</matrix></node>"}, "3 numbers instead of 16"),
        ({"nodes": "<node><translate>1 2 x</translate></node>"}, "'x' is not a number"),
        ({"primitive": FACE.replace("0 1 2", "0 1 7")}, "names vertex 7, but there are 3"),
        ({"primitive": FACE.replace("0 1 2", "0 1 -1")}, "names vertex -1"),
        ({"primitive": FACE.replace("0 1 2", "0 1")}, "no multiple of 3"),
        ({"primitive": FACE.replace("#v", "#none")}, "does not exist"),
        ({"primitive": FACE.replace("triangles", "bezier")}, "unsupported <bezier>"),
        ({"asset": '<unit meter="0"/>'}, "unit of '0' metres"),
        ({"asset": '<unit meter="1,0"/>'}, "'1,0' is not a number"),
        ({"asset": "<up_axis>W_UP</up_axis>"}, "none of X_UP, Y_UP, Z_UP"),
    ],
)
def test_broken_dae_is_located(tmp_path: Path, change: dict[str, str], reason: str) -> None:
    with pytest.raises(InputError, match=reason) as caught:
        load(tmp_path, dae(**change))
    assert caught.value.location is not None
    assert caught.value.location.line is not None


def test_truncated_dae(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="not well-formed XML") as caught:
        load(tmp_path, dae()[:-200])
    assert caught.value.location is not None
    assert caught.value.location.line is not None


def test_gltf_is_turned_to_z_up(tmp_path: Path) -> None:
    assert load(tmp_path, json.dumps(gltf()), "a.gltf").vertices[2].tolist() == [0, 0, 2]
    kept = load(tmp_path, json.dumps(gltf()), "a.gltf", axes="ignored")
    assert kept.vertices[2].tolist() == [0, 2, 0]


def test_gltf_with_a_buffer_beside_it(tmp_path: Path) -> None:
    tree = gltf()
    data = POINTS.tobytes() + np.arange(3, dtype="<u2").tobytes()
    (tmp_path / "b c.bin").write_bytes(data)
    tree["buffers"] = [{"byteLength": 42, "uri": "b%20c.bin"}]
    assert len(load(tmp_path, json.dumps(tree), "a.gltf").faces) == 1
    (tmp_path / "inner").mkdir()
    tree["buffers"][0]["uri"] = "../b c.bin"
    with pytest.raises(InputError, match=r"no file in the glTF's folder"):
        load(tmp_path / "inner", json.dumps(tree), "a.gltf")
    (tmp_path / "inner" / "link.bin").symlink_to(tmp_path / "b c.bin")
    tree["buffers"][0]["uri"] = "link.bin"
    with pytest.raises(InputError, match=r"no file in the glTF's folder"):
        load(tmp_path / "inner", json.dumps(tree), "a.gltf")


def test_gltf_nodes_multiply_their_transforms(tmp_path: Path) -> None:
    half = np.sqrt(0.5)
    nodes = [
        {"children": [1], "translation": [0, 0, 3]},
        {"mesh": 0, "rotation": [0, 0, half, half], "scale": [-2, 1, 1]},
    ]
    mesh = load(tmp_path, json.dumps(gltf(nodes=nodes)), "a.gltf", axes="ignored")
    np.testing.assert_allclose(mesh.vertices[1], [0, -2, 3], atol=1e-12)
    assert mesh.faces.tolist() == [[2, 1, 0]]


def test_gltf_sparse_accessor(tmp_path: Path) -> None:
    tree = gltf()
    tree["accessors"][0]["sparse"] = {
        "count": 1,
        "indices": {"bufferView": 1, "componentType": 5123, "byteOffset": 4},
        "values": {"bufferView": 0, "byteOffset": 12},
    }
    mesh = load(tmp_path, json.dumps(tree), "a.gltf", axes="ignored")
    assert mesh.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [1, 0, 0]]


def test_glb_agrees_with_trimesh(tmp_path: Path) -> None:
    scene = trimesh.Scene()
    shape = trimesh.creation.torus(0.3, 0.1)
    for k in range(3):
        scene.add_geometry(
            shape, transform=trimesh.transformations.random_rotation_matrix(np.full(3, k / 3))
        )
    path = tmp_path / "a.glb"
    path.write_bytes(scene.export(file_type="glb"))
    mesh = read_mesh(path, axes="ignored").mesh
    oracle = trimesh.load(path, force="mesh", process=False)
    assert mesh.volume == pytest.approx(oracle.volume, rel=1e-6)
    np.testing.assert_allclose(mesh.bounds, oracle.bounds, atol=1e-6)


@pytest.mark.parametrize(
    ("change", "error", "reason"),
    [
        ({"asset": {"version": "1.0"}}, InputError, "not a glTF 2"),
        ({"accessors": [{}, {}]}, InputError, "accessor of type"),
        ({"bufferViews": []}, InputError, r"bufferViews\[0\] does not exist"),
        ({"nodes": [{"mesh": 0, "children": [0]}]}, InputError, "contains itself"),
        ({"nodes": [{"mesh": 9}]}, InputError, r"meshes\[9\] does not exist; there are 1"),
        ({"nodes": [{"matrix": [1, 2]}]}, InputError, "not 16 numbers"),
        ({"buffers": [{"byteLength": 99, "uri": "data:,base64,"}]}, InputError, "truncated"),
        ({"extensionsRequired": ["KHR_draco_mesh_compression"]}, InputError, "Draco"),
    ],
)
def test_broken_gltf(
    tmp_path: Path, change: dict[str, Any], error: type[Exception], reason: str
) -> None:
    with pytest.raises(error, match=reason):
        load(tmp_path, json.dumps(gltf(**change)), "a.gltf")


@pytest.mark.parametrize(
    ("accessor", "change", "error", "reason"),
    [
        (0, {"count": 4}, InputError, "reaches beyond its view"),
        (0, {"byteOffset": 4}, InputError, "reaches beyond its view"),
        (0, {"count": -1}, InputError, "no count"),
        (0, {"bufferView": None, "count": 10**12}, LimitError, "zeros without data"),
        (1, {"count": 2}, InputError, "no multiple of 3"),
        (1, {"componentType": 5121, "byteOffset": 1}, None, ""),
        (1, {"componentType": 5126, "count": 1}, InputError, "no whole numbers"),
    ],
)
def test_bad_accessors(
    tmp_path: Path,
    accessor: int,
    change: dict[str, Any],
    error: type[Exception] | None,
    reason: str,
) -> None:
    tree = gltf()
    tree["accessors"][accessor] |= change
    tree["accessors"][accessor] = {
        k: v for k, v in tree["accessors"][accessor].items() if v is not None
    }
    if error is None:
        assert load(tmp_path, json.dumps(tree), "a.gltf").faces.tolist() == [[0, 1, 0]]
        return
    with pytest.raises(error, match=reason):
        load(tmp_path, json.dumps(tree), "a.gltf")


def test_glb_container_that_lies(tmp_path: Path) -> None:
    good = trimesh.creation.box().export(file_type="glb")
    for broken in (good[:-10], good[:16], b"glTF" + struct.pack("<II", 1, 12)):
        with pytest.raises(InputError):
            load(tmp_path, broken, "a.glb")
    longer = good[:12] + struct.pack("<I", 1 << 31) + good[16:]
    with pytest.raises(InputError, match="truncated GLB chunk"):
        load(tmp_path, longer, "a.glb")


def test_deeply_nested_json_is_an_error_not_a_crash(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="not JSON"):
        load(tmp_path, '{"asset":' + "[" * 100_000, "a.gltf")
