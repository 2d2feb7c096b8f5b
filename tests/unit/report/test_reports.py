import io
import json
import xml.etree.ElementTree as ET
from pathlib import Path

from rich.console import Console

from assetpipe.report.json import to_json
from assetpipe.report.junit import junit
from assetpipe.report.sarif import sarif
from assetpipe.report.terminal import show_build, show_health


def finding(**changes):
    base = {
        "code": "AP201",
        "title": "mesh is not a solid and was repaired",
        "severity": "warning",
        "message": "12 open edges",
        "file": None,
        "line": None,
        "link": None,
        "mesh": None,
        "hint": None,
    }
    return {**base, **changes}


MESH = {
    "name": "package://p/meshes/hand.stl",
    "digest": "d",
    "scale": [1, 1, 1],
    "links": ["hand", "left [red]", "right"],
    "treatment": "decomposed",
    "faces": 1200,
    "tolerance": 0.002,
    "repair": {"rung": "fill", "moved": 0.0005, "solid": True},
    "hulls": 7,
    "hull_vertices": 91,
    "certificate": {"thickening": {"lower": 0.0012, "upper": 0.0019}, "concavity": None},
    "contact": {"clearance_error": {"worst": 0.0018}},
}
ROBOT = {
    "name": "arm [bold]",
    "links": {"hand": [], "base": []},
    "meshes": [MESH, {**MESH, "treatment": "kept", "links": ["base"], "repair": None}],
    "validation": {
        "engine": {"engine": "bullet", "outcome": "loaded", "shapes": {"hand": 7}},
        "self_collision": {"configurations": 65, "new": [], "vanished": []},
    },
    "findings": [finding(link="hand"), finding(link="base", severity="note")],
}


def shown(width: int = 200) -> str:
    stream = io.StringIO()
    record = {"robots": [ROBOT], "findings": ROBOT["findings"]}
    show_build(Console(file=stream, width=width), record, seconds={})
    return stream.getvalue()


def test_table_tells_the_numbers_in_millimetres() -> None:
    text = shown()
    for word in ("hand, left [red] +1", "1200", "fill", "0.5", "7", "91", "1.9", "1.8", "kept"):
        assert word in text
    assert "arm [bold]" in text
    assert "65 configurations: 0 new" in text
    assert "bullet: loaded, 7 collision shapes" in text
    assert "0 errors, 1 warning, 1 note" in text


def test_health_table_shows_what_cannot_be_repaired() -> None:
    stream = io.StringIO()
    show_health(
        Console(file=stream, width=160),
        [
            {
                "name": "p/a.stl",
                "faces": 3,
                "health": {"soundness": "open", "boundary_edges": {"count": 29}},
                "repair": {"solid": False, "rung": None, "moved": 0},
            }
        ],
    )
    for word in ("a.stl", "open", "29", "impossible"):
        assert word in stream.getvalue()


def test_sarif_names_files_below_the_root_relatively(tmp_path: Path) -> None:
    inside, outside = tmp_path / "repo/my robot/a.urdf", tmp_path / "b.urdf"
    log = sarif(
        [
            finding(file=str(inside), line=7, link="hand", severity="error"),
            finding(file=str(outside), code="AP101"),
            finding(severity="note"),
        ],
        root=tmp_path / "repo",
    )
    run = log["runs"][0]
    assert log["version"] == "2.1.0"
    assert [r["level"] for r in run["results"]] == ["error", "warning", "note"]
    first = run["results"][0]["locations"][0]["physicalLocation"]
    assert first["artifactLocation"] == {"uri": "my%20robot/a.urdf", "uriBaseId": "SRCROOT"}
    assert first["region"] == {"startLine": 7}
    second = run["results"][1]["locations"][0]["physicalLocation"]
    assert second["artifactLocation"]["uri"] == outside.resolve().as_uri()
    assert "locations" not in run["results"][2]
    rules = [rule["id"] for rule in run["tool"]["driver"]["rules"]]
    assert all(rules[r["ruleIndex"]] == r["ruleId"] for r in run["results"])


def test_junit_is_xml_with_a_case_a_link_and_survives_strange_names() -> None:
    robot = {
        **ROBOT,
        "links": {"hand": [], "a<b>&\"'\x00": []},
        "findings": [
            finding(link="hand", message="1 < 2 & \x01", file="a.urdf", line=3),
            finding(link="a<b>&\"'\x00", severity="note"),
        ],
    }
    root = ET.fromstring(junit([robot], [finding(code="AP104", severity="error")]).encode())
    first, second = root.findall("testsuite")
    assert (first.get("tests"), first.get("failures")) == ("3", "1")
    failures = [case.find("failure") is not None for case in first.findall("testcase")]
    assert failures == [False, True, False]
    assert "a.urdf:3: AP201: 1 < 2" in (first.find("testcase/failure").text or "")
    assert second.find("testcase/failure") is not None


def test_json_is_sorted_and_ends_with_a_line_feed() -> None:
    assert to_json({"b": 1, "a": "é"}) == '{\n  "a": "é",\n  "b": 1\n}\n'
    assert json.loads(to_json(ROBOT)) == ROBOT
