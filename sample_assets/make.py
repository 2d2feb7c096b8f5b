"""Makes the sample packages: ``python sample_assets/make.py [folder]``.

Every shape is built here from boxes and cylinders with exact booleans, so the
packages carry no foreign licence. The output is the same on every run.
Mesh formats and habits are mixed on purpose: they are what real packages do.
"""

from __future__ import annotations

import struct
import sys
from pathlib import Path

import numpy as np
from manifold3d import Manifold

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
ROUND = 40  # segments of a full circle


# --- shapes, in metres ------------------------------------------------------------------


def box(lower, upper) -> Manifold:
    """An axis-aligned box between two corners."""
    size = [b - a for a, b in zip(lower, upper, strict=True)]
    return Manifold.cube(size).translate(list(lower))


def rod(start, length: float, radius: float, axis=Z, segments: int = ROUND) -> Manifold:
    """A cylinder that starts at a point and runs along +axis."""
    body = Manifold.cylinder(length, radius, radius, segments)
    if axis == X:
        body = body.rotate([0, 90, 0])
    elif axis == Y:
        body = body.rotate([-90, 0, 0])
    return body.translate(list(start))


def tube(start, length: float, outer: float, inner: float, axis=Z) -> Manifold:
    """A cylinder with a through bore."""
    return rod(start, length, outer, axis) - rod(start, length, inner, axis)


def arrays(shape: Manifold) -> tuple[np.ndarray, np.ndarray]:
    """Vertices rounded to a nanometre, and faces, in a stable order."""
    mesh = shape.to_mesh64() if hasattr(shape, "to_mesh64") else shape.to_mesh()
    vertices = np.round(np.asarray(mesh.vert_properties)[:, :3].astype(float), 9) + 0.0
    faces = np.asarray(mesh.tri_verts).astype(int)
    order = np.lexsort(vertices.T[::-1])
    place = np.empty(len(order), dtype=int)
    place[order] = np.arange(len(order))
    faces = place[faces]
    first = faces.argmin(axis=1)
    faces = np.take_along_axis(faces, (first[:, None] + np.arange(3)) % 3, axis=1)
    return vertices[order], faces[np.lexsort(faces.T[::-1])]


# --- the arm ----------------------------------------------------------------------------


def arm_base() -> Manifold:
    """A foot with four bolt holes and a hollow pedestal."""
    foot = rod((0, 0, 0), 0.016, 0.09)
    for a in range(4):
        x, y = 0.072 * np.cos(np.pi / 4 + a * np.pi / 2), 0.072 * np.sin(np.pi / 4 + a * np.pi / 2)
        foot -= rod((x, y, -0.01), 0.04, 0.0055, segments=20)
    return foot + rod((0, 0, 0), 0.12, 0.058) - rod((0, 0, -0.01), 0.118, 0.05)


def arm_shoulder() -> Manifold:
    """A turntable with a clevis: two cheeks that hold the upper arm between them."""
    cheeks = box((-0.04, -0.062, 0.0), (0.04, 0.062, 0.11)) + rod((0, -0.062, 0.11), 0.124, 0.04, Y)
    gap = box((-0.06, -0.042, 0.02), (0.06, 0.042, 0.2))
    bores = rod((0, -0.1, 0.11), 0.2, 0.012, Y)
    return rod((0, 0, 0), 0.02, 0.064) + cheeks - gap - bores


def arm_upper() -> Manifold:
    """A beam with hubs at both ends and a window."""
    beam = box((-0.03, -0.024, 0.0), (0.03, 0.024, 0.28))
    hubs = rod((0, -0.038, 0), 0.076, 0.036, Y) + rod((0, -0.038, 0.28), 0.076, 0.034, Y)
    window = box((-0.016, -0.1, 0.07), (0.016, 0.1, 0.21))
    bores = rod((0, -0.1, 0), 0.2, 0.012, Y) + rod((0, -0.1, 0.28), 0.2, 0.012, Y)
    return beam + hubs - window - bores


def arm_forearm() -> Manifold:
    """A channel, open towards +x, with two cheeks around the elbow."""
    outer = box((-0.032, -0.052, 0.04), (0.032, 0.052, 0.22))
    elbow = box((-0.03, -0.052, -0.03), (0.03, 0.052, 0.06))
    gap = box((-0.05, -0.04, -0.05), (0.05, 0.04, 0.045))
    channel = box((-0.022, -0.042, 0.055), (0.1, 0.042, 0.205))
    return outer + elbow - gap - channel - rod((0, -0.1, 0), 0.2, 0.012, Y)


def arm_wrist_roll() -> Manifold:
    """A tube with a fork."""
    body = tube((0, 0, 0), 0.05, 0.034, 0.022)
    fork = box((-0.02, -0.034, 0.045), (0.02, 0.034, 0.1)) - box(
        (-0.05, -0.024, 0.06), (0.05, 0.024, 0.2)
    )
    return body + fork - rod((0, -0.1, 0.085), 0.2, 0.008, Y)


