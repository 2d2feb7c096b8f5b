"""Small files that promise, nest or multiply without end: a typed, located error, and soon."""

import json
import os
import resource
import struct
import sys
import tracemalloc
from pathlib import Path
from time import process_time
from typing import Any

import gltf_triangle
import pytest

from assetpipe.errors import AssetpipeError, LimitError
from assetpipe.geometry import read_mesh
from assetpipe.geometry.formats.raw import FileLimits

MEMORY = 256 * 2**20 // 1024 if sys.platform != "darwin" else 256 * 2**20
"""What a refusal may add to the peak of the process, in the units of ru_maxrss."""
SECONDS = 5.0
HUGE = 10**15


def gltf(**change: Any) -> str:
    return json.dumps(gltf_triangle.gltf(**change))


def accessor(**change: Any) -> str:
    first = {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"} | change
    second = {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"}
    return gltf(accessors=[first, second])


def dae(source: str = "0 0 0 1 0 0 0 1 0", count: int = 3, p: str = "0 1 2", more: str = "") -> str:
    return f"""<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<library_geometries><geometry id="g"><mesh>
<source id="s"><float_array id="a" count="9">{source}</float_array><technique_common>
<accessor source="#a" count="{count}" stride="3"/></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
<triangles count="{count}"><input semantic="VERTEX" source="#v" offset="0"/><p>{p}</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="c"><node><instance_geometry url="#g"/></node>{more}
</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#c"/></scene></COLLADA>"""


SPARSE = {
    "count": HUGE,
    "indices": {"bufferView": 1, "componentType": 5123},
    "values": {"bufferView": 0},
}
SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
PLY = (
    "ply\nformat {} 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
)
LIST = "element face {}\nproperty list {} int vertex_indices\nend_header\n"

CASES: dict[str, tuple[str, str | bytes]] = {
    "count": ("a.stl", b"\0" * 80 + struct.pack("<I", 2**32 - 1) + b"\0" * 50),
    "count and the word solid": ("a.stl", b"solid" + b" " * 75 + struct.pack("<I", 2**31)),
    "one endless line": ("a.stl", "solid " + "x" * 3_000_000 + "\nfacet"),
    "index of 2^62": ("a.obj", SQUARE + f"f 1 2 {2**62}\n"),
    "index of -2^63": ("a.obj", SQUARE + f"f 1 2 {-(2**63)}\n"),
    "index of a thousand digits": ("a.obj", SQUARE + "f 1 2 " + "9" * 1000 + "\n"),
    "number of ten thousand digits": ("a.obj", "v 0 0 " + "9" * 10_000 + "\nf 1 1 1\n"),
    "face without end": ("a.obj", SQUARE + "f" + " 1 2 3 4" * 200_000 + " 5\n"),
    "counts of off": ("a.off", f"OFF\n{HUGE} {HUGE} 0\n0 0 0\n"),
    "polygon of off": ("a.off", f"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n{HUGE} 0 1 2\n"),
    "ascii vertices of ply": ("a.ply", PLY.format("ascii", HUGE) + LIST.format(1, "uchar")),
    "vertices of ply": (
        "a.ply",
        PLY.format("binary_little_endian", HUGE) + LIST.format(1, "uchar"),
    ),
    "faces of ply": (
        "a.ply",
        PLY.format("binary_little_endian", 1) + LIST.format(HUGE, "uchar") + "\0" * 12,
    ),
    "list of ply": (
        "a.ply",
        PLY.format("binary_little_endian", 1) + LIST.format(1, "uint") + "\0" * 12 + "\x7f" * 4,
    ),
    "rows of ply of many digits": (
        "a.ply",
        PLY.format("ascii", "9" * 5000) + LIST.format(1, "int"),
    ),
    "rows of ply of another element": (
        "a.ply",
        "ply\nformat binary_little_endian 1.0\nelement other 20000000\nproperty list uchar char q\n"
        "end_header\n" + "\0" * 20_000_000,
    ),
    "polygon of ply": (
        "a.ply",
        PLY.format("binary_little_endian", 1)
        + "element face 1\nproperty list uint uchar vertex_indices\nend_header\n"
        + "\0" * 12
        + struct.pack("<I", 20_000_000).decode("latin-1")
        + "\0" * 20_000_000,
    ),
    "list of ply of 2^63": (
        "a.ply",
        PLY.format("binary_little_endian", 1)
        + LIST.format(1, "uint64")
        + "\0" * 12
        + struct.pack("<QI", 2**63, 0).decode("latin-1"),
    ),
    "count of an accessor": ("a.gltf", accessor(count=HUGE)),
    "count without data": ("a.gltf", accessor(bufferView=None, count=HUGE)),
    "sparse count": ("a.gltf", accessor(sparse=SPARSE)),
    "sparse without indices": ("a.gltf", accessor(sparse={"count": 1})),
    "offset": ("a.gltf", accessor(byteOffset=2**63)),
    "negative offset": ("a.gltf", accessor(byteOffset=-12)),
    "view that is a text": ("a.gltf", accessor(bufferView="0")),
    "count that is no number": ("a.gltf", accessor(count=1e308)),
    "stride": (
        "a.gltf",
        gltf(bufferViews=[{"buffer": 0, "byteLength": 36, "byteStride": HUGE}] * 2),
    ),
    "view longer than its buffer": (
        "a.gltf",
        gltf(bufferViews=[{"buffer": 0, "byteLength": HUGE}] * 2),
    ),
    "buffer without end": ("a.gltf", gltf(buffers=[{"byteLength": HUGE, "uri": "zero.bin"}])),
    "buffer elsewhere": ("a.gltf", gltf(buffers=[{"byteLength": 1, "uri": "../../etc/passwd"}])),
    "buffer by root": ("a.gltf", gltf(buffers=[{"byteLength": 1, "uri": "/etc/passwd"}])),
    "buffer by scheme": ("a.gltf", gltf(buffers=[{"byteLength": 1, "uri": "file:///etc/passwd"}])),
    "device": ("a.gltf", gltf(buffers=[{"byteLength": 1, "uri": "/dev/zero"}])),
    "not a tree": ("a.gltf", "[" * 50_000),
    "meshes that are no list": ("a.gltf", gltf(meshes={"0": 1})),
    "nodes that multiply": (
        "a.gltf",
        gltf(nodes=[{"children": [k + 1, k + 1]} for k in range(60)] + [{"mesh": 0}]),
    ),
    "component that is a list": ("a.gltf", accessor(componentType=[5126])),
    "sparse component that is a tree": (
        "a.gltf",
        accessor(sparse={"count": 1, "indices": {"componentType": {}}, "values": {}}),
    ),
    "matrix of numbers of 400 digits": (
        "a.gltf",
        gltf(nodes=[{"mesh": 0, "matrix": [10**400] * 16}]),
    ),
    "step beyond a single item": (
        "a.gltf",
        gltf(
            accessors=[{"bufferView": 0, "componentType": 5126, "count": 1, "type": "VEC3"}] * 2,
            bufferViews=[{"buffer": 0, "byteLength": 36, "byteStride": 10**30}],
        ),
    ),
    "node that is no object": ("a.gltf", gltf(nodes=[[]])),
    "all nodes one by one": (
        "a.gltf",
        gltf(scenes=[{"nodes": list(range(100_000))}], nodes=[{}] * 100_000),
    ),
    "buffer of no url": ("a.gltf", gltf(buffers=[{"byteLength": 1, "uri": "//[a"}])),
    "buffer with a zero": ("a.gltf", gltf(buffers=[{"byteLength": 1, "uri": "%00.bin"}])),
    "buffer of half a character": ("a.gltf", gltf(buffers=[{"byteLength": 1, "uri": "\ud800"}])),
    "buffer of links in a circle": ("a.gltf", gltf(buffers=[{"byteLength": 1, "uri": "circle"}])),
    "buffer that is a pipe": ("a.gltf", gltf(buffers=[{"byteLength": 1, "uri": "pipe"}])),
    "buffer with an endless name": ("a.gltf", gltf(buffers=[{"byteLength": 1, "uri": "a" * 5000}])),
    "chunk": ("a.glb", struct.pack("<4sIIII", b"glTF", 2, 20, 2**32 - 1, 0x4E4F534A)),
    "index of dae": ("a.dae", dae(p=f"0 1 {2**62}")),
    "count of dae": ("a.dae", dae(count=HUGE)),
    "vcount of dae": (
        "a.dae",
        dae(more="")
        .replace("<p>", f"<vcount>{2**63 - 1} {2**63 - 1} 2 3</vcount><p>")
        .replace("triangles", "polylist"),
    ),
    "sources of dae that share an array": (
        "a.dae",
        dae(source="1 " * 300_000, p="0 1 9").replace(
            "<triangles",
            "".join(
                f'<source id="s{k}"><technique_common><accessor source="#a" count="3" stride="3"/>'
                f'</technique_common></source><vertices id="v{k}"><input semantic="POSITION" '
                f'source="#s{k}"/></vertices><triangles count="1"><input semantic="VERTEX" '
                f'source="#v{k}" offset="0"/><p>0 1 2</p></triangles>'
                for k in range(500)
            )
            + "<triangles",
        ),
    ),
    "numbers of dae": ("a.dae", dae(source="1e999 " * 9)),
    "nodes without end": ("a.dae", dae(more="<node>" * 50_000 + "</node>" * 50_000)),
    "entities": ("a.dae", '<!DOCTYPE a [<!ENTITY b "&b;&b;">]>' + dae()),
}


@pytest.mark.parametrize("case", CASES)
def test_what_lies_is_refused_soon(tmp_path: Path, case: str) -> None:
    name, content = CASES[case]
    path = tmp_path / name
    path.write_bytes(content.encode("latin-1") if isinstance(content, str) else content)
    (tmp_path / "zero.bin").write_bytes(b"\0" * 64)
    (tmp_path / "circle").symlink_to("circle")
    os.mkfifo(tmp_path / "pipe")
    peak, clock = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, process_time()
    with pytest.raises(AssetpipeError) as caught:
        read_mesh(path)
    assert caught.value.location is not None
    assert caught.value.location.file == path
    assert process_time() - clock < SECONDS
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - peak < MEMORY


def test_primitives_that_share_a_large_accessor_are_counted_one_by_one(tmp_path: Path) -> None:
    path = tmp_path / "a.gltf"
    primitives = [{"attributes": {"POSITION": 0}}] * 3_000
    zeros = {"componentType": 5126, "count": 3_000, "type": "VEC3"}
    path.write_text(gltf(meshes=[{"primitives": primitives}], accessors=[zeros]))
    tracemalloc.start()
    try:
        with pytest.raises(LimitError, match="vertices"):
            read_mesh(path, limits=FileLimits(max_bytes=1_000_000, max_vertices=10_000))
        assert tracemalloc.get_traced_memory()[1] < 20_000_000
    finally:
        tracemalloc.stop()


def test_statements_of_obj_that_make_no_triangles_are_limited_too(tmp_path: Path) -> None:
    path = tmp_path / "a.obj"
    path.write_text(SQUARE + "f 1 2\n" * 1000 + "f 1 2 3\n")
    assert len(read_mesh(path).mesh.faces) == 1
    with pytest.raises(LimitError):
        read_mesh(path, limits=FileLimits(max_vertices=500, max_faces=500))
