"""Original meshes by trimesh, and hulls as they were written."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, QhullError
from verify.urdf import parse

ROUNDING = 1e-9
"""Of the size: what a vertex may lie outside a hull's face."""


def load_original(path: Path) -> list[tuple[np.ndarray, np.ndarray]]:
    """Vertices in metres and faces; for formats with an up-axis turned and as stored."""
    loaded = trimesh.load(path, force="mesh", process=False, skip_materials=True)
    vertices, faces = np.array(loaded.vertices, float), np.array(loaded.faces, np.int64)
    up = "Z_UP"
    if path.suffix.lower() == ".dae":
        root = parse(path.read_bytes())
        space = root.tag.split("}")[0] + "}"
        unit = root.find(f"{space}asset/{space}unit")
        if unit is not None:
            vertices = vertices * float(unit.get("meter") or 1.0)
        up = (root.findtext(f"{space}asset/{space}up_axis") or "Y_UP").strip()
    elif path.suffix.lower() in (".glb", ".gltf"):
        up = "Y_UP"
    forms = [(vertices, faces)]
    if up == "Y_UP":
        forms.append((vertices @ np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]]), faces))
    return forms


def shells_of(vertices: np.ndarray, faces: np.ndarray):
    """Welded vertices; faces as wound in the file, with closed shells outward, and of these the
    closed shells only; whether all is closed."""
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    mesh.merge_vertices(merge_tex=True, merge_norm=True)
    faces = np.asarray(mesh.faces)
    distinct = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2])
    distinct &= faces[:, 0] != faces[:, 2]
    mesh.update_faces(distinct)
    wound = np.array(mesh.faces, np.int64)
    trimesh.repair.fix_winding(mesh)
    faces = np.array(mesh.faces, np.int64)
    points = np.array(mesh.vertices, float)
    count, labels = connected_components(
        trimesh.graph.edges_to_coo(mesh.face_adjacency, count=len(faces)), directed=False
    )
    # An open shell's volume says nothing: there the file's winding decides.
    a, b, c = (points[faces[:, k]] - points.mean(axis=0) for k in range(3))
    volume = np.bincount(labels, np.einsum("ij,ij->i", a, np.cross(b, c)), minlength=count)
    flip = volume[labels] < 0
    faces[flip] = faces[flip][:, ::-1]
    # Sheets in or beside a body take from its winding number.
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    used, times = np.unique(np.c_[np.repeat(labels, 3), edges], axis=0, return_counts=True)
    sealed = np.bincount(used[:, 0], times != 2, minlength=count) == 0
    windings = tuple(map(np.ascontiguousarray, (wound, faces, faces[sealed[labels]])))
    return points, windings, mesh.is_watertight


def read_hull(path: Path) -> tuple[np.ndarray, list[list[int]], str]:
    """Vertices, faces and the first comment of an OBJ; own parsing, nothing merged."""
    vertices, faces, comment = [], [], ""
    for line in path.read_text().splitlines():
        if line.startswith("#"):
            comment = comment or line
        elif line.startswith("v "):
            vertices.append([float(x) for x in line.split()[1:4]])
        elif line.startswith("f "):
            faces.append([int(x.split("/")[0]) - 1 for x in line.split()[1:]])
    return np.array(vertices, float).reshape(-1, 3), faces, comment


def hull_defects(vertices: np.ndarray, faces: list[list[int]]) -> list[str]:
    """Everything that keeps it from being one closed, outward, convex, clean polytope."""
    found = []
    if len(vertices) < 4 or len(faces) < 4 or not np.isfinite(vertices).all():
        return ["fewer than four vertices or faces, or not finite"]
    size = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    if len(np.unique(vertices, axis=0)) < len(vertices):
        found.append("duplicate vertices")
    if {v for f in faces for v in f} != set(range(len(vertices))):
        found.append("unused or missing vertices")
    if any(len(set(f)) != len(f) or len(f) < 3 for f in faces):
        found.append("a face repeats a vertex")
    edges = [(f[k], f[(k + 1) % len(f)]) for f in faces for k in range(len(f))]
    if len(set(edges)) < len(edges):
        found.append("an edge has two faces on one side")
    if set(edges) != {(b, a) for a, b in edges}:
        found.append("not closed")
    if len(vertices) - len(edges) // 2 + len(faces) != 2:
        found.append("not one sphere (Euler)")
    triangles = np.array([(f[0], f[k], f[k + 1]) for f in faces for k in range(1, len(f) - 1)])
    centred = vertices - vertices.mean(axis=0)
    a, b, c = (centred[triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    double = np.linalg.norm(normals, axis=1)
    longest = np.max([np.linalg.norm(x, axis=1) for x in (b - a, c - b, a - c)], axis=0)
    height = double / np.maximum(longest, 1e-300)
    if (height <= 1e-14 * size).any():
        found.append(f"{int((height <= 1e-14 * size).sum())} faces without area")
    volume = float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)
    if volume <= 0:
        found.append(f"volume {volume:g}: not outward")
    # A sliver's own plane is known only to rounding over its height.
    sound = height > 1e-7 * size
    unit = normals[sound] / double[sound, None]
    beyond = (centred @ unit.T - np.einsum("ij,ij->i", unit, a[sound])).max(initial=0.0)
    if beyond > ROUNDING * size:
        found.append(f"not convex: a vertex {beyond / size:.2g} of the size outside a face")
    try:
        qhull = ConvexHull(vertices)
        if abs(qhull.volume - volume) > 1e-8 * qhull.area * size:
            found.append(f"volume {volume:g}, of the convex hull {qhull.volume:g}")
    except QhullError:
        found.append("flat: Qhull finds no volume")
    return found