def arm_wrist_pitch() -> Manifold:
    """An angle bracket."""
    eye = rod((0, -0.022, 0), 0.044, 0.018, Y) - rod((0, -0.1, 0), 0.2, 0.008, Y)
    arm = box((-0.014, -0.022, 0.01), (0.014, 0.022, 0.03))
    shelf = box((-0.03, -0.03, 0.03), (0.03, 0.03, 0.036))
    web = box((0.024, -0.03, 0.008), (0.03, 0.03, 0.036))
    return eye + arm + shelf + web


def arm_flange() -> Manifold:
    """A ring with six screw holes."""
    ring = tube((0, 0, 0), 0.012, 0.0315, 0.015)
    for a in range(6):
        ring -= rod(
            (0.024 * np.cos(a * np.pi / 3), 0.024 * np.sin(a * np.pi / 3), -0.01),
            0.05,
            0.0025,
            segments=16,
        )
    return ring


def gripper_palm() -> Manifold:
    """A housing with a T-slot for the fingers."""
    body = box((-0.025, -0.055, 0.0), (0.025, 0.055, 0.045))
    slot = box((-0.008, -0.1, 0.03), (0.008, 0.1, 0.1)) + box(
        (-0.014, -0.1, 0.022), (0.014, 0.1, 0.032)
    )
    return body - slot


def gripper_finger() -> Manifold:
    """The left finger: a foot, a stem and a hooked pad."""
    foot = box((-0.007, 0.0, 0.0), (0.007, 0.022, 0.02))
    stem = box((-0.007, 0.01, 0.02), (0.007, 0.022, 0.075))
    pad = box((-0.011, 0.0, 0.06), (0.011, 0.014, 0.105))
    groove = rod((0, 0, 0.05), 0.07, 0.006, Z, 24)
    return foot + stem + pad - groove


# --- furniture and kitchen ----------------------------------------------------------------


def cabinet_body() -> Manifold:
    """A carcass with one bay, open at the front (+x)."""
    outer = box((-0.2, -0.25, 0.0), (0.2, 0.25, 0.3))
    return outer - box((-0.185, -0.235, 0.015), (0.3, 0.235, 0.285))


def cabinet_drawer() -> Manifold:
    """A tray, open at the top, with a front panel."""
    tray = box((-0.18, -0.225, 0.0), (0.185, 0.225, 0.2)) - box(
        (-0.17, -0.215, 0.01), (0.175, 0.215, 0.4)
    )
    return tray + box((0.185, -0.248, -0.02), (0.203, 0.248, 0.262))


def cabinet_handle() -> Manifold:
    """A bar on two posts: fingers go behind the bar."""
    bar = rod((0.045, -0.075, 0), 0.15, 0.007, Y, 24)
    posts = rod((0, -0.065, 0), 0.045, 0.006, X, 20) + rod((0, 0.065, 0), 0.045, 0.006, X, 20)
    return bar + posts


def toaster_body() -> Manifold:
    """A housing with two bread slots and a slit for the lever."""
    body = box((-0.14, -0.085, 0.01), (0.14, 0.085, 0.19))
    for y in (-0.035, 0.035):
        body -= box((-0.11, y - 0.015, 0.05), (0.11, y + 0.015, 0.3))
    body -= box((0.12, -0.004, 0.06), (0.3, 0.004, 0.16))
    for x in (-0.11, 0.11):
        for y in (-0.06, 0.06):
            body += rod((x, y, 0), 0.012, 0.012, segments=20)
    return body


def toaster_lever() -> Manifold:
    """A knob on a thin stem that runs in the slit."""
    return box((0.0, -0.003, -0.004), (0.03, 0.003, 0.004)) + box(
        (0.025, -0.02, -0.008), (0.045, 0.02, 0.008)
    )


def lamp_foot() -> Manifold:
    """A heavy round foot with a socket."""
    return rod((0, 0, 0), 0.025, 0.09) + tube((0, 0, 0.02), 0.04, 0.018, 0.01)


def lamp_shade() -> Manifold:
    """An open cone."""
    outer = Manifold.cylinder(0.1, 0.03, 0.08, ROUND)
    inner = Manifold.cylinder(0.1, 0.027, 0.077, ROUND).translate([0, 0, 0.004])
    return outer - inner


# --- files ------------------------------------------------------------------------------


def write_stl(shape: Manifold, path: Path, header: bytes = b"sample asset") -> None:
    """Binary STL. Some exporters begin the header with 'solid': one of ours does too."""
    v, f = arrays(shape)
    corners = v[f].astype("<f4")
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    normal = np.divide(normal, length, out=np.zeros_like(normal), where=length > 0)
    rows = np.zeros(
        len(f), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")]
    )
    rows["normal"], rows["corners"] = normal, corners
    path.write_bytes(header.ljust(80, b"\0") + struct.pack("<I", len(f)) + rows.tobytes())


