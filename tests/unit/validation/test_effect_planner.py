import pytest

from assetpipe.errors import ConfigError
from assetpipe.validation.effects import EFFECTS, plan
from assetpipe.validation.scenes import build_assets, parse_scene

BOX = {"body": "box", "size": [0.1, 0.1, 0.1]}
GROUND = {"body": "box", "size": [1, 1, 0.02], "pose": {"xyz": [0, 0, -0.01]}}


def falling(height=0.051, **more):
    return {**BOX, "mass": 1, "base": "free", "pose": {"xyz": [0, 0, height]}, **more}


def planned(question, assets, *, effects=None, scope="needed", **more):
    scene = parse_scene({"title": "t", "question": question, "assets": assets, **more})
    return plan(scene, build_assets(scene), effects=effects, scope=scope)


def still(**more):
    assets = {"a": BOX, "b": {**BOX, "pose": {"xyz": [1, 0, 0]}}}
    return planned("clearance", assets, between=["a", "b"], **more)


def settling(assets, **more):
    return planned("settle", assets, limit=0.002, drive={"gravity": 9.81}, **{"seconds": 1, **more})


def test_a_static_clearance_is_one_distance_query():
    found = still()
    assert (found.method, found.backend, found.steps) == ("distance", "fcl", 0)
    assert not any(e.is_on for e in found.effects)
    assert found.pairs == ((("a", "body"), ("b", "body")),)


def test_every_effect_has_a_state_and_a_reason():
    for found in (still(), settling({"ground": GROUND, "box": falling()})):
        assert [e.name for e in found.effects] == list(EFFECTS)
        assert all(e.reason for e in found.effects)
        assert all(r.reason for r in found.roles)
        text = found.explain()
        assert all(name in text for name in EFFECTS)


def test_a_given_motion_is_swept_not_simulated():
    found = planned(
        "reach",
        {"peg": {**BOX, "base": "driven"}, "wall": {**BOX, "pose": {"xyz": [0.5, 0, 0]}}},
        drive={"path": {"asset": "peg", "waypoints": [{"xyz": [0.3, 0, 0], "at": 1}]}},
    )
    assert (found.method, found.backend, found.steps) == ("sweep", "fcl", 0)


def test_what_the_path_cannot_reach_is_left_out():
    found = planned(
        "reach",
        {
            "peg": {**BOX, "base": "driven"},
            "near": {**BOX, "pose": {"xyz": [0.42, 0, 0]}},
            "far": {**BOX, "pose": {"xyz": [5, 0, 0]}},
        },
        drive={"path": {"asset": "peg", "waypoints": [{"xyz": [0.3, 0, 0], "at": 1}]}},
    )
    assert found.role("far", "body") == "left out"
    assert found.role("near", "body") == "frozen"
    assert found.role("peg", "body") == "moves"
    assert dict(found.skipped_pairs) == {
        "swept volumes apart": 1,
        "never move relative to each other": 1,
    }


def test_nothing_movable_never_steps():
    found = planned("hold", {"a": BOX, "b": BOX}, subject="a", limit=1, drive={"gravity": 9.81})
    assert (found.method, found.backend, found.steps) == ("nothing", "none", 0)


def test_gravity_is_off_where_it_does_no_work(tmp_path):
    text = (
        '<robot name="r"><link name="a"/><link name="b"><collision><geometry><box size="1 1 1"/>'
        '</geometry></collision></link><joint name="j" type="prismatic"><parent link="a"/>'
        '<child link="b"/><axis xyz="{axis}"/><limit lower="-1" upper="1" effort="1" '
        'velocity="1"/></joint></robot>'
    )
    for axis, state in (("1 0 0", "off"), ("0 0 1", "on"), ("1 0 0.1", "on")):
        path = tmp_path / "r.urdf"
        path.write_text(text.format(axis=axis), encoding="utf-8")
        found = planned(
            "open",
            {"r": {"urdf": str(path), "moving": ["j"]}},
            subject="r/j",
            limit=0.1,
            drive={"gravity": 9.81},
        )
        assert found.effect("gravity").state == state


def test_friction_needs_contact_and_a_reason():
    assert settling({"ground": GROUND, "box": falling()}).effect("friction").is_on
    dull = {"material": {"friction": 0}}
    slippery = settling({"ground": {**GROUND, **dull}, "box": falling(**dull)})
    assert not slippery.effect("friction").is_on
    alone = settling({"box": falling()})
    assert not alone.effect("friction").is_on
    assert alone.pairs == ()


