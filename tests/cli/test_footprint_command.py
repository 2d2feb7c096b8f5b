"""``assetpipe footprint`` and outlines through ``assetpipe decompose``."""

import json

import yaml

from assetpipe.cli.shell import run

URDF = """<robot name="cart"><link name="base"><collision><geometry>
<box size="0.6 0.4 0.2"/></geometry></collision></link></robot>"""


def test_footprint_writes_what_a_costmap_wants(tmp_path, capsys):
    urdf = tmp_path / "cart.urdf"
    urdf.write_text(URDF)
    out = tmp_path / "out"
    assert run(["footprint", str(urdf), "-o", str(out), "--tolerance", "1cm", "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record == json.loads((out / "footprint.json").read_text())
    assert abs(record["area"] - 0.24) < 1e-4
    assert record["links"] == ["base"]
    costmap = yaml.safe_load((out / "footprint.yaml").read_text())
    text = costmap["local_costmap"]["local_costmap"]["ros__parameters"]["footprint"]
    assert all(0.2 <= abs(y) <= 0.21 for _, y in yaml.safe_load(text))
    assert (out / "footprint.svg").read_text().startswith("<svg")


def test_wrong_lengths_and_joints_are_usage_errors(tmp_path, capsys):
    urdf = tmp_path / "cart.urdf"
    urdf.write_text(URDF)
    for extra in (["--tolerance", "1%"], ["--joint", "lift"], ["--joint", "lift=0"]):
        assert run(["footprint", str(urdf), "-o", str(tmp_path / "out"), *extra]) == 2
    assert "joint" in capsys.readouterr().err


def test_decompose_reads_outlines(tmp_path, capsys):
    path = tmp_path / "l.csv"
    path.write_text("0,0\n4,0\n4,1\n1,1\n1,4\n0,4\n")
    out = tmp_path / "out"
    assert run(["decompose", str(path), "-o", str(out), "--tolerance", "1mm", "--json"]) == 0
    (record,) = json.loads(capsys.readouterr().out)["outlines"]
    assert (record["parts"], record["concavity"]) == (2, 0)
    features = json.loads((out / "parts.geojson").read_text())["features"]
    assert len(features) == 2
