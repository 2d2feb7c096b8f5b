from types import SimpleNamespace

import numpy as np
import pytest
import trimesh

from assetpipe.errors import InputError, UsageError
from assetpipe.validation.dynamics import available_engines, load_in_engine, process
from assetpipe.validation.dynamics import load as load_module

ENGINES = available_engines()
INERTIAL = (
    '<inertial><origin xyz="0.3 0.1 0.2" rpy="0.3 0.2 0.1"/><mass value="2"/>'
    '<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>'
)

pytestmark = pytest.mark.skipif(not ENGINES, reason="no physics engine is installed")


@pytest.fixture(params=ENGINES)
def engine(request):
    return request.param


def two_links(folder, visual=""):
    """A package of two links with three and two hulls; the base's inertia is off centre."""
    rng = np.random.default_rng(1)
    folder.joinpath("meshes").mkdir()
    hulls, elements = {}, {}
    for link, count in (("base", 3), ("arm", 2)):
        hulls[link], elements[link] = [], ""
        for number in range(count):
            points = rng.normal(size=(30, 3)) * 0.05 + rng.uniform(-0.2, 0.2, 3)
            mesh = trimesh.convex.convex_hull(points)
            name = f"meshes/{link}_{number}.obj"
            mesh.export(folder / name, digits=17)
            hulls[link].append(
                SimpleNamespace(vertices=np.asarray(mesh.vertices), faces=np.asarray(mesh.faces))
            )
            elements[link] += (
                f'<collision><geometry><mesh filename="package://pack/{name}"/>'
                "</geometry></collision>"
            )
    text = f"""<?xml version="1.0"?>
<robot name="two">
  <link name="base">{INERTIAL}{visual}{elements["base"]}</link>
  <link name="mid"/>
  <link name="arm">{INERTIAL}{elements["arm"]}</link>
  <joint name="weld" type="fixed"><parent link="base"/><child link="mid"/>
    <origin xyz="0 0.4 0.1" rpy="1 0 0"/></joint>
  <joint name="turn" type="revolute"><parent link="mid"/><child link="arm"/>
    <origin xyz="0 0 0.6" rpy="0 0.5 0"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>
"""
    urdf = folder / "two.urdf"
    urdf.write_text(text, encoding="utf-8")
    resolved = {f"package://pack/{p}": folder / p for p in _meshes(folder)}
    return urdf, hulls, resolved


def _meshes(folder):
    return [f"meshes/{p.name}" for p in sorted((folder / "meshes").iterdir())]


EXPECTED = {"base": 3, "mid": 0, "arm": 2}


def test_loads_counts_and_agrees(engine, tmp_path):
    urdf, hulls, resolved = two_links(tmp_path)
    seen = load_in_engine(urdf, EXPECTED, hulls=hulls, resolved=resolved, engine=engine)
    assert seen.outcome == "loaded"
    assert seen.shapes == EXPECTED
    assert seen.disagreements.of == 8
    assert seen.disagreements.count == 0
    assert abs(seen.distance_error.worst) <= seen.margin + 1e-4
    assert seen.findings() == ()


def test_a_lost_shape_is_found(engine, tmp_path):
    urdf, _, resolved = two_links(tmp_path)
    seen = load_in_engine(urdf, {**EXPECTED, "arm": 3}, resolved=resolved, engine=engine)
    assert seen.miscounted == {"arm": (3, 2)}
    assert [(f.code, f.link) for f in seen.findings()] == [("AP407", "arm")]


def test_hulls_that_are_not_what_was_written_disagree(engine, tmp_path):
    urdf, hulls, resolved = two_links(tmp_path)
    shifted = {
        link: [SimpleNamespace(vertices=h.vertices + 0.05, faces=h.faces) for h in shapes]
        for link, shapes in hulls.items()
    }
    seen = load_in_engine(urdf, EXPECTED, hulls=shifted, resolved=resolved, engine=engine)
    assert "AP408" in [f.code for f in seen.findings()]


def test_a_rewritten_file_is_read_again(engine, tmp_path):
    # PyBullet caches a URDF by its path for as long as a process lives.
    urdf, _, resolved = two_links(tmp_path)
    load_in_engine(urdf, EXPECTED, resolved=resolved, engine=engine)
    text = urdf.read_text(encoding="utf-8")
    first, last = text.rindex("<collision>"), text.rindex("</collision>") + len("</collision>")
    urdf.write_text(text[:first] + text[last:], encoding="utf-8")
    again = load_in_engine(urdf, EXPECTED, resolved=resolved, engine=engine)
    assert again.shapes["arm"] == 1


def test_visuals_that_the_engine_refuses_are_told_apart(tmp_path):
    if "bullet" not in ENGINES:
        pytest.skip("PyBullet has no wheel for this Python")
    visual = '<visual><geometry><mesh filename="package://pack/meshes/x.glb"/></geometry></visual>'
    urdf, _, resolved = two_links(tmp_path, visual)
    seen = load_in_engine(urdf, EXPECTED, resolved=resolved, engine="bullet")
    assert seen.outcome == "loaded"
    assert seen.without_visuals
    assert [(f.code, f.severity.value) for f in seen.findings()] == [("AP406", "note")]
    assert "glb" in seen.message
    assert "\n" not in seen.message


def test_a_missing_mesh_is_a_refusal(engine, tmp_path):
    urdf, _, resolved = two_links(tmp_path)
    resolved = dict(resolved)
    gone = sorted(resolved)[0]
    resolved[gone].unlink()
    seen = load_in_engine(urdf, EXPECTED, resolved=resolved, engine=engine)
    codes = {f.code for f in seen.findings()}
    assert codes & {"AP406", "AP407"}


