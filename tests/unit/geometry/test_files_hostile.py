"""Small files that promise, nest or multiply without end: a typed, located error, and soon."""

import json
import resource
import struct
import sys
from pathlib import Path
from time import process_time
from typing import Any

import gltf_triangle
import pytest

from assetpipe.errors import AssetpipeError
from assetpipe.geometry import read_mesh

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
    "chunk": ("a.glb", struct.pack("<4sIIII", b"glTF", 2, 20, 2**32 - 1, 0x4E4F534A)),
    "index of dae": ("a.dae", dae(p=f"0 1 {2**62}")),
    "count of dae": ("a.dae", dae(count=HUGE)),
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
    peak, clock = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, process_time()
    with pytest.raises(AssetpipeError) as caught:
        read_mesh(path)
    assert caught.value.location is not None
    assert caught.value.location.file == path
    assert process_time() - clock < SECONDS
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - peak < MEMORY
