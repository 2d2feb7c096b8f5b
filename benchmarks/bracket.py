"""Two-sided answers: how many queries stay undecided, what one costs, and whether a proof is wrong.

    python benchmarks/bracket.py [--epsilon 0.01 0.005 …] [--probes 600] [PATH…]

Probes are balls and boxes, half widths uniform in 0.5 % to 5 % of the diagonal, boxes turned at
random, spread uniformly through 1.5 times the bounding box. Brute force for balls: the distance of
the centre to the surface and its winding number (libigl), nothing of ours; for boxes: FCL on the
mesh, and winding numbers. PATHs: mesh files, or URDF files whose collision meshes are taken, after
repair; without any, all meshes of the benchmark data.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from cases import data_folders, meshes

import assetpipe
from assetpipe.errors import AssetpipeError
from assetpipe.geometry import Mesh, RepairPolicy, repair
from assetpipe.validation.contact.surface import Frame, Surface

EDGE = 1e-6
"""Balls whose distance to the surface differs by less than this share of the diagonal from
their radius are not judged: there the brute force itself is rounding."""


def solids(paths: list[Path]) -> Iterator[tuple[str, str, Mesh]]:
    """Set, name and repaired solid of every mesh and of every robot's collision mesh."""
    from assetpipe.geometry import read_mesh

    for path in meshes(paths):
        if path.suffix.lower() not in {".urdf", ".xacro"}:
            if path.suffix.lower() in {".off", ".stl", ".obj", ".ply", ".dae"}:
                yield from _repaired(path.parent.name, path.stem, read_mesh(path).mesh)
            continue
        from assetpipe.robot import MeshShape, read_robot

        robot, seen = read_robot(path).robot, set()
        for link in robot.links:
            for element in link.collisions:
                shape = element.shape
                if not isinstance(shape, MeshShape) or shape.path is None or shape.path in seen:
                    continue
                seen.add(shape.path)
                try:
                    mesh = read_mesh(shape.path).mesh.scaled(np.asarray(shape.scale))
                except AssetpipeError as error:
                    print(f"# {shape.path.name}: {error}")
                    continue
                yield from _repaired(robot.name, shape.path.stem, mesh)


def _repaired(group: str, name: str, mesh: Mesh) -> Iterator[tuple[str, str, Mesh]]:
    solid = repair(mesh, policy=RepairPolicy()).solid
    if solid is None:
        print(f"# {name}: no solid")
    else:
        yield group, name, solid


def probes(solid: Mesh, count: int, rng: np.random.Generator):
    """Brackets of probes with their poses and, for balls, radius."""
    low, high = solid.vertices.min(axis=0), solid.vertices.max(axis=0)
    centre, half = (low + high) / 2, 0.75 * (high - low)
    made = []
    for k in range(count):
        size = solid.diagonal * rng.uniform(0.005, 0.05)
        pose = np.eye(4)
        pose[:3, 3] = centre + half * rng.uniform(-1, 1, 3)
        if k % 2:
            pose[:3, :3] = np.linalg.qr(rng.normal(size=(3, 3)))[0]
            pose[:3, 2] *= np.sign(np.linalg.det(pose[:3, :3]))
            corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
            made.append((assetpipe.Bracket.convex(size * corners), pose, None))
        else:
            made.append((assetpipe.Bracket.ball(size), pose, size))
    return made


def truth(solid: Mesh, bracket: assetpipe.Bracket, asked) -> list[bool | None]:
    """By brute force; ``None`` within rounding."""
    surface = Surface(solid.vertices, solid.faces, Frame.around(solid.vertices))
    at = np.array([pose[:3, 3] for _, pose, _ in asked])
    inside, away = surface.winding(at) > 0.5, surface.distances(at)
    known: list[bool | None] = []
    for (probe, pose, radius), within, distance in zip(asked, inside, away, strict=True):
        if radius is None:
            known.append(bool(within) or bracket.meshes_touch(probe, pose))
        elif abs(distance - radius) < EDGE * solid.diagonal and not within:
            known.append(None)
        else:
            known.append(bool(within or distance < radius))
    return known


def timed(function, asked) -> tuple[list, float]:
    """Answers and microseconds of processor time a query, after one unmeasured round."""
    for probe, pose, _ in asked:
        function(probe, pose)
    start = time.process_time()
    answers = [function(probe, pose) for probe, pose, _ in asked]
    return answers, 1e6 * (time.process_time() - start) / len(asked)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("paths", nargs="*", type=Path)
    parser.add_argument("--epsilon", nargs="+", type=float, default=[0.01])
    parser.add_argument("--probes", type=int, default=600)
    given = parser.parse_args()
    rows: dict[tuple[str, float], list[list[float]]] = {}
    for group, name, solid in solids(given.paths or data_folders()):
        rng = np.random.default_rng(0)
        asked = probes(solid, given.probes, rng)
        for epsilon in given.epsilon:
            try:
                d = assetpipe.decompose(solid, assetpipe.Tolerance.relative(epsilon), threads=1)
            except AssetpipeError as error:
                print(f"# {name}: {error}")
                continue
            start = time.process_time()
            inner = d.inner
            seconds = time.process_time() - start
            bracket = assetpipe.Bracket(d)
            answers, cost = timed(bracket.answer, asked)
            _, whole = timed(bracket.collides, asked)
            _, raw = timed(bracket.meshes_touch, asked)
            known = truth(solid, bracket, asked)
            wrong = sum(
                (a == "free" and k is True) or (a == "collision" and k is False)
                for a, k in zip(answers, known, strict=True)
            )
            undecided = answers.count("undecided") / len(answers)
            hit = sum(k is True for k in known) / len(known)
            print(
                f"{group:10s} {name:24s} eps {epsilon:.4f} faces {len(solid.faces):6d} "
                f"hulls {len(d.hulls):4d} inner {len(inner):4d} in {seconds:5.2f} s  "
                f"hit {hit:.3f} undecided {undecided:.3f}  µs hulls {cost:6.1f} "
                f"two-sided {whole:6.1f} mesh {raw:6.1f}  wrong {wrong}",
                flush=True,
            )
            rows.setdefault((group, epsilon), []).append(
                [undecided, cost, whole, raw, wrong, len(inner), seconds]
            )
    for (group, epsilon), found in rows.items():
        table = np.array(found)
        u, c, w, r, _, n, s = np.median(table, axis=0)
        print(
            f"median {group} eps {epsilon}: {len(found)} solids, undecided {u:.3f} "
            f"(worst {table[:, 0].max():.3f}), µs hulls {c:.1f} two-sided {w:.1f} mesh {r:.1f}, "
            f"inner {n:.0f} in {s:.2f} s, wrong {int(table[:, 4].sum())}"
        )


if __name__ == "__main__":
    main()
