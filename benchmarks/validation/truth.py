"""Contact truth and self-collision of built robots, with sample sizes and intervals.

    python benchmarks/validation/truth.py [ROBOT…] [--samples 1000] [--poses 1000]

Builds every robot with the default configuration (into ``--built``) and prints what its
``report.json`` says: false and missed contacts among poses near contact with Wilson's 95%
interval, the clearance error over the certificate, pairs of links that touch only before or
only after over seeded joint configurations within limits (mimic joints follow), and of pairs
that touch at home how many there are and how deep surface points of one lie in the other.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path
from typing import Any

import igl
import numpy as np
from variants import robot_files

import assetpipe
from assetpipe.geometry import Mesh
from assetpipe.pipeline.bodies import kept_mesh
from assetpipe.robot import Robot, forward_kinematics, home, read_robot
from assetpipe.validation.contact.probes import surface_samples

CACHE = Path.home() / ".cache" / "assetpipe-benchmarks"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    files = robot_files()
    parser.add_argument("robots", nargs="*", metavar="ROBOT", help=", ".join(files))
    parser.add_argument("--samples", type=int, default=1000, help="poses a mesh")
    parser.add_argument("--poses", type=int, default=1000, help="joint configurations")
    parser.add_argument("--built", type=Path, default=CACHE / "built")
    a = parser.parse_args()
    config = assetpipe.Config(validation={"samples": a.samples, "poses": a.poses})
    print("| robot | meshes | poses | false contacts | missed | undecided | beyond certificate |"
          " error p50 / p95 / worst, of the certificate | configurations × pairs | new | vanished |"
          " at home: pairs, depth in mm, before → after | s |\n" + "|---" * 13 + "|")  # fmt: skip
    every: list[dict[str, Any]] = []
    for name in a.robots or files:
        began = time.perf_counter()
        assetpipe.build(files[name], a.built / name, config=config)
        seconds = time.perf_counter() - began
        (robot,) = json.loads((a.built / name / "report.json").read_text())["robots"]
        told = [m["contact"] for m in robot["meshes"] if "contact" in m]
        every += told
        own = robot["validation"].get("self_collision")
        again = (
            f"{own['configurations']} × {own['pairs']} | {changes(own['new'])} | "
            f"{changes(own['vanished'])} | {at_home(own, files[name], a.built / name)}"
            if own
            else "- | - | - | -"
        )
        print(f"| {name} | {len(told)} | {contact(told)} | {again} | {seconds:.0f} |", flush=True)
    print(f"| all | {len(every)} | {contact(every)} | | | | | |")


def contact(told: list[dict[str, Any]]) -> str:
    """Rates over all meshes of a robot; errors in units of each mesh's certificate."""
    from assetpipe.validation.statistics import Rate

    def rate(key: str) -> str:
        count, of = (sum(t[key][k] for t in told) for k in ("count", "of"))
        found = Rate.wilson(count, of)
        return f"{found.value * 100:.2g}% [{found.low * 100:.2g}, {found.high * 100:.2g}]"

    def error(key: str) -> str:
        shares = [t["clearance_error"][key] / t["allowed"] for t in told if t["allowed"] > 0.0]
        return f"{max(shares, default=0.0):.2f}"

    beyond = sum(t["beyond_certificate"]["count"] for t in told)
    samples = sum(t["samples"] for t in told)
    errors = " / ".join(error(key) for key in ("p50", "p95", "worst"))
    return (
        f"{samples} | {rate('false_contacts')} | {rate('missed_contacts')} | "
        f"{rate('undecided')} | {beyond} | {errors}"
    )


def at_home(own: dict[str, Any], original: Path, built: Path) -> str:
    """Pairs that touch at home and the greatest depth in mm, before → after."""
    told = []
    for path, key in ((original, "home_before"), (next(built.rglob("*.urdf")), "home_after")):
        robot = read_robot(path).robot
        frames = forward_kinematics(robot, home(robot))
        deepest = max(
            (depth(robot, frames, *ends) for a, b in own[key] for ends in ((a, b), (b, a))),
            default=0.0,
        )
        told.append(f"{len(own[key])}" + (f", {deepest * 1e3:.2f}" if own[key] else ""))
    return " → ".join(told)


def depth(robot: Robot, frames: Any, a: str, b: str) -> float:
    """Metres by which surface points of link a lie inside the meshes of link b."""
    deepest = 0.0
    for mesh in placed(robot, frames, a):
        points, _ = surface_samples(mesh.vertices, mesh.faces, 20000, np.random.default_rng(0))
        points = np.vstack([points, mesh.vertices])
        for other in placed(robot, frames, b):
            low, high = other.vertices.min(axis=0), other.vertices.max(axis=0)
            near = points[((points > low) & (points < high)).all(axis=1)]
            if not len(near):
                continue
            inside = np.asarray(igl.fast_winding_number(other.vertices, other.faces, near)) > 0.5
            if inside.any():
                squared = igl.point_mesh_squared_distance(
                    np.ascontiguousarray(near[inside]), other.vertices, other.faces
                )[0]
                deepest = max(deepest, float(np.sqrt(squared.max())))
    return deepest


def placed(robot: Robot, frames: Any, link: str) -> list[Mesh]:
    shapes = [(kept_mesh(c.shape), c.link_from_shape) for c in robot.link(link).collisions]
    return [mesh.transformed(frames[link] @ at) for mesh, at in shapes if mesh is not None]


def changes(pairs: list[dict[str, Any]]) -> str:
    """How many pairs changed, in how many configurations at most, and the largest gap."""
    if not pairs:
        return "0"
    gap = max(p["gap"] for p in pairs)
    most = max(p["configurations"] for p in pairs)
    return f"{len(pairs)} (in up to {most}; gap {gap * 1e3:.2g} mm)"


if __name__ == "__main__":
    main()
