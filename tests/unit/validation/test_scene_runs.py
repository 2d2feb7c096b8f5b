import json
from dataclasses import replace

import numpy as np
import pytest

from assetpipe.errors import ConfigError
from assetpipe.shipped import CONFIGS
from assetpipe.validation.dynamics import available_engines
from assetpipe.validation.effects import METHODS, plan
from assetpipe.validation.effects.plan import Setting
from assetpipe.validation.runners import SceneOptions, answer_scene, run_queries, run_scene
from assetpipe.validation.runners.scene import attempt, same_answer
from assetpipe.validation.scenes import DirectProvider, build_assets, load_scene, parse_scene

SHIPPED = sorted(p.stem for p in (CONFIGS / "scenes").glob("*.yaml"))
BULLET = pytest.mark.skipif(
    "bullet" not in available_engines(), reason="PyBullet has no wheel for this Python"
)
BOX = {"body": "box", "size": [0.1, 0.1, 0.1]}


@pytest.fixture(scope="module")
def provider():
    return DirectProvider()


def answered(**values):
    scene = parse_scene({"title": "t", **values})
    return answer_scene(scene, build_assets(scene))


# -- queries ------------------------------------------------------------------


def test_clearance_of_two_boxes():
    assets = {"a": BOX, "b": {**BOX, "pose": {"xyz": [0.3, 0, 0]}}}
    found = answered(question="clearance", between=["a", "b"], assets=assets, limit=0.1)
    assert found.measured.measure == pytest.approx(0.2)
    assert found.answer is True


@pytest.mark.parametrize(("x", "touch"), [(0.09, True), (0.11, False), (0.0, True)])
def test_contact_of_two_boxes(x, touch):
    inner = {"body": "box", "size": [0.02, 0.02, 0.02], "pose": {"xyz": [x - 0.04, 0, 0]}}
    other = {**BOX, "pose": {"xyz": [x, 0, 0]}} if x else inner
    found = answered(question="contact", between=["a", "b"], assets={"a": BOX, "b": other})
    assert found.answer is touch


def reach(waypoints, wall, **more):
    return answered(
        question="reach",
        assets={"peg": {**BOX, "base": "driven"}, "wall": wall},
        drive={"path": {"asset": "peg", "waypoints": waypoints}},
        **more,
    )


def test_where_nothing_can_get_there_is_nothing_to_measure():
    found = reach([{"xyz": [0.1, 0, 0], "at": 1}], {**BOX, "pose": {"xyz": [9, 0, 0]}})
    assert (found.answer, found.measured.measure) == (True, None)


def test_a_straight_sweep_is_exact_and_one_query():
    wall = {"body": "box", "size": [0.2, 0.2, 0.2], "pose": {"xyz": [0.5, 0.16, 0]}}
    found = reach([{"xyz": [1, 0, 0], "at": 1}], wall)
    assert found.answer is True
    assert found.measured.measure == pytest.approx(0.01, abs=1e-9)
    assert found.measured.evidence["queries"] == 1


def test_a_sweep_does_not_jump_over_a_thin_wall():
    wall = {"body": "box", "size": [1e-4, 1, 1], "pose": {"xyz": [0.5, 0, 0]}}
    found = reach([{"xyz": [1, 0, 0], "at": 1}], wall)
    assert found.answer is False
    # the peg's front is 50 mm ahead of its middle
    assert found.measured.evidence["at"] == pytest.approx(0.45, abs=1e-3)
    assert found.measured.evidence["touched"] == ["peg/body", "wall/body"]


def test_a_turning_sweep_meets_what_only_the_corner_reaches():
    # the half diagonal is 70.7 mm, the half edge 50 mm
    for distance, free in ((0.072, True), (0.069, False)):
        wall = {"body": "box", "size": [0.02, 1, 1], "pose": {"xyz": [distance + 0.01, 0, 0]}}
        found = reach([{"rpy": [0, 0, np.pi / 2], "at": 1}], wall)
        assert found.answer is free
        assert found.measured.evidence["queries"] > 1


def test_a_whole_turn_is_no_standing_still():
    wall = {"body": "box", "size": [0.02, 1, 1], "pose": {"xyz": [0.075, 0, 0]}}
    assert reach([{"rpy": [0, 0, 2 * np.pi], "at": 1}], wall).answer is False


def test_starting_inside_is_contact():
    big = {"body": "box", "size": [1, 1, 1]}
    found = reach([{"xyz": [0.1, 0, 0], "at": 1}], big)
    assert found.answer is False
    assert found.measured.evidence["at"] == 0.0


def test_clearance_over_a_trajectory_is_the_least(provider):
    scene, path = load_scene("drawer_clearance")
    assets = build_assets(scene, path, provider=provider)
    swept = run_queries(scene, assets, plan(scene, assets)).measure
    cabinet = assets["cabinet"]
    from assetpipe.validation.runners.world import QueryWorld

    refs = ("cabinet", "body"), ("cabinet", "drawer")
    world = QueryWorld(assets, set(refs))
    sampled = []
    for opening in np.linspace(0, 0.3, 31):
        world.place({"cabinet": {"drawer_joint": float(opening)}})
        sampled.append(world.gap(*refs))
    assert swept == pytest.approx(min(sampled), abs=1e-6)
    assert cabinet.link["drawer"].certificate <= 0.002


# -- shipped scenes -----------------------------------------------------------


