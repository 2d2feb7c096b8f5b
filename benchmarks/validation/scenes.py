"""What the effect planner saves: every shipped scene, its own plan against everything on.

    python benchmarks/validation/scenes.py [SCENE…] [--repeat N]

Prints CPU seconds (best of N) of answering, without making the assets, and the ratio.
"""

from __future__ import annotations

import argparse
import statistics

from assetpipe.shipped import CONFIGS
from assetpipe.validation.effects import plan
from assetpipe.validation.runners import SceneOptions
from assetpipe.validation.runners.scene import attempt, same_answer
from assetpipe.validation.scenes import DirectProvider, build_assets, load_scene


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    shipped = sorted(p.stem for p in (CONFIGS / "scenes").glob("*.yaml"))
    parser.add_argument("scenes", nargs="*", default=shipped)
    parser.add_argument("--repeat", type=int, default=3)
    arguments = parser.parse_args()
    provider, options, ratios = DirectProvider(), SceneOptions(), []
    print("| scene | question | method | ms | everything on, ms | ratio | same answer |")
    print("|---|---|---|---|---|---|---|")
    for name in arguments.scenes:
        scene, path = load_scene(name)
        assets = build_assets(scene, path, provider=provider)
        least, full = plan(scene, assets), plan(scene, assets, scope="everything")
        runs = [
            min(
                (attempt(scene, assets, planned, options) for _ in range(arguments.repeat)),
                key=lambda run: run[1],
            )
            for planned in (least, full)
        ]
        (first, cheap, _), (second, dear, message) = runs
        if first is None or second is None:
            print(f"| {name} | {scene.question} | {least.method} | - | - | - | {message} |")
            continue
        ratios.append(dear / cheap)
        same = "yes" if same_answer(scene, least, first, full, second) else "NO"
        print(
            f"| {name} | {scene.question} | {least.method} | {cheap * 1e3:.1f} | "
            f"{dear * 1e3:.1f} | {dear / cheap:.1f} | {same} |"
        )
    print(f"\nmedian ratio {statistics.median(ratios):.1f} over {len(ratios)} scenes")


if __name__ == "__main__":
    main()
