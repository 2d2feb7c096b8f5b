import math
from pathlib import Path

from assetpipe.pipeline.poses import configurations
from assetpipe.robot import read_robot

URDF = """<robot name="r">
<link name="a"/><link name="b"/><link name="c"/><link name="d"/><link name="e"/>
<joint name="hinge" type="revolute"><parent link="a"/><child link="b"/>
  <limit lower="0.5" upper="1" effort="1" velocity="1"/></joint>
<joint name="wheel" type="continuous"><parent link="b"/><child link="c"/></joint>
<joint name="twin" type="revolute"><parent link="c"/><child link="d"/><mimic joint="hinge"/>
  <limit lower="0" upper="1" effort="1" velocity="1"/></joint>
<joint name="glue" type="fixed"><parent link="d"/><child link="e"/></joint>
</robot>"""


def drawn(tmp_path: Path, seed: int) -> list[dict[str, float]]:
    path = tmp_path / "r.urdf"
    path.write_text(URDF)
    return [dict(p) for p in configurations(read_robot(path).robot, count=200, seed=seed)]


def test_home_comes_first_and_draws_stay_within_limits(tmp_path: Path) -> None:
    poses = drawn(tmp_path, 0)
    assert len(poses) == 201
    assert poses[0] == {"hinge": 0.5, "wheel": 0.0}
    hinge, wheel = ([pose[name] for pose in poses[1:]] for name in ("hinge", "wheel"))
    assert all(set(pose) == {"hinge", "wheel"} for pose in poses)
    assert 0.5 <= min(hinge) < 0.55
    assert 0.95 < max(hinge) <= 1.0
    assert -math.pi <= min(wheel) < -2.9
    assert 2.9 < max(wheel) <= math.pi


def test_seed_decides_the_draws(tmp_path: Path) -> None:
    assert drawn(tmp_path, 1) == drawn(tmp_path, 1)
    assert drawn(tmp_path, 1) != drawn(tmp_path, 2)
