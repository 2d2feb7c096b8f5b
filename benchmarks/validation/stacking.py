"""Stacks and a peg in a slot, light under heavy up to 1:1000, at many time steps.

    python benchmarks/validation/stacking.py [--engines bullet,mujoco]

Beams of an I section are decomposed and stacked three high; a peg stands in the slot of a
block that stands on the floor. The heavy one is on top, the hard case for an iterative
solver. Prints by how far the worst body moved in 5 simulated seconds at every time step, and
with the step and iterations that the planner chooses.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import Any

from assetpipe.validation.effects import plan
from assetpipe.validation.effects.plan import Setting
from assetpipe.validation.runners import SceneOptions
from assetpipe.validation.runners.scene import attempt
from assetpipe.validation.scenes import build_assets, parse_scene

RATIOS = (1, 10, 100, 1000)
RATES = (60, 120, 240, 500, 1000, 2000)
LIGHT = 0.1
FLOOR = {"body": "box", "size": [1, 1, 0.1], "pose": {"xyz": [0, 0, -0.05]}}
BEAM = {
    "body": "extrusion",
    "outline": [[-0.05, -0.05], [0.05, -0.05], [0.05, -0.035], [0.01, -0.035], [0.01, 0.035],
                [0.05, 0.035], [0.05, 0.05], [-0.05, 0.05], [-0.05, 0.035], [-0.01, 0.035],
                [-0.01, -0.035], [-0.05, -0.035]],
    "length": 0.1,
    "tolerance": "0.5mm",
    "base": "free",
    "material": {"friction": 0.6},
}  # fmt: skip
BLOCK = {
    **BEAM,
    "outline": [[-0.06, 0], [0.06, 0], [0.06, 0.08], [0.0205, 0.08], [0.0205, 0.02],
                [-0.0205, 0.02], [-0.0205, 0.08], [-0.06, 0.08]],
}  # fmt: skip


def stack(ratio: float) -> dict[str, Any]:
    """Three beams, the top one ``ratio`` times as heavy as those below."""
    upright = [1.5707963267948966, 0.0, 0.0]
    return {
        "title": f"three beams, the top one {ratio} times as heavy",
        "question": "settle",
        "assets": {
            "floor": FLOOR,
            **{
                f"beam{i}": {
                    **BEAM,
                    "mass": LIGHT * (ratio if i == 2 else 1),
                    "pose": {"xyz": [0, 0, 0.05 + 0.1 * i], "rpy": upright},
                }
                for i in range(3)
            },
        },
        "drive": {"gravity": 9.81},
        "limit": "2mm",
        "seconds": 5,
    }


def peg(ratio: float) -> dict[str, Any]:
    """A peg with 0.5 mm of play on each side in a block, ``ratio`` times as heavy as that."""
    upright = [1.5707963267948966, 0.0, 0.0]
    return {
        "title": f"a peg {ratio} times as heavy as its block",
        "question": "settle",
        "assets": {
            "floor": FLOOR,
            "block": {**BLOCK, "mass": LIGHT, "pose": {"rpy": upright}},
            "peg": {
                "body": "box",
                "size": [0.04, 0.04, 0.1],
                "mass": LIGHT * ratio,
                "base": "free",
                "pose": {"xyz": [0, 0, 0.07]},
                "material": {"friction": 0.6},
            },
        },
        "drive": {"gravity": 9.81},
        "limit": "2mm",
        "seconds": 5,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--engines", default="bullet,mujoco")
    a = parser.parse_args()
    columns = " | ".join(f"1/{rate} s" for rate in RATES)
    print(f"| case | mass ratio | engine | {columns} | planned: step, iterations, moved |")
    print("|---" * (len(RATES) + 4) + "|")
    for case, make in (("stack", stack), ("peg in slot", peg)):
        for ratio in RATIOS:
            scene = parse_scene(make(ratio))
            assets = build_assets(scene)
            for engine in a.engines.split(","):
                own = plan(scene, assets, engine=engine)
                moved = [told(scene, assets, at(own, 1.0 / rate), engine) for rate in RATES]
                planned = (
                    f"1/{1 / own.step.value:.0f} s, {own.iterations.value:.0f}, "
                    f"{told(scene, assets, own, engine)}"
                )
                cells = " | ".join([*moved, planned])
                print(f"| {case} | 1:{ratio} | {engine} | {cells} |", flush=True)


def at(own: Any, step: float) -> Any:
    return replace(own, step=Setting(step, "measured at this step"))


def told(scene: Any, assets: Any, planned: Any, engine: str) -> str:
    found, _, message = attempt(scene, assets, planned, SceneOptions(engine=engine))
    return f"{found.measure * 1e3:.2g} mm" if found and found.measure is not None else message[:40]


if __name__ == "__main__":
    main()
