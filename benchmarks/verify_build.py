"""Checks a built robot from outside: shares no code with assetpipe.

    python benchmarks/verify_build.py ORIGINAL.urdf BUILT_PACKAGE [--rebuild] [--json]

lxml reads the URDFs, trimesh the original meshes, Qhull judges convexity, libigl measures
distances and winding numbers, PyBullet loads the result in a process of its own. Measures
are taken on samples: a violation disproves a claim, none only fails to. With ``--rebuild``
the robot is built twice more, with other jobs, hash seed and working directory, and again
with a warm cache. Exit code 1 if anything is wrong.
"""

from __future__ import annotations

import argparse
import filecmp
import hashlib
import json
import os
import re
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import igl
import numpy as np
import trimesh
from lxml import etree
from scipy import ndimage
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, QhullError, cKDTree
from scipy.spatial.transform import Rotation

ROUNDING = 1e-9
"""Of the size: what a vertex may lie outside a hull's face."""
SIMPLE = {
    "box": ["size"],
    "cylinder": ["radius", "length"],
    "capsule": ["radius", "length"],
    "sphere": ["radius"],
}
TOKEN = re.compile(
    rb"<!--.*?-->|<!\[CDATA\[.*?\]\]>|<\?.*?\?>|<collision\b[^>]*?/>|<collision\b|</collision\s*>",
    re.DOTALL,
)
TIME_STAMP = re.compile(r"\b20\d\d-\d\d-\d\d[T ]\d\d:\d\d")
ABSOLUTE = re.compile(r'(?:^|[\s"\'(=])/(?:[\w.\-]+/)+[\w.\-]*')


class Verdict:
    """What was found wrong, and what was measured."""

    def __init__(self) -> None:
        self.violations: list[str] = []
        self.notes: list[str] = []
        self.facts: dict[str, object] = {}

    def expect(self, holds: bool, what: str) -> bool:
        if not holds:
            self.violations.append(what)
        return holds


# --- URDF ---------------------------------------------------------------------------------


def cut_at_collisions(data: bytes) -> tuple[list[bytes], list[bytes]]:
    """Bytes between the collision elements (one more than these), and the elements."""
    between, elements, last, opened = [], [], 0, None
    for token in TOKEN.finditer(data):
        text = token.group()
        if text.startswith(b"<!--") or text.startswith(b"<!["):
            continue
        if text.startswith(b"<collision") and text.endswith(b"/>"):
            start = token.start()
        elif text.startswith(b"<collision"):
            opened = token.start() if opened is None else opened
            continue
        elif text.startswith(b"</collision") and opened is not None:
            start, opened = opened, None
        else:
            continue
        between.append(data[last:start])
        elements.append(data[start : token.end()])
        last = token.end()
    return [*between, data[last:]], elements


def parse(data: bytes):
    return etree.fromstring(data, etree.XMLParser(recover=True, huge_tree=True))


def collisions(root) -> list[tuple[str, int, object]]:
    """(link, index, element), in document order."""
    return [
        (link.get("name"), index, element)
        for link in root.findall("link")
        for index, element in enumerate(link.findall("collision"))
    ]


def origin(element) -> tuple[float, ...]:
    found = element.find("origin")
    read = (found.get("xyz"), found.get("rpy")) if found is not None else (None, None)
    return tuple(float(v) for text in read for v in (text or "0 0 0").split())


