from pathlib import Path

import pytest

from assetpipe.errors import ConfigError
from assetpipe.shipped import CONFIGS
from assetpipe.validation.scenes import load_scene, parse_scene

SHIPPED = sorted(p.stem for p in (CONFIGS / "scenes").glob("*.yaml"))
BOX = {"body": "box", "size": [0.1, 0.1, 0.1]}


def scene(**changes):
    values = {
        "title": "two boxes",
        "question": "clearance",
        "between": ["a", "b"],
        "assets": {"a": BOX, "b": {**BOX, "pose": {"xyz": [1, 0, 0]}}},
    }
    values.update(changes)
    return {k: v for k, v in values.items() if v is not None}


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_scenes_fit_the_schema_and_expect_something(name):
    found, path = load_scene(name)
    assert found.title
    assert found.expect.answer is not None
    assert path.is_file()


def test_every_question_but_contact_is_shipped():
    asked = {load_scene(name)[0].question for name in SHIPPED}
    assert asked == {"self_collision", "reach", "open", "slide", "settle", "hold", "clearance"}


def test_lengths_take_units_and_switches_are_words():
    found = parse_scene(scene(limit="2mm", effects={"friction": True}))
    assert found.limit == pytest.approx(0.002)
    assert found.effects == {"friction": "on"}


WRONG = {
    "unknown key": (scene(questoin="x"), r"'questoin' not found; did you mean 'question'\?"),
    "unknown question": (scene(question="touch"), "touch.*allowed.*clearance.*slide"),
    "unknown effect": (scene(effects={"frictoin": "on"}), "frictoin.*friction"),
    "effect neither on nor off": (scene(effects={"friction": "maybe"}), "'on' or 'off'"),
    "clearance without between": (scene(between=None), "'between' is missing"),
    "subject where none belongs": (
        scene(subject="a"),
        "'subject' has no place here; 'subject' belongs to self_collision, hold, open, slide",
    ),
    "unknown asset": (scene(between=["a", "c"]), "asset 'c' not found; assets: a, b"),
    "the same part twice": (scene(between=["a", "a"]), "same part twice"),
    "limit on reach": (
        scene(
            question="reach",
            between=None,
            limit=1,
            assets={"a": {**BOX, "base": "driven"}},
            drive={"path": {"asset": "a", "waypoints": [{"at": 1}]}},
        ),
        "'limit' has no place here",
    ),
    "reach without a path": (scene(question="reach", between=None), "'drive.path' is missing"),
    "settle without gravity": (
        scene(question="settle", between=None, limit=1),
        "'drive.gravity' is missing, for example 9.81",
    ),
    "settle with nothing free": (
        scene(question="settle", between=None, limit=1, drive={"gravity": 9.81}),
        "no asset has base: free",
    ),
    "hold without a drive": (
        scene(question="hold", between=None, subject="a", limit=1),
        "'drive.gravity' or 'drive.motors' is missing",
    ),
    "open without a joint": (
        scene(question="open", between=None, subject="a", limit=1, drive={"gravity": 9.81}),
        "write asset/joint",
    ),
    "path on what is not driven": (
        scene(drive={"path": {"asset": "a", "waypoints": [{"at": 1}]}}),
        "drive.path moves 'a': set its base: driven",
    ),
    "driven without a path": (
        scene(assets={"a": {**BOX, "base": "driven"}, "b": BOX}),
        "'a' is driven but no drive.path names it",
    ),
    "waypoints out of order": (
        scene(
            assets={"a": {**BOX, "base": "driven"}, "b": BOX},
            drive={"path": {"asset": "a", "waypoints": [{"at": 1}, {"at": 1}]}},
        ),
        "in order of time",
    ),
    "motors on a geometric question": (
        scene(
            assets={"a": {"package": "x", "moving": ["j"]}, "b": BOX},
            drive={"motors": {"a": {"targets": {"j": 1}}}},
        ),
        "use drive.trajectory",
    ),
    "a driven joint that is frozen": (
        scene(
            assets={"a": {"package": "x"}, "b": BOX},
            drive={"trajectory": {"asset": "a", "joints": {"j": [0, 1]}, "seconds": 1}},
        ),
        "joint 'j' of 'a' is driven but frozen: add it to 'moving'",
    ),
    "sampling where nothing is sampled": (scene(sampling={}), "belongs to self_collision"),
    "an asset of two kinds": (
        scene(assets={"a": {**BOX, "package": "x"}, "b": BOX}),
        "not package and body",
    ),
    "an asset of no kind": (scene(assets={"a": {}, "b": BOX}), "one of package, urdf or body"),
    "a sphere with a size": (
        scene(assets={"a": {"body": "sphere", "radius": 1, "size": [1, 1, 1]}, "b": BOX}),
        "a sphere has no 'size'; it has radius",
    ),
    "a cylinder without length": (
        scene(assets={"a": {"body": "cylinder", "radius": 1}, "b": BOX}),
        "needs radius and length; 'length' is missing",
    ),
    "a free body without mass": (
        scene(assets={"a": {**BOX, "base": "free"}, "b": BOX}),
        "needs a 'mass'",
    ),
    "collision of what is convex": (
        scene(assets={"a": {**BOX, "collision": "hull"}, "b": BOX}),
        "convex as it is",
    ),
    "unknown collision": (
        scene(assets={"a": {"package": "x", "collision": "vhcad"}, "b": BOX}),
        "vhcad.*allowed.*vhacd",
    ),
    "joints of a body": (
        scene(assets={"a": {**BOX, "moving": ["j"]}, "b": BOX}),
        "a body has no joints",
    ),
    "a tolerance that is none": (
        scene(assets={"a": {"package": "x", "tolerance": "much"}, "b": BOX}),
        "write for example",
    ),
    "a unit that is none": (scene(limit="1in"), "write a number in mm, cm or m"),
    "yes for a length": (scene(limit=True), "write a length"),
    "a thing and a part of it": (
        scene(between=["a", "a/body"]),
        "'between' names 'a' and a part of it",
    ),
    "gravity that drives and is off": (
        scene(
            question="settle",
            between=None,
            limit=1,
            assets={"a": {**BOX, "base": "free", "mass": 1}},
            drive={"gravity": 9.81},
            effects={"gravity": "off"},
        ),
        "'drive.gravity' drives the scene and 'effects' says gravity: off",
    ),
    "not a number": (scene(limit=float("nan")), "limit"),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_scenes_are_refused_and_name_the_alternatives(case):
    values, told = WRONG[case]
    with pytest.raises(ConfigError, match=told):
        parse_scene(values)


def test_a_wrong_file_is_located(tmp_path):
    path = tmp_path / "mine.yaml"
    text = Path(CONFIGS / "scenes" / "tower_settles.yaml").read_text(encoding="utf-8")
    path.write_text(text.replace("gravity: 9.81", "gravty: 9.81"), encoding="utf-8")
    with pytest.raises(
        ConfigError, match=r"drive\.gravty.*did you mean 'drive\.gravity'"
    ) as caught:
        load_scene(path)
    line = 1 + text[: text.index("gravity: 9.81")].count("\n")
    assert caught.value.location.line == line


def test_unknown_scene_names_the_shipped_ones():
    with pytest.raises(ConfigError, match="did you mean 'tower_settles'"):
        load_scene("tower_setles")
