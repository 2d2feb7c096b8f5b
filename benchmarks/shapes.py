"""Shapes whose fewest hulls are known by construction, to see how far from them the engine ends.

    python benchmarks/shapes.py [--effort balanced] [--rotated]

The longest side is about 2, the tolerance 0.05 in CoACD's unit, so 0.05 of half that side.
Optimum: the fewest convex pieces with thickening within the tolerance.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass

import numpy as np
from manifold3d import CrossSection, Manifold

ROUND = 128


@dataclass(frozen=True)
class Shape:
    """A named solid and the fewest hulls it needs."""

    name: str
    optimum: int
    solid: Manifold


def box(lower, upper) -> Manifold:
    return Manifold.cube([b - a for a, b in zip(lower, upper, strict=True)]).translate(list(lower))


def rod(radius: float, length: float) -> Manifold:
    return Manifold.cylinder(length, radius, radius, ROUND)


def open_box() -> Manifold:
    return box((-1, -0.8, 0), (1, 0.8, 1)) - box((-0.92, -0.72, 0.08), (0.92, 0.72, 2))


def plate_with_walls() -> Manifold:
    plate = box((-1, -0.7, 0), (1, 0.7, 0.1))
    return plate + box((-1, -0.7, 0), (-0.9, 0.7, 0.8)) + box((0.2, -0.7, 0), (0.3, 0.7, 0.5))


def plate_with_screw_holes() -> Manifold:
    plate = box((-1, -0.7, 0), (1, 0.7, 0.15))
    for x in (-0.8, 0.8):
        for y in (-0.5, 0.5):
            plate -= rod(0.045, 1.0).translate([x, y, -0.2])
    return plate


def ring(inner: float, length: float = 0.5) -> Manifold:
    return rod(1.0, length) - rod(inner, 3.0).translate([0, 0, -1])


def body_with_hole() -> Manifold:
    return box((-0.5, -0.5, -1), (0.5, 0.5, 1)) - box((-0.25, -0.25, -2), (0.25, 0.25, 2))


def body_with_blind_hole() -> Manifold:
    return box((-0.5, -0.5, -1), (0.5, 0.5, 1)) - box((-0.25, -0.25, -0.8), (0.25, 0.25, 2))


def lattice_bracket() -> Manifold:
    plate = box((-1, -0.5, 0), (1, 0.5, 0.12))
    for k in range(3):
        plate -= box((-0.8 + k * 0.6, -0.35, -1), (-0.4 + k * 0.6, 0.35, 1))
    for x in (-0.92, 0.92):
        plate -= rod(0.03, 1.0).translate([x, 0.42, -0.3])
    return plate


def comb(teeth: int = 6) -> Manifold:
    spine = box((-1, -0.2, 0), (1, 0, 0.2))
    step = 2.0 / (teeth - 0.5)
    for k in range(teeth):
        spine += box((-1 + k * step, -0.2, 0), (-1 + k * step + step / 2, 0.8, 0.2))
    return spine


def channel() -> Manifold:
    return box((-1, -0.3, 0), (1, 0.3, 0.5)) - box((-2, -0.22, 0.08), (2, 0.22, 1))


def clevis() -> Manifold:
    return box((-0.4, -0.5, 0), (0.4, 0.5, 1.6)) - box((-1, -0.35, 0.3), (1, 0.35, 3))


def stairs(steps: int = 5) -> Manifold:
    body = Manifold()
    for k in range(steps):
        body += box((-1 + 0.4 * k, -0.4, 0), (-0.6 + 0.4 * k, 0.4, 0.3 * (k + 1)))
    return body


def cross() -> Manifold:
    return box((-1, -0.12, -0.12), (1, 0.12, 0.12)) + box((-0.12, -1, -0.12), (0.12, 1, 0.12))


def table() -> Manifold:
    top = box((-1, -0.7, 0.9), (1, 0.7, 1))
    for x in (-0.95, 0.8):
        for y in (-0.65, 0.5):
            top += box((x, y, 0), (x + 0.15, y + 0.15, 0.9))
    return top


def tripod() -> Manifold:
    plate = rod(1.0, 0.1)
    for k in range(3):
        wall = box((0.1, -0.06, 0.1), (0.95, 0.06, 0.9)).rotate([0, 0, 90 + 120 * k])
        plate += wall
    return plate


def turned_rib() -> Manifold:
    rib = box((-0.8, -0.06, 0.0), (0.8, 0.06, 0.7)).rotate([0, 0, 31])
    return box((-1, -0.7, 0), (1, 0.7, 0.1)) + rib


def bracket_with_gusset() -> Manifold:
    angle = box((-1, -0.5, 0), (1, 0.5, 0.1)) + box((-1, -0.5, 0), (-0.9, 0.5, 1.2))
    gusset = Manifold.extrude(CrossSection([[(0, 0), (1, 0), (0, 0.9)]]), 0.1)
    return angle + gusset.rotate([90, 0, 0]).translate([-0.9, 0.05, 0.1])


def leaning_peg() -> Manifold:
    peg = rod(0.15, 1.4).translate([0, 0, -0.2]).rotate([0, 35, 20]).translate([-0.4, 0, 0.1])
    plate = box((-1, -0.7, 0), (1, 0.7, 0.25))
    return plate + (peg ^ box((-2, -2, 0), (2, 2, 2)))


def three_arms() -> Manifold:
    body = Manifold()
    for k, height in enumerate((0.3, 0.5, 0.8)):
        arm = box((-0.1155, -0.2, 0), (1, 0.2, height)).rotate([0, 0, 10 + 120 * k])
        body += arm
    return body


def slanted_arms() -> Manifold:
    post = box((-0.15, -0.3, 0), (0.15, 0.3, 1.6))
    for side, angle in ((1, 35), (-1, 50)):
        arm = box((0, -0.3, -0.12), (0.9, 0.3, 0.12)).rotate([0, -side * angle, 0])
        post += arm.mirror([0 if side > 0 else 1, 0, 0]).translate([0, 0, 0.6 + 0.2 * side])
    return post + box((-0.4, -0.4, -0.15), (0.4, 0.4, 0))


def shapes() -> list[Shape]:
    """All shapes, each with its optimum."""
    return [
        Shape("open box", 5, open_box()),
        Shape("plate with two walls", 3, plate_with_walls()),
        Shape("plate with screw holes", 1, plate_with_screw_holes()),
        Shape("ring 0.95", 10, ring(0.95)),
        Shape("ring 0.80", 9, ring(0.80)),
        Shape("ring 0.50", 7, ring(0.50)),
        Shape("long tube 0.80", 9, ring(0.80, length=2.0)),
        Shape("body with a through hole", 4, body_with_hole()),
        Shape("body with a blind hole", 5, body_with_blind_hole()),
        Shape("lattice bracket", 6, lattice_bracket()),
        Shape("comb of six", 7, comb()),
        Shape("channel", 3, channel()),
        Shape("clevis", 3, clevis()),
        Shape("stairs of five", 5, stairs()),
        Shape("cross", 3, cross()),
        Shape("table", 5, table()),
        Shape("plate with a turned rib", 2, turned_rib()),
        Shape("plate with three turned walls", 4, tripod()),
        Shape("bracket with gusset", 3, bracket_with_gusset()),
        Shape("plate with a leaning peg", 2, leaning_peg()),
        Shape("three arms of three heights", 3, three_arms()),
        Shape("post with slanted arms", 4, slanted_arms()),
    ]


def arrays(solid: Manifold) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and faces in double precision."""
    mesh = solid.to_mesh64()
    return np.asarray(mesh.vert_properties)[:, :3].copy(), np.asarray(mesh.tri_verts).astype(int)


def main() -> None:
    import assetpipe

    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--effort", default="balanced")
    parser.add_argument("--rotated", action="store_true", help="turn every shape arbitrarily")
    a = parser.parse_args()
    print("| shape | optimum | hulls | ratio | certified / tolerance | CPU s |")
    print("|---|---|---|---|---|---|")
    for shape in shapes():
        vertices, faces = arrays(shape.solid)
        tolerance = 0.05 * 0.5 * float((vertices.max(axis=0) - vertices.min(axis=0)).max())
        if a.rotated:
            q, _ = np.linalg.qr(np.random.default_rng(7).normal(size=(3, 3)))
            vertices = vertices @ (q * np.sign(np.linalg.det(q))).T
        start = time.process_time()
        d = assetpipe.decompose((vertices, faces), tolerance=tolerance, effort=a.effort, threads=1)
        spent = time.process_time() - start
        print(
            f"| {shape.name} | {shape.optimum} | {len(d.hulls)} | "
            f"{len(d.hulls) / shape.optimum:.2f} | {d.certificate.upper / tolerance:.3f} | "
            f"{spent:.3f} |"
        )


if __name__ == "__main__":
    main()