def resolve(uri: str, urdf: Path, ceiling: Path | None = None) -> Path | None:
    """The file that a reference means, from where the URDF lies; nothing above ``ceiling``."""
    folders = [urdf.parent, *urdf.parent.parents]
    if ceiling is not None:
        folders = [f for f in folders if f == ceiling or ceiling in f.parents]
    if uri.startswith("file://"):
        uri = uri[7:]
        tries = [Path(uri)] if uri.startswith("/") else [urdf.parent / uri]
    elif uri.startswith("package://") or uri.startswith("model://"):
        name, _, rest = uri.split("://", 1)[1].partition("/")
        tries = []
        for folder in folders:
            tries.append(folder / name / rest)
            if folder.name == name or package_name(folder) == name:
                tries.append(folder / rest)
        for folder in folders[:4]:
            tries += [child / rest for child in children(folder) if package_name(child) == name]
        tries += [folder / rest for folder in folders]
    else:
        tries = [urdf.parent / uri] if not uri.startswith("/") else [Path(uri)]
    return next((t for t in tries if t.is_file()), None)


def children(folder: Path) -> list[Path]:
    try:
        return sorted(p for p in folder.iterdir() if p.is_dir())
    except OSError:
        return []


def package_name(folder: Path) -> str | None:
    try:
        data = (folder / "package.xml").read_bytes()
        return (parse(data).findtext("name") or "").strip() or None
    except (OSError, etree.XMLSyntaxError, AttributeError):
        return None


def source_of(path: Path) -> bytes:
    """The URDF text; xacro is expanded by xacrodoc."""
    if path.suffix != ".xacro":
        return path.read_bytes()
    from xacrodoc import XacroDoc

    return XacroDoc.from_file(str(path), resolve_packages=False).to_urdf_string().encode()


# --- meshes -------------------------------------------------------------------------------


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
    """Welded vertices, faces as wound in the file, faces with closed shells outward; closed."""
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
    return points, np.ascontiguousarray(wound), np.ascontiguousarray(faces), mesh.is_watertight