def test_a_crash_is_a_finding(engine, tmp_path, monkeypatch):
    urdf, _, _ = two_links(tmp_path)
    crashed = process.WorkerAnswer("crashed", {}, "assertion failed", "SIGSEGV")
    monkeypatch.setattr(load_module, "run_worker", lambda *a, **k: crashed)
    seen = load_in_engine(urdf, EXPECTED, engine=engine)
    assert seen.outcome == "crashed"
    assert [f.code for f in seen.findings()] == ["AP409"]
    assert "SIGSEGV" in seen.findings()[0].message


def test_a_worker_that_dies_by_a_signal_is_a_crash(engine, monkeypatch, tmp_path):
    dying = tmp_path / "dying"
    dying.write_text("#!/bin/sh\nkill -SEGV $$\n", encoding="utf-8")
    dying.chmod(0o755)
    monkeypatch.setattr(process.sys, "executable", str(dying))
    answer = process.run_worker(engine, {}, timeout=10.0)
    assert (answer.outcome, answer.signal) == ("crashed", "SIGSEGV")


def test_a_worker_that_hangs_is_ended(engine, monkeypatch, tmp_path):
    slow = tmp_path / "slow"
    slow.write_text("#!/bin/sh\nexec sleep 30\n", encoding="utf-8")
    slow.chmod(0o755)
    monkeypatch.setattr(process.sys, "executable", str(slow))
    answer = process.run_worker(engine, {}, timeout=0.2)
    assert answer.outcome == "timed out"


def test_no_engine_is_a_note_and_not_a_pass(tmp_path, monkeypatch):
    urdf, _, _ = two_links(tmp_path)
    monkeypatch.setattr(process, "available_engines", lambda: ())
    seen = load_in_engine(urdf, EXPECTED)
    assert seen.outcome == "not available"
    assert [(f.code, f.severity.value) for f in seen.findings()] == [("AP411", "note")]


def test_wrong_calls(tmp_path):
    with pytest.raises(InputError, match="does not exist"):
        load_in_engine(tmp_path / "none.urdf", {})
    urdf, _, _ = two_links(tmp_path)
    with pytest.raises(UsageError, match="bullit"):
        load_in_engine(urdf, {}, engine="bullit")
    broken = tmp_path / "broken.urdf"
    broken.write_text("<robot name='x'><link name='a'></robot>", encoding="utf-8")
    with pytest.raises(InputError, match="well-formed"):
        load_in_engine(broken, {}, resolved={"a": tmp_path})


def test_entities_are_refused(tmp_path):
    secret = tmp_path / "secret.txt"
    secret.write_text("very secret", encoding="utf-8")
    urdf = tmp_path / "entity.urdf"
    urdf.write_text(
        f'<!DOCTYPE robot [<!ENTITY e SYSTEM "file://{secret}">]>'
        '<robot name="x"><link name="a">&e;</link></robot>',
        encoding="utf-8",
    )
    with pytest.raises(InputError, match=r"entity\.urdf:1: .*entities"):
        load_in_engine(urdf, {"a": 0}, resolved={"none": secret})


def test_markup_that_engines_read_over_does_not_end_the_check(engine, tmp_path):
    urdf, hulls, resolved = two_links(tmp_path)
    text = urdf.read_text(encoding="utf-8").replace('version="1.0"', 'version="0.0"')
    urdf.write_text("\n" + text + "after the end", encoding="utf-8")
    seen = load_in_engine(urdf, EXPECTED, hulls=hulls, resolved=resolved, engine=engine)
    assert seen.outcome == "loaded"
    assert seen.disagreements.count == 0


def test_words_of_the_engine_do_not_name_folders_of_the_machine(engine, tmp_path):
    urdf, _, resolved = two_links(tmp_path)
    (tmp_path / "meshes" / "arm_0.obj").unlink()
    seen = load_in_engine(urdf, EXPECTED, resolved=resolved, engine=engine)
    assert seen.outcome == "refused"
    assert "arm_0.obj" in seen.message
    assert str(tmp_path) not in seen.message


def test_a_circle_of_links_does_not_end_the_check(engine, tmp_path):
    urdf, _, _ = two_links(tmp_path)
    (tmp_path / "circle.obj").symlink_to("circle.obj")
    text = urdf.read_text(encoding="utf-8").replace("package://pack/meshes/arm_0.obj", "circle.obj")
    urdf.write_text(text, encoding="utf-8")
    seen = load_in_engine(urdf, EXPECTED, resolved={"none": tmp_path}, engine=engine)
    assert seen.outcome == "refused"


def test_lines_of_the_copy_are_no_longer_than_an_engine_reads(tmp_path):
    deep = tmp_path / ("a" * 200)
    deep.mkdir()
    mesh = '<collision><geometry><mesh filename="m.obj"/></geometry></collision>'
    urdf, copy = tmp_path / "a.urdf", tmp_path / "b.urdf"
    urdf.write_text(f'<robot name="r"><link name="l">{mesh * 100}</link></robot>')
    load_module.rewrite(urdf, copy, {"m.obj": deep / "m.obj"}, "kept")
    written = copy.read_text()
    assert written.count(str(deep)) == 100
    assert max(map(len, written.splitlines())) <= 8190
    # A file that has longer lines of its own keeps them, for the engine to say so.
    urdf.write_text(f'<robot name="r"><link name="l">{mesh * 200}</link></robot>')
    load_module.rewrite(urdf, copy, {}, "kept")
    assert len(copy.read_text().splitlines()) == 1
