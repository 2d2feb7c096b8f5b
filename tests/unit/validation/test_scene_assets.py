import math

import numpy as np
import pytest
import trimesh

from assetpipe.errors import ConfigError, InputError
from assetpipe.geometry.mesh import Mesh
from assetpipe.robot import forward_kinematics, read_robot
from assetpipe.validation.dynamics.erode import eroded
from assetpipe.validation.effects import plan
from assetpipe.validation.profiles import insphere_radius
from assetpipe.validation.scenes import Convexes, build_assets, parse_scene
from assetpipe.validation.scenes.asset_spec import AssetSpec
from assetpipe.validation.scenes.assets import Inertial, matrix_of
from assetpipe.validation.scenes.bodies import body_mesh
from assetpipe.validation.scenes.build import find_package


class WholeHulls:
    """One hull for every mesh: quick, and enough where shapes don't matter."""

    def convexes(self, mesh, engine, tolerance):
        return Convexes((Mesh.of(mesh.to_trimesh().convex_hull),), 0.0)


def assets_of(**assets):
    names = sorted(assets)
    values = {"title": "t", "question": "clearance", "between": names[:2], "assets": assets}
    return build_assets(parse_scene(values), provider=WholeHulls())


def arm(**more):
    other = {"body": "box", "size": [1, 1, 1]}
    return assets_of(arm={"package": "arm_gripper", **more}, other=other)["arm"]


def test_frames_agree_with_the_robots_own_kinematics():
    asset = arm()
    robot = read_robot(find_package("arm_gripper", None)).robot
    rng = np.random.default_rng(2)
    for _ in range(5):
        positions = {
            j.name: float(rng.uniform(j.limit.lower, j.limit.upper))
            for j in robot.joints
            if j.movable and j.mimic is None
        }
        expected = forward_kinematics(robot, positions)
        found = asset.frames(positions)
        assert set(found) == set(expected)
        for name, matrix in expected.items():
            assert found[name] == pytest.approx(matrix, abs=1e-12)


def test_mimic_and_mass_and_damping_come_along():
    asset = arm(joints={"left_finger_joint": 0.01})
    assert asset.positions()["right_finger_joint"] == pytest.approx(0.01)
    assert asset.link["base_link"].inertial.mass == 3.0
    assert asset.joint["elbow_joint"].damping == 0.5
    assert asset.joint["elbow_joint"].effort == 80


def test_configurations_are_seeded_and_within_limits():
    asset = arm()
    drawn = asset.configurations(50, seed=3)
    assert drawn == asset.configurations(50, seed=3)
    assert drawn != asset.configurations(50, seed=4)
    assert len(drawn) == 51
    for values in drawn[1:]:
        assert "right_finger_joint" not in values
        for name, value in values.items():
            assert asset.joint[name].lower <= value <= asset.joint[name].upper


def test_home_is_the_nearest_limit_where_zero_is_out_of_range(tmp_path):
    text = (
        '<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="prismatic">'
        '<parent link="a"/><child link="b"/><axis xyz="1 0 0"/>'
        '<limit lower="0.2" upper="0.5" effort="1" velocity="1"/></joint></robot>'
    )
    (tmp_path / "r.urdf").write_text(text, encoding="utf-8")
    asset = assets_of(r={"urdf": str(tmp_path / "r.urdf")}, s={"body": "sphere", "radius": 1})["r"]
    assert asset.positions() == {"j": 0.2}


def test_names_that_do_not_exist_name_their_neighbours():
    with pytest.raises(ConfigError, match="did you mean 'elbow_joint'"):
        arm(joints={"elbo_joint": 0})
    with pytest.raises(ConfigError, match="did you mean 'palm_link'"):
        arm(link="palm_lnk")
    with pytest.raises(ConfigError, match="did you mean 'toaster'"):
        assets_of(a={"package": "toster"}, b={"package": "cabinet"})
    with pytest.raises(InputError, match="does not exist"):
        assets_of(a={"urdf": "none.urdf"}, b={"package": "cabinet"})


CORNER = [[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]]


@pytest.mark.parametrize(
    ("spec", "volume"),
    [
        ({"body": "box", "size": [1, 2, 3]}, 6.0),
        ({"body": "sphere", "radius": 1}, 4 / 3 * math.pi),
        ({"body": "cylinder", "radius": 1, "length": 2}, 2 * math.pi),
        ({"body": "capsule", "radius": 1, "length": 2}, 2 * math.pi + 4 / 3 * math.pi),
        ({"body": "extrusion", "outline": CORNER, "length": 2}, 6.0),
    ],
    ids=["box", "sphere", "cylinder", "capsule", "extrusion"],
)
def test_bodies_have_their_volume_and_stand_on_their_frame(spec, volume):
    mesh = body_mesh(AssetSpec(**spec))
    assert mesh.to_trimesh().is_watertight
    assert mesh.volume == pytest.approx(volume, rel=5e-3)
    if spec["body"] != "extrusion":
        assert mesh.bounds.sum(axis=0) == pytest.approx(np.zeros(3), abs=1e-12)