def inside(queries, vertices, windings) -> np.ndarray:
    """Where the winding number of one of the orientations is above one half."""
    found = np.zeros(len(queries), bool)
    for faces in windings:
        size = max(1, 20_000_000 // max(1, len(faces)))
        for start in range(0, len(queries), size):
            part = np.ascontiguousarray(queries[start : start + size])
            number = np.asarray(igl.winding_number(vertices, faces, part)).ravel()
            found[start : start + size] |= np.abs(number) > 0.5
    return found


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


def planes_of(vertices: np.ndarray) -> np.ndarray | None:
    """Half-spaces normal · x + offset <= 0."""
    try:
        return np.unique(ConvexHull(vertices).equations, axis=0)
    except QhullError:
        return None


def on_surface(vertices, faces, count, rng) -> np.ndarray:
    """All vertices and uniform samples."""
    corner = vertices[np.asarray(faces)]
    area = np.linalg.norm(
        np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1
    )
    if not area.sum() > 0:
        return vertices
    tri = corner[rng.choice(len(corner), size=count, p=area / area.sum())]
    u, v = np.sort(rng.random((2, count, 1)), axis=0)
    return np.vstack([vertices, tri[:, 0] * u + tri[:, 1] * (v - u) + tri[:, 2] * (1 - v)])


def in_volume(vertices, count, rng) -> np.ndarray:
    """Convex combinations of four vertices each, dense towards the middle."""
    corners = vertices[rng.integers(0, len(vertices), size=(count, 4))]
    return (corners * rng.dirichlet(np.ones(4), size=count)[..., None]).sum(axis=1)


def outside_all(points: np.ndarray, planes: list[np.ndarray], bound: float) -> np.ndarray:
    """Least plane excess over the hulls (a lower bound of the distance to them)."""
    reach = np.full(len(points), np.inf)
    for p in planes:
        open_ = np.flatnonzero(reach > bound)
        if not len(open_):
            break
        for part in np.array_split(open_, max(1, len(open_) * len(p) // 4_000_000)):
            excess = (points[part] @ p[:, :3].T + p[:, 3]).max(axis=1)
            reach[part] = np.minimum(reach[part], excess)
    return reach


def matrix_of(element) -> np.ndarray:
    """(4, 4) from an element's origin: rotations about fixed x, y, z."""
    x, y, z, roll, pitch, yaw = origin(element)
    result = np.eye(4)
    result[:3, :3] = Rotation.from_euler("xyz", [roll, pitch, yaw]).as_matrix()
    result[:3, 3] = x, y, z
    return result


def simple_shape(child, element) -> tuple[str, np.ndarray, list[float]] | None:
    """Kind, frame relative to the old element, and sizes of a box, cylinder, capsule, sphere."""
    for kind, names in SIMPLE.items():
        found = child.find(f"geometry/{kind}")
        if found is not None:
            sizes = [float(v) for name in names for v in (found.get(name) or "").split()]
            return kind, np.linalg.inv(matrix_of(element)) @ matrix_of(child), sizes
    return None


def beyond_shape(points: np.ndarray, shape) -> np.ndarray:
    """How far points lie outside of a simple shape; at most 0 inside."""
    kind, frame, sizes = shape
    local = (points - frame[:3, 3]) @ frame[:3, :3]
    if kind == "box":
        return (np.abs(local) - 0.5 * np.array(sizes)).max(axis=1)
    if kind == "sphere":
        return np.linalg.norm(local, axis=1) - sizes[0]
    radius, half = sizes[0], 0.5 * sizes[1]
    across, along = np.linalg.norm(local[:, :2], axis=1), np.abs(local[:, 2])
    if kind == "cylinder":
        return np.maximum(across - radius, along - half)
    return np.hypot(across, np.maximum(along - half, 0.0)) - radius


def on_shape(shape, rng, count: int = 2000) -> np.ndarray:
    """Points on the surface of a simple shape, and corners of a box."""
    kind, frame, sizes = shape
    unit = rng.normal(size=(count, 3))
    unit /= np.linalg.norm(unit, axis=1, keepdims=True)
    if kind == "box":
        local = np.vstack([np.sign(unit), unit / np.abs(unit).max(axis=1, keepdims=True)])
        local *= 0.5 * np.array(sizes)
    elif kind == "sphere":
        local = unit * sizes[0]
    elif kind == "cylinder":
        ring = unit[:, :2] / np.linalg.norm(unit[:, :2], axis=1, keepdims=True) * sizes[0]
        local = np.column_stack([ring, np.sign(unit[:, 2]) * 0.5 * sizes[1]])
    else:
        local = unit * sizes[0] + np.sign(unit[:, 2:]) * [0.0, 0.0, 0.5 * sizes[1]]
    return local @ frame[:3, :3].T + frame[:3, 3]


def touched(points, vertices, windings, radius: float) -> np.ndarray:
    """Which points a ball from outside surely touches: its centre walks on a lattice whose
    points are all half a step farther from the surface than it must be."""
    low, high = vertices.min(axis=0) - 2 * radius, vertices.max(axis=0) + 2 * radius
    step = max(radius / 3, float(np.cbrt(np.prod(high - low) / 600_000)))
    shape = np.ceil((high - low) / step).astype(int) + 1
    lattice = np.stack(np.meshgrid(*(np.arange(n) for n in shape), indexing="ij"), axis=-1)
    centres = low + step * lattice.reshape(-1, 3)
    squared, *_ = igl.point_mesh_squared_distance(centres, vertices, windings[0])
    free = np.sqrt(np.asarray(squared).ravel()) >= radius + step / 2
    free[free] = ~inside(centres[free], vertices, windings)
    labels, _ = ndimage.label(free.reshape(shape))
    reached = centres[(labels == labels[0, 0, 0]).ravel() & free]
    distance, _ = cKDTree(reached).query(points)
    return distance < radius - 1e-9


# --- checks -------------------------------------------------------------------------------


def check_urdf(verdict: Verdict, original: bytes, built: bytes, successors: list[int]) -> None:
    """Bytes outside the collision elements are those of the original."""
    before, old = cut_at_collisions(original)
    after, new = cut_at_collisions(built)
    if not verdict.expect(
        sum(successors) == len(new) and len(successors) == len(old),
        f"report names {sum(successors)} collision elements for {len(successors)} old ones, "
        f"the URDFs have {len(new)} for {len(old)}",
    ):
        return
    place, kept = 0, [after[0]]
    for count in successors:
        for k in range(place + 1, place + count):
            verdict.expect(
                not after[k].strip(), f"text between successors: {after[k].strip()[:60]!r}"
            )
        place += count
        kept.append(after[place])
    differing = [k for k, (a, b) in enumerate(zip(before, kept, strict=True)) if a != b]
    verdict.expect(
        not differing,
        f"bytes outside of collision elements differ in {len(differing)} places, e.g. "
        f"{before[differing[0]][-80:]!r} -> {kept[differing[0]][-80:]!r}"
        if differing
        else "",
    )


def check_references(verdict: Verdict, root, old_root, urdf: Path, old_urdf: Path, out: Path):
    """Everything that is referred to is there and inside, if the original had it."""
    missing_before = {
        e.get("filename")
        for e in old_root.iter("mesh", "texture")
        if e.get("filename") and resolve(e.get("filename"), old_urdf) is None
    }
    for element in root.iter("mesh", "texture"):
        uri = element.get("filename")
        if not uri:
            continue
        path = resolve(uri, urdf, out)
        if path is None:
            if uri in missing_before:
                verdict.notes.append(f"'{uri}' was missing before, too")
            else:
                verdict.violations.append(f"'{uri}' does not resolve inside the package")
        elif out.resolve() not in path.resolve().parents:
            verdict.violations.append(f"'{uri}' leaves the package")
        elif path.suffix.lower() == ".obj" and path.stat().st_size < 50_000_000:
            for side in re.findall(rb"^mtllib\s+(.+?)\s*$", path.read_bytes(), re.MULTILINE):
                old = resolve(uri, old_urdf)
                name = side.decode(errors="replace")
                if old is not None and (old.parent / name).is_file():
                    verdict.expect(
                        (path.parent / name).is_file(), f"'{uri}' lost its material '{name}'"
                    )


def check_mesh(
    verdict: Verdict,
    entry: dict,
    path: Path,
    hulls: list[Path],
    simple: dict[Path, tuple],
    samples: int,
) -> None:
    """Hull files are sound, cover the solid, and keep their certificates; simple shapes lie in
    the hulls that were certified for them, and cover in their place."""
    rng = np.random.default_rng(0)
    who = f"{entry['name']} ({','.join(entry['links'][:3])})"
    read = [read_hull(h) for h in hulls]
    for file, (vertices, faces, _) in zip(hulls, read, strict=True):
        for defect in hull_defects(vertices, faces):
            verdict.violations.append(f"{who}: {file.name}: {defect}")
    verdict.expect(
        entry["hulls"] == len(hulls) and entry["hull_vertices"] == sum(len(v) for v, _, _ in read),
        f"{who}: report says {entry['hulls']} hulls, {entry['hull_vertices']} vertices; "
        f"on disk {len(hulls)}, {sum(len(v) for v, _, _ in read)}",
    )
    planes = [planes_of(v) for v, _, _ in read]
    shapes = [simple.get(h) for h in hulls]
    for file, own, shape in zip(hulls, planes, shapes, strict=True):
        if shape is not None and own is not None:
            surface = on_shape(shape, rng)
            excess = (surface @ own[:, :3].T + own[:, 3]).max()
            verdict.expect(
                excess <= ROUNDING * np.abs(surface).max(),
                f"{who}: {file.name}: the {shape[0]} reaches {excess:.3g} m out of it",
            )
    flat = [p for p, s in zip(planes, shapes, strict=True) if p is not None and s is None]
    scale = np.array(entry["scale"], float)
    moved = float((entry.get("repair") or {}).get("moved") or 0.0)
    upper = float(entry["certificate"]["thickening"]["upper"])
    best = None
    for form, (vertices, faces) in enumerate(load_original(path)):
        skin = on_surface(vertices * scale, faces, samples, rng)
        skin = skin[len(vertices) :] if len(vertices) > samples else skin
        size = float(np.linalg.norm(np.ptp(skin, axis=0)))
        uncovered = outside_all(skin, flat, 1e-9 * size)
        for shape in filter(None, shapes):
            uncovered = np.minimum(uncovered, beyond_shape(skin, shape))
        if best is None or uncovered.max() < best[0].max():
            best = (uncovered, skin, vertices * scale, faces, size, form)
    uncovered, skin, vertices, faces, size, form = best
    # trimesh reads COLLADA in single precision.
    slack = 1e-7 * max(size, float(np.abs(skin).max()))
    worst = int(uncovered.argmax())
    verdict.expect(
        uncovered[worst] <= moved + slack,
        f"{who}: surface {uncovered[worst]:.3g} m outside of all hulls at "
        f"{skin[worst].round(5).tolist()}, moved {moved:.3g} "
        f"({(uncovered > moved + slack).mean():.2%} of samples)",
    )
    points, wound, outward, closed = shells_of(vertices, faces)
    bounds = []
    cloud, owner = [], []
    per_hull = max(200, samples // max(1, len(read)))
    for number, (corners, hull_faces, comment) in enumerate(read):
        told = re.search(r"thickening at most ([0-9.eE+-]+)", comment)
        bounds.append(float(told.group(1)) if told else upper)
        triangles = [(f[0], f[k], f[k + 1]) for f in hull_faces for k in range(1, len(f) - 1)]
        mine = np.vstack(
            [on_surface(corners, triangles, per_hull, rng), in_volume(corners, per_hull // 2, rng)]
        )
        cloud.append(mine)
        owner.append(np.full(len(mine), number))
    if not cloud:
        return
    verdict.expect(
        max(bounds) <= upper * (1 + 1e-12), f"{who}: a hull file tells {max(bounds)} > {upper}"
    )
    if upper > entry["tolerance"] * (1 + 1e-12):
        verdict.notes.append(f"{who}: certified {upper:.4g}, tolerance {entry['tolerance']:.4g}")
    points_all, owner_all = np.vstack(cloud), np.concatenate(owner)
    squared, *_ = igl.point_mesh_squared_distance(points_all, points, outward)
    distance = np.sqrt(np.maximum(np.asarray(squared).ravel(), 0.0))
    allowed = np.array(bounds)[owner_all] + moved
    # Near the surface it does not matter on which side a point lies.
    far = np.flatnonzero(distance > 0.3 * allowed)
    distance[far[inside(points_all[far], points, (outward, wound))]] = 0.0
    suspects = np.flatnonzero(distance > allowed + slack)
    closed_up = entry.get("closed")
    if closed_up and len(suspects):
        # Towards the solid without what nothing can enter: only points that a ball touches count.
        radius = float(closed_up["reach"])
        suspects = suspects[touched(points_all[suspects], points, (outward, wound), radius)]
    excess = distance[suspects] - allowed[suspects]
    if len(suspects):
        k = suspects[excess.argmax()]
        verdict.violations.append(
            f"{who}: {hulls[owner_all[k]].name} reaches {distance[k]:.4g} m into free space at "
            f"{points_all[k].round(5).tolist()}, allowed {bounds[owner_all[k]]:.4g} + moved "
            f"{moved:.3g} ({len(suspects)} of {len(points_all)} points, original "
            f"{'closed' if closed else 'open'}, {(entry.get('repair') or {}).get('rung')})"
        )
    verdict.facts.setdefault("meshes", []).append(
        {
            "mesh": entry["name"],
            "hulls": len(hulls),
            "upper": upper,
            "moved": moved,
            "uncovered": float(max(0.0, uncovered[worst])),
            "farthest": float(distance.max()),
            "closed": closed,
            "turned": form == 1,
        }
    )


def check_files(verdict: Verdict, out: Path, report: dict, original: Path) -> None:
    """report.json and assetpipe.json tell what lies there, and nothing of this machine."""
    listed = {
        file
        for robot in report["robots"]
        for link in robot["links"].values()
        for element in elements_of(link)
        for file in element["files"]
    }
    verdict.expect(
        all((out / f).is_file() for f in listed), "report names hull files that are not there"
    )
    there = {p.relative_to(out).as_posix() for p in out.rglob("*_hull_*.obj")}
    stray = sorted(there - listed)
    verdict.expect(not stray, f"hull files that the report does not name: {stray[:3]}")
    inner = {
        file
        for robot in report["robots"]
        for link in robot["links"].values()
        for element in elements_of(link)
        for file in element.get("inner_files", [])
    }
    there = {p.relative_to(out).as_posix() for p in out.rglob("inner_hulls/**/*.obj")}
    verdict.expect(there == inner, f"inner hulls on disk and told: {sorted(there ^ inner)[:3]}")
    provenance = json.loads((out / "assetpipe.json").read_text())
    outputs = provenance["outputs"]
    disk = {
        p.relative_to(out).as_posix()
        for p in out.rglob("*")
        if p.is_file() and p.name != "assetpipe.json"
    }
    verdict.expect(
        disk == set(outputs), f"provenance and disk differ: {sorted(disk ^ set(outputs))[:3]}"
    )
    wrong = [
        name
        for name, digest in outputs.items()
        if (out / name).is_file()
        and hashlib.sha256((out / name).read_bytes()).hexdigest() != digest
    ]
    verdict.expect(not wrong, f"SHA-256 differ: {wrong[:3]}")
    for name in ("assetpipe.json", "report.json"):
        text = (out / name).read_text()
        verdict.expect(not TIME_STAMP.search(text), f"{name} holds a time stamp")
        for place in (str(original.resolve().parent), str(out.resolve()), str(Path.home())):
            if place != "/":
                verdict.expect(place not in text, f"{name} holds '{place}'")
        found = [m.group().strip() for m in ABSOLUTE.finditer(text)]
        verdict.expect(not found, f"{name} holds absolute paths: {found[:3]}")


def elements_of(link) -> list[dict]:
    if isinstance(link, list):
        return link
    return link.get("collisions", link.get("elements", []))


LOAD = """
import json, sys, pybullet as p
p.connect(p.DIRECT)
body = p.loadURDF(sys.argv[1], useFixedBase=True)
names = {-1: p.getBodyInfo(body)[0].decode()}
for j in range(p.getNumJoints(body)):
    names[j] = p.getJointInfo(body, j)[12].decode()
print("SHAPES" + json.dumps({n: len(p.getCollisionShapeData(body, k)) for k, n in names.items()}))
"""


def load_in_bullet(urdf: Path, seconds: float = 300) -> dict[str, int] | str:
    """Collision shapes by link, or what went wrong."""
    try:
        done = subprocess.run(
            [sys.executable, "-c", LOAD, str(urdf)],
            capture_output=True,
            timeout=seconds,
            check=False,
            text=True,
            errors="replace",
        )
    except subprocess.TimeoutExpired:
        return "out of time"
    # Bullet may leave its own line unfinished.
    line = next((x for x in done.stdout.splitlines() if "SHAPES{" in x), None)
    if line is None:
        return f"exit {done.returncode}: {(done.stderr or done.stdout).strip()[-200:]}"
    return json.loads(line[line.index("SHAPES{") + 6 :])


def check_bullet(verdict: Verdict, root, urdf: Path, kept: set[str], original: Path) -> None:
    """PyBullet loads it with one shape a collision element."""
    expected: dict[str, int] = {}
    for link, _, _ in collisions(root):
        expected[link] = expected.get(link, 0) + 1
    shapes = load_in_bullet(urdf)
    if isinstance(shapes, str):
        before = load_in_bullet(original)
        if isinstance(before, str):
            verdict.notes.append(f"PyBullet loads neither the original nor the result: {before}")
        else:
            verdict.violations.append(f"PyBullet does not load it: {shapes}")
        return
    for link, count in expected.items():
        got = shapes.get(link, shapes.get(link.rsplit("/")[-1]))
        if got is not None and got != count and link not in kept:
            verdict.violations.append(f"link '{link}': PyBullet has {got} shapes, not {count}")
        if got is None and link in (e.get("name") for e in root.findall("link")):
            verdict.notes.append(f"link '{link}' is told by another name in PyBullet")


def same_tree(a: Path, b: Path) -> list[str]:
    """Files that differ or are on one side only."""
    names = {p.relative_to(r).as_posix() for r in (a, b) for p in r.rglob("*") if p.is_file()}
    return sorted(
        n
        for n in names
        if not ((a / n).is_file() and (b / n).is_file() and filecmp.cmp(a / n, b / n, False))
    )


def check_rebuild(verdict: Verdict, original: Path) -> None:
    """Byte-identical whatever the jobs, hash seed and folder; warm cache 20 times faster."""
    environment = dict(os.environ)
    environment["PYTHONPATH"] = str(Path(__file__).resolve().parents[1])
    with tempfile.TemporaryDirectory() as folder:
        base = Path(folder)
        walls: dict[str, float] = {}
        cpus: dict[str, float] = {}

        def run(name: str, out: str, jobs: int, cache: str) -> None:
            where = base / f"cwd-{jobs}"
            where.mkdir(exist_ok=True)
            environment["PYTHONHASHSEED"] = str(jobs)
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            start = time.monotonic()
            done = subprocess.run(
                [
                    *(sys.executable, "-m", "assetpipe", "build", str(original.resolve())),
                    *("-o", str(base / out), "--jobs", str(jobs)),
                    *("--cache-dir", str(base / cache)),
                ],
                cwd=where,
                env=environment,
                capture_output=True,
                check=False,
                text=True,
            )
            walls[name] = time.monotonic() - start
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            cpus[name] = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
            verdict.expect(
                done.returncode in (0, 1),
                f"rebuild {name}: exit {done.returncode}: {done.stderr[-300:]}",
            )

        run("a", "one", 1, "cache-1")
        run("again", "one", 1, "cache-1")
        run("bcd", "elsewhere/two", 2, "cache-2")
        run("fresh", "three", 1, "cache-3")
        for other in ("elsewhere/two", "three"):
            differing = same_tree(base / "one", base / other)
            verdict.expect(not differing, f"builds differ in {differing[:5]}")
        verdict.facts["wall"] = {k: round(v, 2) for k, v in walls.items()}
        verdict.facts["cpu"] = {k: round(v, 2) for k, v in cpus.items()}
        verdict.expect(
            walls["again"] * 20 <= walls["a"],
            f"second run {walls['again']:.2f} s, first {walls['a']:.2f} s: "
            f"{walls['a'] / walls['again']:.1f} times faster",
        )


def verify(original: Path, out: Path, samples: int) -> Verdict:
    """Everything but the rebuild."""
    verdict = Verdict()
    report = json.loads((out / "report.json").read_text())
    robot = report["robots"][0]
    urdf = out / robot["urdf"]
    old, new = source_of(original), urdf.read_bytes()
    old_root, root = parse(old), parse(new)
    before, after = collisions(old_root), collisions(root)
    by_link: dict[str, list] = {}
    for link, _, element in after:
        by_link.setdefault(link, []).append(element)
    successors, kept = [], set()
    simple: dict[Path, tuple] = {}
    for link, index, element in before:
        told = [e for e in elements_of(robot["links"].get(link, [])) if e["index"] == index]
        if not verdict.expect(
            len(told) == 1, f"link '{link}' collision {index}: not in the report"
        ):
            successors.append(1)
            continue
        files = told[0]["files"]
        count = len(files) or 1
        successors.append(count)
        mine, by_link[link] = by_link.get(link, [])[:count], by_link.get(link, [])[count:]
        if not verdict.expect(len(mine) == count, f"link '{link}' collision {index}: LOST"):
            continue
        if files:
            for child, file in zip(mine, files, strict=True):
                shape = simple_shape(child, element)
                if shape is not None:
                    simple[out / file] = shape
                    continue
                mesh = child.find("geometry/mesh")
                path = None if mesh is None else resolve(mesh.get("filename") or "", urdf, out)
                verdict.expect(
                    path is not None and path.resolve() == (out / file).resolve(),
                    f"link '{link}' collision {index}: refers to {path}, report says {file}",
                )
                verdict.expect(
                    np.allclose(origin(child), origin(element), atol=1e-12, rtol=0),
                    f"link '{link}' collision {index}: other origin",
                )
                verdict.expect(
                    mesh is None
                    or not mesh.get("scale")
                    or set(mesh.get("scale").split()) <= {"1", "1.0"},
                    f"link '{link}' collision {index}: scale left on a baked hull",
                )
        else:
            kept.add(link)
            same = etree.tostring(element, with_tail=False) == etree.tostring(
                mine[0], with_tail=False
            )
            if not same and element.find("geometry/mesh") is not None:
                verdict.notes.append(f"link '{link}' collision {index}: kept, reference rewritten")
            else:
                verdict.expect(same, f"link '{link}' collision {index}: kept but changed")
    extra = {k: len(v) for k, v in by_link.items() if v}
    verdict.expect(not extra, f"collision elements from nowhere: {extra}")
    check_urdf(verdict, old, new, successors)
    check_references(verdict, root, old_root, urdf, original, out)
    hulls_of: dict[int, list[Path]] = {}
    for link in robot["links"].values():
        for element in elements_of(link):
            if element["mesh"] is not None and element["files"]:
                hulls_of.setdefault(element["mesh"], [out / f for f in element["files"]])
    for number, entry in enumerate(robot["meshes"]):
        if number not in hulls_of:
            verdict.notes.append(f"{entry['name']}: {entry['treatment']}")
            continue
        path = resolve(entry["name"], original)
        if not verdict.expect(path is not None, f"{entry['name']}: built, but not found by us"):
            continue
        check_mesh(verdict, entry, path, hulls_of[number], simple, samples)
    check_files(verdict, out, report, original)
    bullet_source = original if original.suffix != ".xacro" else urdf
    check_bullet(verdict, root, urdf, kept, bullet_source)
    verdict.facts["collisions"] = [len(before), len(after)]
    verdict.facts["hulls"] = sum(len(h) for h in hulls_of.values())
    return verdict


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("original", type=Path)
    parser.add_argument("built", type=Path)
    parser.add_argument("--samples", type=int, default=20_000, help="on every mesh")
    parser.add_argument("--rebuild", action="store_true")
    parser.add_argument("--json", action="store_true")
    a = parser.parse_args()
    verdict = verify(a.original.resolve(), a.built.resolve(), a.samples)
    if a.rebuild:
        check_rebuild(verdict, a.original)
    if a.json:
        print(json.dumps(vars(verdict), indent=2, default=str))
    else:
        for mesh in verdict.facts.pop("meshes", []):
            print("  ", json.dumps(mesh))
        print(json.dumps(verdict.facts))
        for note in verdict.notes:
            print("note:", note)
        for violation in verdict.violations:
            print("VIOLATION:", violation)
        print(
            f"{a.original.name}: {'WRONG' if verdict.violations else 'right'}, "
            f"{len(verdict.violations)} violations"
        )
    return 1 if verdict.violations else 0


if __name__ == "__main__":
    sys.exit(main())