def write_stl_text(shape: Manifold, path: Path) -> None:
    """ASCII STL."""
    v, f = arrays(shape)
    lines = ["solid sample"]
    for triangle in v[f]:
        n = np.cross(triangle[1] - triangle[0], triangle[2] - triangle[0])
        n = n / (np.linalg.norm(n) or 1.0) + 0.0
        lines.append("  facet normal " + " ".join(f"{c:.6g}" for c in n))
        lines.append("    outer loop")
        lines += ["      vertex " + " ".join(f"{c:.9g}" for c in corner) for corner in triangle]
        lines += ["    endloop", "  endfacet"]
    path.write_text("\n".join([*lines, "endsolid sample", ""]))


def write_obj(shape: Manifold, path: Path) -> None:
    """Wavefront OBJ."""
    v, f = arrays(shape)
    lines = ["v " + " ".join(f"{c:.9g}" for c in p) for p in v]
    lines += ["f " + " ".join(str(i + 1) for i in t) for t in f]
    path.write_text("\n".join([*lines, ""]))


def write_ply(shape: Manifold, path: Path) -> None:
    """ASCII PLY."""
    v, f = arrays(shape)
    head = f"""ply
format ascii 1.0
element vertex {len(v)}
property double x
property double y
property double z
element face {len(f)}
property list uchar int vertex_indices
end_header
"""
    lines = [" ".join(f"{c:.9g}" for c in p) for p in v]
    lines += ["3 " + " ".join(map(str, t)) for t in f]
    path.write_text(head + "\n".join([*lines, ""]))


def write_dae_millimetres(shape: Manifold, path: Path) -> None:
    """COLLADA in millimetres, as CAD exporters write it."""
    v, f = arrays(shape)
    positions = " ".join(f"{c * 1000:.7g}" for c in v.ravel())
    indices = " ".join(map(str, f.ravel()))
    path.write_text(f"""<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
  <asset>
    <created>2026-01-01T00:00:00Z</created>
    <modified>2026-01-01T00:00:00Z</modified>
    <unit name="millimeter" meter="0.001"/>
    <up_axis>Z_UP</up_axis>
  </asset>
  <library_geometries>
    <geometry id="shape" name="shape">
      <mesh>
        <source id="positions">
          <float_array id="positions-array" count="{v.size}">{positions}</float_array>
          <technique_common>
            <accessor source="#positions-array" count="{len(v)}" stride="3">
              <param name="X" type="float"/>
              <param name="Y" type="float"/>
              <param name="Z" type="float"/>
            </accessor>
          </technique_common>
        </source>
        <vertices id="vertices">
          <input semantic="POSITION" source="#positions"/>
        </vertices>
        <triangles count="{len(f)}">
          <input semantic="VERTEX" source="#vertices" offset="0"/>
          <p>{indices}</p>
        </triangles>
      </mesh>
    </geometry>
  </library_geometries>
  <library_visual_scenes>
    <visual_scene id="scene" name="scene">
      <node id="node" name="node"><instance_geometry url="#shape"/></node>
    </visual_scene>
  </library_visual_scenes>
  <scene><instance_visual_scene url="#scene"/></scene>
</COLLADA>
""")


WRITERS = {
    ".stl": write_stl,
    ".obj": write_obj,
    ".ply": write_ply,
    ".dae": write_dae_millimetres,
}

SHAPES = {
    "arm_gripper": {
        "base_link.stl": arm_base,
        "shoulder_link.obj": arm_shoulder,
        "upper_arm_link.dae": arm_upper,
        "forearm_link.stl": arm_forearm,
        "wrist_roll_link.stl": arm_wrist_roll,
        "wrist_pitch_link.obj": arm_wrist_pitch,
        "flange_link.ply": arm_flange,
        "flange_visual.obj": arm_flange,  # PyBullet refuses PLY as a visual
        "palm_link.obj": gripper_palm,
        "finger_link.stl": gripper_finger,
    },
    "cabinet": {
        "body.obj": cabinet_body,
        "drawer.stl": cabinet_drawer,
        "handle.stl": cabinet_handle,
    },
    "toaster": {"body.stl": toaster_body, "lever.obj": toaster_lever},
    "desk_lamp": {"foot.stl": lamp_foot, "shade.obj": lamp_shade},
}


def main() -> None:
    """Write all meshes below the given folder (default: beside this script)."""
    root = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent
    for package, shapes in SHAPES.items():
        folder = root / package / "meshes"
        folder.mkdir(parents=True, exist_ok=True)
        for name, make in shapes.items():
            path = folder / name
            if name == "forearm_link.stl":
                write_stl_text(make(), path)
            elif name == "wrist_roll_link.stl":
                write_stl(make(), path, header=b"solid exported by a tool that should know better")
            else:
                WRITERS[path.suffix](make(), path)


if __name__ == "__main__":
    main()
