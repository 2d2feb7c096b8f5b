"""Writes meshes of robots that no setting was chosen on, for ``benchmarks/run.py``.

    python benchmarks/aside.py aside
    python benchmarks/run.py aside --engines balanced-thickening,coacd

They are closed one-body meshes of PyBullet's data that no shipped setting, test or other
benchmark has seen; the list was fixed before any of them was measured.
"""

from __future__ import annotations

import argparse
from pathlib import Path

MESHES = (
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
)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("out", type=Path, help="a folder; its name is the set's")
    out: Path = parser.parse_args().out
    import pybullet_data
    import trimesh

    out.mkdir(parents=True, exist_ok=True)
    for name in MESHES:
        mesh = trimesh.load(Path(pybullet_data.getDataPath()) / name, force="mesh", process=True)
        mesh.merge_vertices(merge_tex=True, merge_norm=True)
        if not mesh.is_watertight:
            raise SystemExit(f"{name} is not closed in this version of pybullet_data")
        trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).export(
            out / f"{Path(name).stem}.off"
        )


if __name__ == "__main__":
    main()
