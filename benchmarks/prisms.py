"""Extruded outlines: hulls and time when they are decomposed in the plane as well.

    python benchmarks/prisms.py [--tolerance 0.01 …] [PATH…]

Made in code: plates, brackets, combs, gears, each also turned arbitrarily. PATHs are mesh or URDF
files: of their solids those that are extruded outlines show a difference.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from bracket import solids
from manifold3d import CrossSection

import assetpipe
from assetpipe.decomposition import Params
from assetpipe.geometry import Mesh

SIDES = 64


def rectangle(low, high) -> CrossSection:
    size = [b - a for a, b in zip(low, high, strict=True)]
    return CrossSection.square(size).translate(list(low))


def plate(holes: int) -> CrossSection:
    rng = np.random.default_rng(holes)
    shape = rectangle((0, 0), (3, 2))
    for _ in range(holes):
        at = rng.uniform((0.3, 0.3), (2.7, 1.7))
        shape -= CrossSection.circle(float(rng.uniform(0.1, 0.25)), SIDES).translate(list(at))
    return shape


def bracket(arms: int) -> CrossSection:
    shape = CrossSection.circle(0.3, SIDES)
    for k in range(arms):
        arm = rectangle((0, -0.12), (1 + 0.2 * k, 0.12))
        shape += arm.rotate(360.0 * k / arms + 7.0 * k)
    return shape - CrossSection.circle(0.15, SIDES)


def comb(teeth: int) -> CrossSection:
    shape = rectangle((0, -0.3), (teeth, 0))
    for k in range(teeth):
        shape += CrossSection([[(k, 0), (k + 0.6, 0), (k + 0.7, 1.5), (k + 0.3, 1.5)]])
    return shape


def gear(teeth: int) -> CrossSection:
    tooth = 2 * np.pi / teeth
    ring = []
    for k in range(teeth):
        for share, radius in ((0.0, 0.85), (0.3, 0.85), (0.42, 1.0), (0.68, 1.0), (0.8, 0.85)):
            angle = (k + share) * tooth
            ring.append((radius * np.cos(angle), radius * np.sin(angle)))
    return CrossSection([ring]) - CrossSection.circle(0.3, SIDES)


def ess() -> CrossSection:
    return rectangle((0, 0), (3, 0.4)) + CrossSection([[(2.6, 0), (3, 0), (1.4, 2), (1, 2)]])


OUTLINES = {
    "plate, 3 holes": lambda: plate(3),
    "plate, 8 holes": lambda: plate(8),
    "bracket, 3 arms": lambda: bracket(3),
    "bracket, 5 arms": lambda: bracket(5),
    "comb, 6 teeth": lambda: comb(6),
    "comb, 15 teeth": lambda: comb(15),
    "gear, 12 teeth": lambda: gear(12),
    "gear, 30 teeth": lambda: gear(30),
    "two bars": ess,
}


def made() -> Iterator[tuple[str, str, Mesh]]:
    for name, outline in OUTLINES.items():
        straight = outline().extrude(0.4)
        for group, body in (
            ("made", straight),
            ("made, turned", straight.rotate([31.0, 47.0, 11.0])),
        ):
            mesh = body.to_mesh64()
            yield group, name, Mesh(mesh.vert_properties[:, :3], mesh.tri_verts.astype(np.int64))


def measured(solid: Mesh, tolerance: float, prisms: str):
    start = time.process_time()
    d = assetpipe.decompose(
        solid,
        assetpipe.Tolerance.relative(tolerance),
        threads=1,
        params=Params({"prisms": prisms}),
    )
    return len(d.hulls), d.certificate.upper / d.epsilon, time.process_time() - start


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("paths", nargs="*", type=Path)
    parser.add_argument("--tolerance", nargs="+", type=float, default=[0.01])
    given = parser.parse_args()
    for group, name, solid in solids(given.paths) if given.paths else made():
        for tolerance in given.tolerance:
            search, plane = (measured(solid, tolerance, prisms) for prisms in ("search", "plane"))
            mark = "*" if plane[0] < search[0] else ""
            print(
                f"{group:14s} {name:20s} {tolerance:.3f} hulls {search[0]:4d} -> {plane[0]:4d} "
                f"bound {plane[1]:.2f} eps  CPU s {search[2]:6.2f} -> {plane[2]:6.2f} {mark}",
                flush=True,
            )


if __name__ == "__main__":
    main()
