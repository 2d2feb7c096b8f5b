import json
import math

import pytest

import assetpipe
from assetpipe.errors import InputError, UsageError
from assetpipe.robot import home, read_robot
from assetpipe.shipped import CONFIGS
from assetpipe.validation import adjacent_pairs
from assetpipe.validation.dynamics import available_engines
from assetpipe.validation.dynamics.settle import settle_in_engine
from assetpipe.validation.dynamics.settle_record import Snapshot, summary

ENGINES = available_engines()
SAMPLE = CONFIGS.parent.parent / "sample_assets" / "toaster" / "urdf" / "toaster.urdf"
LINK = (
    '<link name="{name}"><inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" '
    'ixy="0" ixz="0" iyz="0"/></inertial>{shape}</link>'
)
BOX = '<collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision>'
SLIDE = (
    '<joint name="{child}" type="prismatic"><parent link="{parent}"/><child link="{child}"/>'
    '<origin xyz="{x} 0 0"/><axis xyz="1 0 0"/>'
    '<limit lower="-1" upper="1" effort="50" velocity="1"/></joint>'
)


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    if not SAMPLE.is_file():
        pytest.skip("the sample assets are not beside this installation")
    out = tmp_path_factory.mktemp("built")
    config = assetpipe.Config(effort="fast", validation={"checks": ()})
    return assetpipe.build(SAMPLE, out, config=config).urdf


def settled(urdf, **more):
    robot = read_robot(urdf).robot
    return settle_in_engine(
        urdf,
        home=home(robot),
        excluded=adjacent_pairs((j.parent, j.child, j.type) for j in robot.joints),
        resolved={r.uri: r.resolution.path for r in robot.references if r.resolution.path},
        **more,
    )


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(("base", "rate"), [("fixed", 60), ("free", 60), ("free", 1000)])
def test_a_built_robot_stays_where_it_is_put(built, engine, base, rate):
    found = settled(built, base=base, step=1.0 / rate, engine=engine, seconds=3.0)
    assert found.outcome == "settled", found.message
    assert found.energy_gain < 0.01
    assert found.residual_speed < 1e-3
    assert found.drift < 1e-3
    assert json.dumps(found.as_dict(), allow_nan=False)


@pytest.mark.parametrize("engine", ENGINES)
def test_links_that_overlap_are_seen_to_move_what_nobody_moves(tmp_path, engine):
    # The third box lies within the first; the two are not adjacent, so they push.
    urdf = tmp_path / "overlap.urdf"
    links = [LINK.format(name=n, shape=s) for n, s in (("a", BOX), ("b", ""), ("c", BOX))]
    joints = [
        SLIDE.format(parent="a", child="b", x=0.0),
        SLIDE.format(parent="b", child="c", x=0.02),
    ]
    urdf.write_text(f'<robot name="r">{"".join(links + joints)}</robot>', encoding="utf-8")
    pushed = settle_in_engine(urdf, base="fixed", step=1 / 240, engine=engine, seconds=1.0)
    apart = settle_in_engine(
        urdf, base="fixed", step=1 / 240, engine=engine, seconds=1.0, excluded=[("a", "c")]
    )
    assert pushed.sag > 10.0 * max(apart.sag, 1e-3)


def test_what_is_no_longer_finite_is_said():
    good = Snapshot(0.0, 1.0, 0.0, 0.0, ((0.0, 0.0, 0.0),))
    bad = Snapshot(0.1, math.nan, 0.0, 0.0, ((0.0, 0.0, 0.0),))
    told = summary([good, bad], mass=1.0, size=1.0, sag=0.0, cpu_seconds=0.0)
    assert (told["finite"], told["message"]) == (False, "not finite after 0.1 s")


def test_energy_is_told_against_lifting_the_robot_by_its_size():
    low = Snapshot(0.0, 10.0, 0.0, 0.0, ((0.0, 0.0, 0.0),))
    high = Snapshot(1.0, 10.0 + 9.81 * 2.0, 0.5, 0.1, ((0.0, 0.0, 0.3),))
    told = summary([low, high], mass=1.0, size=2.0, sag=0.0, cpu_seconds=0.0)
    assert told["energy_gain"] == pytest.approx(1.0)
    assert told["drift"] == pytest.approx(0.3)


def test_wrong_requests_are_refused(tmp_path):
    with pytest.raises(InputError, match="does not exist"):
        settle_in_engine(tmp_path / "none.urdf", base="fixed", step=0.01)
    with pytest.raises(UsageError, match="shorter than seconds"):
        settle_in_engine(tmp_path / "none.urdf", base="fixed", step=9.0)
    with pytest.raises(UsageError, match=r"base 'fre' not found; did you mean 'free'"):
        settle_in_engine(tmp_path / "none.urdf", base="fre", step=0.01)
    large = tmp_path / "large.urdf"
    with large.open("wb") as file:
        file.truncate((64 << 20) + 1)
    with pytest.raises(InputError, match="larger than 64 MiB"):
        settle_in_engine(large, base="fixed", step=0.01)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_joint_without_limits_is_held_where_it_is_put(tmp_path, engine):
    # URDF gives limits of a continuous joint no meaning; PyBullet would snap back to them.
    turn = (
        '<joint name="{child}" type="{kind}"><parent link="a"/><child link="{child}"/>'
        '<axis xyz="0 0 1"/><limit lower="-0.1" upper="0" effort="50" velocity="1"/></joint>'
    )
    text = "".join(LINK.format(name=n, shape="") for n in "abc")
    text += turn.format(child="b", kind="revolute")
    text += turn.format(child="c", kind="continuous")
    urdf = tmp_path / "turns.urdf"
    urdf.write_text(f'<robot name="r">{text}</robot>', encoding="utf-8")
    found = settle_in_engine(
        urdf, base="fixed", step=1 / 240, seconds=1.0, engine=engine, home={"c": 0.5}
    )
    assert found.sag == pytest.approx(0.0, abs=1e-6)
