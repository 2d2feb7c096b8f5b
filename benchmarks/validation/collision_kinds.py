"""Which collision geometry answers the shipped scenes right, at the same tolerance.

    python benchmarks/validation/collision_kinds.py [SCENE…] [--kinds built,coacd,vhacd,hull]

Every asset whose shape is not convex is given in turn our hulls, CoACD's, V-HACD's and one
hull, at the scene's own tolerance (CoACD's threshold is that length in its unit; its least is
0.01). Prints the answer, the measure, how many hulls the scene holds, and whether the answer
is the expected one. Some scenes ship with a single hull on purpose; they are left out.
"""

from __future__ import annotations

import argparse
import time

from assetpipe.errors import AssetpipeError
from assetpipe.validation.runners import answer_scene
from assetpipe.validation.scenes import DirectProvider, build_assets, load_scene

SCENES = (
    "drawer_opens_by_handle",
    "drawer_clearance",
    "finger_enters_handle",
    "bread_enters_toaster",
    "peg_in_slot",
    "box_slides_over_seams",
)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", nargs="*", metavar="SCENE", default=SCENES)
    parser.add_argument("--kinds", default="built,coacd,vhacd,hull")
    a = parser.parse_args()
    provider = DirectProvider(effort="balanced")
    print("| scene | collision | hulls | answer | measure | as expected | to make, CPU s |")
    print("|---|---|---|---|---|---|---|")
    for name in a.scenes:
        scene, path = load_scene(name)
        for kind in a.kinds.split(","):
            assets = {
                key: spec
                if spec.body in ("box", "sphere", "cylinder", "capsule")
                else spec.model_copy(update={"collision": kind})
                for key, spec in scene.assets.items()
            }
            changed = scene.model_copy(update={"assets": assets})
            began = time.process_time()
            try:
                made = build_assets(changed, path, provider=provider)
                spent = time.process_time() - began
                found = answer_scene(changed, made, name=name)
            except AssetpipeError as error:
                print(f"| {name} | {kind} | - | {error.message[:80]} | - | - | - |", flush=True)
                continue
            hulls = sum(len(link.shapes) for asset in made.values() for link in asset.links)
            answer = {True: "yes", False: "no", None: "-"}[found.answer]
            measured = found.measured
            measure = "-"
            if measured is not None and measured.measure is not None:
                measure = f"{measured.measure:.4g} {measured.unit}"
            print(f"| {name} | {kind} | {hulls} | {answer} | {measure} | "
                  f"{'yes' if found.expected else 'NO'} | {spent:.1f} |", flush=True)  # fmt: skip


if __name__ == "__main__":
    main()
