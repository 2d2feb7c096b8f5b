"""How many hulls does navigable space save on real links?

    python benchmarks/reach.py ROBOT.urdf... FOLDER_OF_MESHES... [--tolerance 1%] [--reach 0,2,5]

Every distinct collision mesh is repaired once and decomposed with each reach, told in
tolerances: what a ball of that radius cannot enter from outside counts as solid. A row is a
robot or a folder. "deepest" is how far original surface points lie outside of all hulls:
coverage, which closing must not touch. Single-threaded CPU time, lattice and union included
in the time of a reach.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path

import numpy as np
from cases import meshes

import assetpipe
from assetpipe.decomposition.engine import as_solid
from assetpipe.errors import AssetpipeError
from assetpipe.geometry.files import read_mesh
from assetpipe.geometry.mesh import Mesh
from assetpipe.robot import MeshShape, read_robot


def links(source: Path) -> list[tuple[str, Mesh]]:
    """Distinct meshes, metres, scale applied."""
    if source.suffix != ".urdf":
        return [(path.stem, read_mesh(path).mesh) for path in meshes([source])]
    found: dict[tuple[str, tuple[float, ...]], Mesh] = {}
    for link in read_robot(source).robot.links:
        for collision in link.collisions:
            shape = collision.shape
            if isinstance(shape, MeshShape) and shape.path is not None:
                key = (shape.path.stem, tuple(shape.scale))
                if key not in found:
                    found[key] = read_mesh(shape.path).mesh.scaled(np.asarray(shape.scale))
    return [(name, mesh) for (name, _), mesh in found.items()]


def outside(points: np.ndarray, hulls) -> float:
    """Largest distance of a point beyond the faces of the nearest hull."""
    least = np.full(len(points), np.inf)
    for hull in hulls:
        a, b, c = (hull.vertices[hull.faces[:, k]] for k in range(3))
        normals = np.cross(b - a, c - a)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        heights = points @ normals.T - np.einsum("ij,ij->i", normals, a)
        least = np.minimum(least, heights.max(axis=1))
    return float(least.max())


def measure(name: str, mesh: Mesh, tolerance: str, factors: list[float]) -> dict | None:
    """Hulls, closed volume and time for every reach; nothing for what is no solid."""
    try:
        solid, _ = as_solid(mesh, "fill")
    except AssetpipeError as error:
        print(f"{name}: {error}", file=sys.stderr)
        return None
    epsilon = assetpipe.Tolerance.parse(tolerance).on(solid)
    row: dict = {"mesh": name, "faces": len(solid.faces), "epsilon": epsilon, "reach": {}}
    for factor in factors:
        start = time.process_time()
        found = assetpipe.decompose(solid, epsilon, reach=factor * epsilon, threads=1)
        row["reach"][f"{factor:g}"] = {
            "hulls": len(found.hulls),
            "seconds": time.process_time() - start,
            "pockets": found.closed.pockets if found.closed else 0,
            "volume": found.closed.volume / solid.volume if found.closed else 0.0,
            "upper": found.certificate.upper / epsilon,
            "deepest": outside(solid.vertices, found.hulls),
        }
    return row


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("sources", nargs="+", type=Path)
    parser.add_argument("--tolerance", default="1%")
    parser.add_argument("--reach", default="0,2,5", help="in tolerances")
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    factors = [float(part) for part in options.reach.split(",")]
    told = []
    head = "".join(f" | reach {f:g} ε: hulls, pockets, s" for f in factors)
    print(f"| source | links{head} |")
    print("|---|---|" + "---|" * len(factors))
    for source in options.sources:
        rows = [
            row
            for name, mesh in links(source)
            if (row := measure(name, mesh, options.tolerance, factors)) is not None
        ]
        told.append({"source": source.stem, "meshes": rows})
        cells = []
        for factor in factors:
            own = [row["reach"][f"{factor:g}"] for row in rows]
            total = [sum(item[key] for item in own) for key in ("hulls", "pockets", "seconds")]
            cells.append(f"{total[0]}, {total[1]}, {total[2]:.1f}")
        print(f"| {source.stem} | {len(rows)} | " + " | ".join(cells) + " |", flush=True)
        if options.json:
            options.json.write_text(json.dumps(told, indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
