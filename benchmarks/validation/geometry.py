"""What collision geometry costs where it is used: original, ours, CoACD's and V-HACD's.

    python benchmarks/validation/geometry.py [ROBOT[:MESHES]…] [--threshold 0.05] [--limit 40]

Question: does our geometry make queries and physics steps slower or faster than that of
other engines at the same tolerance? For who chooses a decomposition by what it costs at run
time. Prints a row a robot and variant. Queries: one sphere (2% of the diagonal) against the
whole robot at home, places even in its bounding box grown by half (FCL; the original as
triangle meshes, hulls as convex shapes behind a broad phase). Steps: PyBullet, 1/240 s, the
robot on its base with self-collision under 27 falling balls; the original as PyBullet takes
it, one hull an STL or OBJ object. CPU time on one core: compare within one run only.
``kuka_iiwa:3`` takes the first three meshes only: CoACD needs a minute each. V-HACD knows no
tolerance: its defaults are used (at most 64 hulls a mesh).
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import numpy as np
from variants import robot_files, variants

from assetpipe.validation.cost import query_microseconds, step_microseconds


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    files = robot_files()
    parser.add_argument("robots", nargs="*", metavar="ROBOT", help=", ".join(files))
    parser.add_argument("--threshold", type=float, default=0.05, help="CoACD's unit")
    parser.add_argument("--limit", type=float, default=40.0, help="CPU seconds a mesh and engine")
    parser.add_argument("--rounds", type=int, default=3, help="the best of so many is told")
    parser.add_argument(
        "--cache", type=Path, default=Path.home() / ".cache" / "assetpipe-benchmarks"
    )
    a = parser.parse_args()
    print("| robot | geometry | hulls | vertices | error / tolerance | queries/s |"
          " step, µs |\n|---|---|---|---|---|---|---|")  # fmt: skip
    ratios: dict[str, list[tuple[float, float]]] = {}
    for asked in a.robots or files:
        name, _, most = asked.partition(":")
        with tempfile.TemporaryDirectory() as folder:
            found, left = variants(
                files[name],
                Path(folder),
                a.cache,
                threshold=a.threshold,
                limit=a.limit,
                most=int(most or 1000),
            )
            costs: dict[str, tuple[float, float]] = {}
            for kind, v in found.items():
                convex = kind != "original"
                rounds = range(a.rounds)
                query = min(query_microseconds(v.placed, convex=convex) for _ in rounds)
                steps = [step_microseconds(v.urdf, steps=480) for _ in rounds]
                step = min((s for s in steps if s is not None), default=float("nan"))
                costs[kind] = query, step
                error = f"{v.certificate:.2f}" if np.isfinite(v.certificate) and convex else "-"
                print(f"| {name} | {kind} | {v.hulls} | {v.vertices} | {error} | "
                      f"{1e6 / query:,.0f} | {step:.0f} |", flush=True)  # fmt: skip
            ours = costs["assetpipe"]
            for kind, (query, step) in costs.items():
                ratios.setdefault(kind, []).append((query / ours[0], step / ours[1]))
            if left:
                print(f"| {name} | left out of all: {', '.join(left)} | | | | | |", flush=True)
    print("\nCost relative to our hulls (above 1: ours are faster), geometric mean and worst:")
    for kind, pairs in ratios.items():
        both = np.array(pairs)
        mean, worst = np.exp(np.nanmean(np.log(both), axis=0)), np.nanmin(both, axis=0)
        print(f"  {kind}: query {mean[0]:.2f} (worst {worst[0]:.2f}), "
              f"step {mean[1]:.2f} (worst {worst[1]:.2f})")  # fmt: skip


if __name__ == "__main__":
    main()
