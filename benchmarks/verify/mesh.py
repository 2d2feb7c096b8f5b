"""One mesh: hulls convex, certificates true, the solid covered."""

from __future__ import annotations

import re
from pathlib import Path

import igl
import numpy as np
from verify.meshes import ROUNDING, hull_defects, load_original, read_hull, shells_of
from verify.sampling import in_volume, inside, on_surface, outside_all, planes_of, touched
from verify.shapes import beyond_shape, on_shape
from verify.verdict import Verdict


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
    points, windings, closed = shells_of(vertices, faces)
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
    squared, *_ = igl.point_mesh_squared_distance(points_all, points, windings[1])
    distance = np.sqrt(np.maximum(np.asarray(squared).ravel(), 0.0))
    allowed = np.array(bounds)[owner_all] + moved
    # Near the surface it does not matter on which side a point lies.
    far = np.flatnonzero(distance > 0.3 * allowed)
    distance[far[inside(points_all[far], points, windings)]] = 0.0
    suspects = np.flatnonzero(distance > allowed + slack)
    closed_up = entry.get("closed")
    if closed_up and len(suspects):
        # Towards the solid without what nothing can enter: only points that a ball touches count.
        radius = float(closed_up["reach"])
        suspects = suspects[touched(points_all[suspects], points, windings, radius)]
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
