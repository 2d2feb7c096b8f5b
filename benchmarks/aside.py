"""Writes meshes of robots that no setting was chosen on, for ``benchmarks/run.py``.

    python benchmarks/aside.py aside
    python benchmarks/run.py aside/pybullet_data --engines balanced-thickening,coacd

They are closed one-body meshes of packages from PyPI that no shipped setting, test or other
benchmark had seen; each list was fixed before any of its meshes was measured. A package that is
not installed is left out.
"""

from __future__ import annotations

import argparse
from importlib.util import find_spec
from pathlib import Path

MESHES = {
    "pybullet_data": (
        "aliengo/meshes/calf.obj",
        "bicycle/files/frame_scaled.stl",
        "bicycle/files/handlebar_scaled.stl",
        "bicycle/files/wheel_scaled.stl",
        "differential/diff_arm.stl",
        "differential/diff_carrier.stl",
        "differential/diff_motor_cover.stl",
        "differential/diff_pinion.stl",
        "differential/diff_stand.stl",
        "duck.obj",
        "gripper/meshes/GUIDE_WSG50_110.stl",
        "laikago/lower_leg3.obj",
        "quadruped/microtaur/channel_4inch.stl",
        "quadruped/microtaur/fr12_h101.stl",
    ),
    # The first by a hash of their paths, of 60 to 25,000 faces and less than 0.93 of their hulls.
    "reachy_mini": (
        "descriptions/reachy_mini/mjcf/assets/antenna_holder_l_3dprint.stl",
        "descriptions/reachy_mini/mjcf/assets/body_top_3dprint.stl",
        "descriptions/reachy_mini/mjcf/assets/neck_reference_3dprint.stl",
        "descriptions/reachy_mini/mjcf/assets/phs_1_7x20_5_dc10_2.stl",
        "descriptions/reachy_mini/mjcf/assets/pp01102_arducam_carter.stl",
        "descriptions/reachy_mini/urdf/assets/antenna_body_3dprint.stl",
        "descriptions/reachy_mini/urdf/assets/glasses_dolder_3dprint.stl",
        "descriptions/reachy_mini/urdf/assets/m12_lens.stl",
        "descriptions/reachy_mini/urdf/assets/mid_plate.stl",
        "descriptions/reachy_mini/urdf/assets/pp01080_back_small_eye.stl",
        "descriptions/reachy_mini/urdf/assets/shape.stl",
        "descriptions/reachy_mini/urdf/assets/top_body.stl",
    ),
}


def write(package: str, out: Path) -> None:
    """The meshes of a package, each a file of ``out``."""
    import trimesh

    found = find_spec(package)
    if found is None or not found.submodule_search_locations:
        print(f"{package} is not installed: left out")
        return
    out.mkdir(parents=True, exist_ok=True)
    for name in MESHES[package]:
        path = Path(found.submodule_search_locations[0]) / name
        mesh = trimesh.load(path, force="mesh", process=True)
        mesh.merge_vertices(merge_tex=True, merge_norm=True)
        if not mesh.is_watertight:
            raise SystemExit(f"{name} is not closed in this version of {package}")
        trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).export(
            out / f"{Path(name).stem}.off"
        )


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("out", type=Path, help="a folder; gets a folder a package, a set each")
    out: Path = parser.parse_args().out
    for package in MESHES:
        write(package, out / package)


if __name__ == "__main__":
    main()
