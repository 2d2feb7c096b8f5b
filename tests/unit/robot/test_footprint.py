"""Footprints of robots, against shapes whose shadow is known."""

import numpy as np
import pytest
import shapely

from assetpipe.errors import InputError, UsageError
from assetpipe.robot.footprint import configurations, footprint
from assetpipe.robot.reader import read_robot

URDF = """<robot name="cart">
  <link name="base">
    <collision><geometry><box size="0.6 0.4 0.2"/></geometry></collision>
  </link>
  <link name="arm">
    <collision><origin xyz="0.5 0 0"/><geometry><box size="1.0 0.1 0.1"/></geometry></collision>
  </link>
  <link name="lamp">
    <collision><geometry><sphere radius="0.3"/></geometry></collision>
  </link>
  <joint name="swing" type="revolute">
    <parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2" effort="1" velocity="1"/>
  </joint>
  <joint name="mast" type="fixed">
    <parent link="base"/><child link="lamp"/><origin xyz="0 0 2"/>
  </joint>
</robot>"""


@pytest.fixture
def robot(tmp_path):
    path = tmp_path / "cart.urdf"
    path.write_text(URDF)
    return read_robot(path).robot


def test_shadow_of_boxes_below_a_height(robot):
    found = footprint(robot, tolerance=0.01, below=1.0)
    truth = shapely.box(-0.3, -0.2, 0.3, 0.2).union(shapely.box(0, -0.05, 1, 0.05))
    assert found.outline.contains(truth)
    assert found.outline.area == pytest.approx(truth.area, rel=1e-4)
    assert found.links == ("base", "arm")
    assert found.decomposition.concavity <= 0.01
    assert found.outline.contains(found.inner)
    ring = shapely.Polygon(found.ring)
    assert ring.exterior.is_ccw
    assert ring.contains(truth)
    assert shapely.hausdorff_distance(ring.exterior, found.outline.exterior) <= 0.011


def test_the_lamp_counts_without_a_height(robot):
    found = footprint(robot)
    assert found.links == ("base", "arm", "lamp")
    disc = shapely.Point(0, 0).buffer(0.3, quad_segs=256)
    assert found.outline.contains(disc)


def test_joint_ranges_are_joined(robot):
    turned = footprint(robot, [{"swing": np.pi / 2}], below=1.0)
    assert turned.outline.bounds[3] == pytest.approx(1.0, abs=1e-4)
    swept = footprint(robot, configurations(robot, {"swing": (-1.5, 1.5)}, steps=61), below=1.0)
    assert swept.outline.area > turned.outline.area * 2
    assert swept.outline.contains(shapely.Point(0.7, 0.6))


def test_refusals(robot):
    with pytest.raises(UsageError, match="joint"):
        configurations(robot, {"swung": (0, 1)})
    with pytest.raises(UsageError, match="more than"):
        configurations(robot, {"swing": (0, 1)}, steps=10_000)
    with pytest.raises(UsageError, match="tolerance"):
        footprint(robot, tolerance=0.0)
    with pytest.raises(InputError, match="no visual shape"):
        footprint(robot, source="visual")
