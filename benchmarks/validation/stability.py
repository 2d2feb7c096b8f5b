"""Do built robots stay still in a simulator, and what does accuracy in time cost?

    python benchmarks/validation/stability.py [ROBOT…] [--engines bullet,mujoco] [--plot FILE]

Every robot, as it came and as built, is held for 5 simulated seconds: on a fixed base with
every joint 0.3 rad from home, so that gravity pulls, and at home free on a floor; at time
steps from 1/60 to 1/2000 s (see ``assetpipe.validation.dynamics.settle``). Pairs of links that
are adjacent, or that touch in the original as posed, are left out, as an SRDF does. Prints a row
a robot, base, engine and geometry (worst over the steps), then the table of drift and energy
against the time step. Robots are built once into ``--built`` with the default configuration.
"""

from __future__ import annotations

import argparse
import json
import math
import statistics
from dataclasses import asdict
from pathlib import Path
from typing import Any

from variants import robot_files

import assetpipe
from assetpipe.robot import Robot, forward_kinematics, home, read_robot
from assetpipe.validation import LinkBody, adjacent_pairs, self_collisions
from assetpipe.validation.dynamics.settle import Settling, settle_in_engine

STEPS = (60, 120, 240, 500, 1000, 2000)
FEW = (60, 240, 1000)
"""Steps at which the originals run, for comparison."""
BEND = 0.3
CACHE = Path.home() / ".cache" / "assetpipe-benchmarks"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    files = robot_files()
    parser.add_argument("robots", nargs="*", metavar="ROBOT", help=", ".join(files))
    parser.add_argument("--engines", default="bullet,mujoco")
    parser.add_argument("--seconds", type=float, default=5.0)
    parser.add_argument("--built", type=Path, default=CACHE / "built")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--plot", type=Path)
    a = parser.parse_args()
    rows: list[dict[str, Any]] = []
    print("| robot | base | engine | geometry | runs that ended | energy gain, % | speed, mm/s |"
          " drift, mm/s | sag, mrad |\n|---|---|---|---|---|---|---|---|---|")  # fmt: skip
    for name in a.robots or files:
        original, built = files[name], package(files[name], a.built / name)
        first = read_robot(original).robot
        for base in ("fixed", "free"):
            pose = posed(first, base)
            excluded = left_out(first, pose)
            for engine in a.engines.split(","):
                for label, path in (("original", original), ("built", built)):
                    runs = [
                        settle(path, base, 1.0 / rate, engine, excluded, pose, a.seconds)
                        for rate in (STEPS if label == "built" else FEW)
                    ]
                    rows += [row(name, label, run) for run in runs]
                    tell(name, base, engine, label, runs)
    if a.json:
        a.json.write_text(json.dumps(rows), encoding="utf-8")
    against_time(rows, a.engines.split(","))
    if a.plot:
        plot(rows, a.engines.split(","), a.plot)


def row(name: str, label: str, run: Settling) -> dict[str, Any]:
    return {"robot": name, "geometry": label, **asdict(run)}


def package(original: Path, folder: Path) -> Path:
    """The robot built with the default configuration, once."""
    found = sorted(folder.rglob("*.urdf")) if folder.is_dir() else []
    if not found:
        config = assetpipe.Config(validation={"checks": ()})
        assetpipe.build(original, folder, config=config)
        found = sorted(folder.rglob("*.urdf"))
    return found[0]


def posed(robot: Robot, base: str) -> dict[str, float]:
    """Positions of joints: home, or bent within limits so that gravity pulls at them."""
    at = dict(home(robot))
    if base == "free":
        return at
    for joint in robot.joints:
        if joint.type == "continuous" and joint.mimic is None:
            at[joint.name] += BEND
        if joint.type == "revolute" and joint.mimic is None and joint.limit is not None:
            lower, upper = joint.limit.lower or 0.0, joint.limit.upper or 0.0
            way = BEND if upper - at[joint.name] >= at[joint.name] - lower else -BEND
            at[joint.name] = min(max(at[joint.name] + way, lower), max(lower, upper))
    return at


def left_out(robot: Robot, pose: dict[str, float]) -> list[tuple[str, str]]:
    """Pairs of links that nobody asks: adjacent ones, and those that touch as they come."""
    from assetpipe.pipeline.bodies import kept_mesh

    adjacent = adjacent_pairs((j.parent, j.child, j.type) for j in robot.joints)
    bodies = []
    for link in robot.links:
        shapes = [(kept_mesh(c.shape), c.link_from_shape) for c in link.collisions]
        placed = tuple(mesh.transformed(at) for mesh, at in shapes if mesh is not None)
        bodies.append(LinkBody(link.name, placed))
    frames = [forward_kinematics(robot, pose)]
    found = self_collisions(bodies, bodies, frames, excluded=adjacent)
    return [*adjacent, *found.home_before]