def test_restitution_only_where_the_rebound_shows():
    springy = {"material": {"restitution": 0.5}}
    resting = settling({"ground": {**GROUND, **springy}, "box": falling(0.0501, **springy)})
    assert not resting.effect("restitution").is_on
    dropped = settling({"ground": {**GROUND, **springy}, "box": falling(0.5, **springy)})
    assert dropped.effect("restitution").is_on


def test_continuous_collision_only_where_a_step_passes_the_thinnest_part():
    thick = settling({"ground": GROUND, "box": falling(2.0)})
    assert not thick.effect("continuous_collision").is_on
    thin = {"body": "box", "size": [1, 1, 0.001]}
    small = {"body": "box", "size": [0.01] * 3, "mass": 1, "base": "free"}
    high = settling({"ground": thin, "box": {**small, "pose": {"xyz": [0, 0, 5]}}})
    assert high.effect("continuous_collision").is_on
    assert "1 mm ('ground/body')" in high.effect("continuous_collision").reason
    assert high.effect("continuous_collision").value == pytest.approx(0.004)


def test_step_follows_the_limit_and_the_speed():
    coarse = planned(
        "settle",
        {"ground": GROUND, "box": falling()},
        limit=0.1,
        drive={"gravity": 9.81},
    )
    fine = settling({"ground": GROUND, "box": falling()})
    assert coarse.step.value == pytest.approx(1 / 120)
    assert fine.step.value < coarse.step.value
    assert "gravity" in fine.step.reason
    assert fine.step.value**2 * 9.81 <= 0.0002 * 1.01


@pytest.mark.parametrize(("ratio", "rate"), [(1, 222), (5, 222), (100, 701), (1000, 2000)])
def test_step_shrinks_where_a_light_body_may_carry_a_heavy_one(ratio, rate):
    heavy = falling(0.152, mass=ratio)
    found = settling({"ground": GROUND, "light": falling(), "heavy": heavy})
    assert round(1.0 / found.step.value) == pytest.approx(rate, abs=1)
    assert ("times as heavy" in found.step.reason) == (ratio > 10)


def test_iterations_grow_with_the_stack():
    two = settling({"ground": GROUND, "a": falling(), "b": falling(0.2)})
    one = settling({"ground": GROUND, "a": falling()})
    assert two.iterations.value > one.iterations.value


def test_the_user_overrules_and_the_plan_says_so():
    found = settling({"ground": GROUND, "box": falling()}, effects={"friction": "off"})
    assert found.effect("friction").state == "off"
    assert found.effect("friction").overruled
    assert "planner says on" in found.effect("friction").reason
    assert not found.effect("gravity").overruled
    assert "overruled" in found.explain()


def test_an_effect_asked_for_makes_a_physics_world():
    found = still(effects={"friction": "on"})
    assert found.method == "dynamics"
    assert "friction is asked for" in found.why
    assert still(effects={"friction": "off"}).method == "distance"


def test_everything_is_everything():
    found = still(scope="everything")
    assert all(e.is_on for e in found.effects)
    assert found.step.value == pytest.approx(1 / 2000)
    assert found.idle_joints == "held"


def test_the_plan_is_a_pure_function():
    scene = parse_scene(
        {
            "title": "t",
            "question": "settle",
            "limit": 0.01,
            "assets": {"ground": GROUND, "box": falling()},
            "drive": {"gravity": 9.81},
        }
    )
    assets = build_assets(scene)
    assert plan(scene, assets) == plan(scene, build_assets(scene))
    assert plan(scene, assets).as_dict() == plan(scene, assets).as_dict()


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"subject": "arm/elbo_joint"}, "did you mean 'elbow_joint'"),
        ({"subject": "arm/wrist_roll_joint"}, "cannot open: add it to 'moving'"),
    ],
)
def test_names_are_checked_against_the_assets(changes, told):
    values = {
        "title": "t",
        "question": "open",
        "subject": "arm/elbow_joint",
        "limit": 0.1,
        "assets": {"arm": {"package": "arm_gripper", "moving": ["elbow_joint"]}},
        "drive": {"gravity": 9.81},
        **changes,
    }
    scene = parse_scene(values)

    class Empty:
        def convexes(self, mesh, engine, tolerance):
            from assetpipe.validation.scenes import Convexes

            return Convexes((mesh,), 0.0, "surface")

    with pytest.raises(ConfigError, match=told):
        plan(scene, build_assets(scene, provider=Empty()))