@pytest.mark.parametrize(
    ("outline", "told"),
    [
        ([[0, 0], [0, 1], [1, 1], [1, 0]], "counter-clockwise"),
        ([[0, 0], [2, 0], [0, 2], [2, 2], [-1, 1]], "crosses or touches itself"),
        ([[0, 0], [1, 1], [1, 0], [0, 1]], "crosses or touches itself"),
    ],
)
def test_outlines_that_are_none(outline, told):
    with pytest.raises(ConfigError, match=told):
        body_mesh(AssetSpec(body="extrusion", outline=outline, length=1))


def test_inertia_of_a_box_made_of_two():
    halves = [
        Mesh.of(trimesh.creation.box((1, 2, 3)).apply_translation((x, 0, 0))) for x in (-0.5, 0.5)
    ]
    found = Inertial.uniform(halves, 6.0)
    assert found.centre == pytest.approx(np.zeros(3), abs=1e-12)
    expected = np.diag([4 + 9, 4 + 9, 4 + 4]) * 6.0 / 12.0
    assert found.inertia == pytest.approx(expected, abs=1e-9)


def test_matrix_of_is_urdfs_convention():
    matrix = matrix_of((1, 2, 3), (0.1, 0.2, 0.3))
    expected = trimesh.transformations.euler_matrix(0.1, 0.2, 0.3, axes="sxyz")
    expected[:3, 3] = (1, 2, 3)
    assert matrix == pytest.approx(expected)


def test_erosion_moves_every_facet_of_a_box_inwards():
    box = Mesh.of(trimesh.creation.box((0.2, 0.1, 0.05)))
    inner = eroded(box, 0.001)
    assert inner.bounds == pytest.approx(box.bounds * [[0.99, 0.98, 0.96]], abs=1e-12)
    assert inner.to_trimesh().is_convex


def test_erosion_leaves_a_core_of_thin_hulls_and_flat_ones_alone():
    plate = Mesh.of(trimesh.creation.box((0.2, 0.1, 0.001)))
    inner = eroded(plate, 0.001)
    assert insphere_radius(inner) == pytest.approx(0.2 * 0.0005, rel=1e-6)
    flat = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    assert eroded(flat, 0.001) is flat


@pytest.mark.parametrize("seed", range(5))
def test_an_eroded_hull_with_its_margin_stays_inside_the_hull(seed):
    rng = np.random.default_rng(seed)
    hull = Mesh.of(trimesh.convex.convex_hull(rng.normal(size=(40, 3)) * (0.1, 0.05, 0.02)))
    inner = eroded(hull, 0.002)
    from assetpipe.validation.contact.surface import outside_hulls

    assert outside_hulls(inner.vertices, [hull]).max() == pytest.approx(-0.002, abs=1e-9)


ARM = {"package": "arm_gripper"}


@pytest.mark.parametrize(
    ("arm", "drive", "told"),
    [
        (
            {"joints": {"elbow_joint": 99}},
            {},
            r"'elbow_joint' of 'arm' cannot be at 99 rad; .*-2\.2",
        ),
        (
            {"joints": {"right_finger_joint": 0.01}},
            {},
            "'right_finger_joint' of 'arm' follows 'left_finger_joint': set that one",
        ),
        (
            {"moving": ["elbow_joint"]},
            {"motors": {"arm": {"targets": {"elbow_joint": -3}}}},
            "'elbow_joint' of 'arm' cannot be at -3 rad",
        ),
    ],
)
def test_joints_are_put_only_where_they_can_be(arm, drive, told):
    scene = parse_scene(
        {
            "title": "t",
            "question": "hold",
            "subject": "arm",
            "assets": {"arm": {**ARM, **arm, "collision": "hull"}},
            "drive": {"gravity": 9.81, **drive},
            "limit": 0.1,
        }
    )
    with pytest.raises(ConfigError, match=told):
        plan(scene, build_assets(scene))


def test_a_part_without_collision_geometry_is_no_part_of_a_contact(tmp_path):
    urdf = tmp_path / "r.urdf"
    urdf.write_text('<robot name="r"><link name="frame"/></robot>', encoding="utf-8")
    scene = parse_scene(
        {
            "title": "t",
            "question": "clearance",
            "between": ["r/frame", "box"],
            "assets": {
                "r": {"urdf": str(urdf)},
                "box": {"body": "box", "size": [1, 1, 1]},
            },
        }
    )
    with pytest.raises(ConfigError, match=r"'r/frame' has no collision geometry.*box/body"):
        plan(scene, build_assets(scene))


def test_many_configurations_at_once_are_where_each_is_alone():
    scene = parse_scene(
        {
            "title": "t",
            "question": "self_collision",
            "subject": "arm",
            "assets": {"arm": {**ARM, "pose": {"xyz": [1, 2, 3], "rpy": [0.1, 0.2, 0.3]}}},
        }
    )
    arm = build_assets(scene, provider=WholeHulls())["arm"]
    drawn = arm.configurations(20, seed=4)
    together = arm.frames_of(drawn)
    for index, positions in enumerate(drawn):
        for link, matrix in arm.frames(positions).items():
            np.testing.assert_allclose(together[link][index], matrix, atol=1e-12)