def needs_engine(name):
    return load_scene(name)[0].question in ("settle", "hold", "open", "slide")


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_scenes_answer_as_they_expect(name, provider):
    if needs_engine(name) and not available_engines():
        pytest.skip("no physics engine is installed")
    found = run_scene(name, provider=provider)
    assert found.message == ""
    assert found.expected is True, found.measured
    assert found.findings() == ()
    assert json.loads(json.dumps(found.as_dict()))["name"] == name


@BULLET
@pytest.mark.parametrize("name", SHIPPED)
def test_everything_on_changes_no_answer(name, provider):
    scene, path = load_scene(name)
    assets = build_assets(scene, path, provider=provider)
    least, full = plan(scene, assets), plan(scene, assets, scope="everything")
    assert METHODS.index(least.method) <= METHODS.index(full.method)
    options = SceneOptions()
    first, _, _ = attempt(scene, assets, least, options)
    second, _, message = attempt(scene, assets, full, options)
    assert message == ""
    assert same_answer(scene, least, first, full, second), (first, second)


@BULLET
def test_sensitivity_says_what_every_effect_was_worth():
    scene, path = load_scene("tower_settles")
    found = answer_scene(
        scene, build_assets(scene, path), options=SceneOptions(depth="sensitivity")
    )
    toggled = {t.effect: t for t in found.toggled}
    assert len(toggled) == 12
    assert not toggled["friction"].same
    assert toggled["damping"].same
    assert toggled["everything"].same
    assert toggled["everything"].seconds > 2.0 * found.seconds


@BULLET
def test_same_scene_same_numbers():
    first, again = (run_scene("tower_settles").measured for _ in range(2))
    assert first == again


def test_an_unexpected_answer_is_a_finding():
    assets = {"a": BOX, "b": {**BOX, "pose": {"xyz": [0.3, 0, 0]}}}
    found = answered(
        question="contact", between=["a", "b"], assets=assets, expect={"answer": "yes"}
    )
    assert [f.code for f in found.findings()] == ["AP410"]
    assert "expected yes" in found.findings()[0].message


def test_without_an_engine_a_scene_is_not_passed(monkeypatch):
    from assetpipe.validation.runners import scene as module

    monkeypatch.setattr(module, "default_engine", lambda: None)
    found = run_scene("tower_settles")
    assert found.answer is None
    assert [f.code for f in found.findings()] == ["AP411"]


DYNAMIC = [name for name in SHIPPED if needs_engine(name)]


@pytest.mark.skipif("mujoco" not in available_engines(), reason="MuJoCo is not installed")
@pytest.mark.parametrize("name", DYNAMIC)
def test_the_second_engine_gives_the_same_answers(name, provider):
    found = run_scene(name, provider=provider, options=SceneOptions(engine="mujoco"))
    assert found.message == ""
    assert found.expected is True, found.measured


@pytest.mark.parametrize("engine", available_engines())
def test_a_ball_set_down_stays_where_it_was_set(engine):
    # As a polyhedron it rolled to one of its facets, by several centimetres.
    scene = parse_scene(
        {
            "title": "a ball on a slab",
            "question": "settle",
            "assets": {
                "slab": {"body": "box", "size": [1, 1, 0.05]},
                "ball": {
                    "body": "sphere",
                    "radius": 0.03,
                    "mass": 0.1,
                    "base": "free",
                    "pose": {"xyz": [0, 0, 0.06]},
                    "material": {"friction": 0.5},
                },
            },
            "drive": {"gravity": 9.81},
            "limit": 0.007,
            "seconds": 2,
        }
    )
    found = answer_scene(scene, build_assets(scene), options=SceneOptions(engine=engine))
    assert found.measured.measure == pytest.approx(0.005, abs=1e-3)
    assert found.answer is True


@pytest.mark.parametrize("engine", available_engines())
def test_a_thousand_times_heavier_body_stands_on_a_light_one(engine):
    # At the step that gravity alone asks for it is thrown off, or sinks through.
    box = {"body": "box", "size": [0.1, 0.1, 0.1], "base": "free", "material": {"friction": 0.6}}
    scene = parse_scene(
        {
            "title": "heavy on light",
            "question": "settle",
            "assets": {
                "floor": {"body": "box", "size": [1, 1, 0.1], "pose": {"xyz": [0, 0, -0.05]}},
                "light": {**box, "mass": 0.1, "pose": {"xyz": [0, 0, 0.05]}},
                "heavy": {**box, "mass": 100, "pose": {"xyz": [0, 0, 0.15]}},
            },
            "drive": {"gravity": 9.81},
            "limit": "2mm",
            "seconds": 1,
        }
    )
    assets, options = build_assets(scene), SceneOptions(engine=engine)
    assert answer_scene(scene, assets, options=options).answer is True
    habit = replace(plan(scene, assets, engine=engine), step=Setting(1 / 60, "habit"))
    found, _, _ = attempt(scene, assets, habit, options)
    assert found.answer is False


def test_what_a_scene_says_wrong_about_its_assets_is_told_with_its_file(tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text(
        "title: t\nquestion: hold\nsubject: arm\nlimit: 1mm\ndrive: {gravity: 9.81}\n"
        "assets: {arm: {package: arm_gripper, collision: hull, moving: [elbo_joint]}}\n",
        encoding="utf-8",
    )
    with pytest.raises(ConfigError, match=r"mine\.yaml: .*did you mean 'elbow_joint'"):
        run_scene(file)