def settle(
    path: Path,
    base: str,
    step: float,
    engine: str,
    excluded: list[tuple[str, str]],
    pose: dict[str, float],
    seconds: float,
) -> Settling:
    robot = read_robot(path).robot
    resolved = {r.uri: r.resolution.path for r in robot.references if r.resolution.path is not None}
    return settle_in_engine(
        path,
        base=base,
        step=step,
        seconds=seconds,
        home=pose,
        excluded=excluded,
        resolved=resolved,
        engine=engine,
    )


def tell(name: str, base: str, engine: str, label: str, runs: list[Settling]) -> None:
    ended = [run for run in runs if run.outcome == "settled"]
    others = sorted({f"{run.outcome}: {run.message[:60]}" for run in runs if run not in ended})
    worst = {
        key: max((getattr(run, key) for run in ended), default=math.nan)
        for key in ("energy_gain", "residual_speed", "drift", "sag")
    }
    print(
        f"| {name} | {base} | {engine} | {label} | {len(ended)} of {len(runs)} "
        f"{'; '.join(others)}| {worst['energy_gain'] * 100:.2g} | "
        f"{worst['residual_speed'] * 1e3:.2g} | {worst['drift'] * 1e3:.2g} | "
        f"{worst['sag'] * 1e3:.2g} |",
        flush=True,
    )


def against_time(rows: list[dict[str, Any]], engines: list[str]) -> None:
    print("\n| step | engine | energy gain, %: median / worst | drift, mm/s: median / worst |"
          " sag, mrad: median / worst | CPU ms a simulated second |")  # fmt: skip
    print("|---|---|---|---|---|---|")
    for rate in STEPS:
        for engine in engines:
            told = _of(rows, engine, rate)
            if not told:
                continue
            cells = [
                f"{statistics.median(v) * s:.2g} / {max(v) * s:.2g}"
                for key, s in (("energy_gain", 100.0), ("drift", 1e3), ("sag", 1e3))
                for v in [[r[key] for r in told]]
            ]
            cpu = statistics.median(r["cpu_seconds"] / r["seconds"] for r in told)
            print(f"| 1/{rate} s | {engine} | {' | '.join(cells)} | {cpu * 1e3:.2g} |")


def _of(rows: list[dict[str, Any]], engine: str, rate: int) -> list[dict[str, Any]]:
    return [
        r
        for r in rows
        if r["geometry"] == "built"
        and r["engine"] == engine
        and r["outcome"] == "settled"
        and round(1.0 / r["step"]) == rate
    ]


def plot(rows: list[dict[str, Any]], engines: list[str], file: Path) -> None:
    """The worst over robots and bases against the CPU time that the step costs."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot as plt

    panels = (
        ("sag", 1e3, "worst sag of a joint, mrad", 1e-3),
        ("energy_gain", 100.0, "worst energy gain, % of m·g·size", 1e-2),
        ("drift", 1e3, "worst drift, mm/s", 1e-3),
    )
    figure, axes = plt.subplots(1, 3, figsize=(11, 3.3), constrained_layout=True)
    for axis, (key, scale, label, least) in zip(axes, panels, strict=True):
        for engine in engines:
            points = [(rate, _of(rows, engine, rate)) for rate in STEPS]
            points = [(rate, told) for rate, told in points if told]
            cost = [
                1e3 * statistics.median(r["cpu_seconds"] / r["seconds"] for r in told)
                for _, told in points
            ]
            heights = [max(least, max(r[key] for r in told) * scale) for _, told in points]
            axis.loglog(cost, heights, "o-", label=engine)
            for (rate, _), x, y in zip(points, cost, heights, strict=True):
                axis.annotate(f"1/{rate}", (x, y), fontsize=6, xytext=(2, 3),
                              textcoords="offset points")  # fmt: skip
        axis.set_ylim(bottom=0.7 * least)
        axis.set_title(f"{label}\n(least shown {least:g})", fontsize=9)
        axis.set_xlabel("CPU ms for a simulated second")
        axis.grid(visible=True, alpha=0.3)
    axes[0].legend(frameon=False)
    figure.savefig(file, dpi=110)


if __name__ == "__main__":
    main()
