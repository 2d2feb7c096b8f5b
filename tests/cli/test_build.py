"""``assetpipe build`` from the outside, on a tiny package."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import trimesh

from assetpipe.robot import MeshShape, read_robot

Cli = Callable[..., subprocess.CompletedProcess[str]]
Workshop = tuple[Cli, Path, Path]
COLLISION = re.compile(rb"<collision.*?</collision>", re.DOTALL)


def tree(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def the(folder: Path, pattern: str) -> Path:
    found = list(folder.rglob(pattern))
    assert len(found) == 1, found
    return found[0]


@pytest.fixture
def built(once: Path) -> Path:
    return once / "out"


@pytest.fixture
def source(once: Path) -> Path:
    return once / "tiny/urdf/tiny.urdf"


def test_urdf_differs_in_collision_elements_only(built: Path, source: Path) -> None:
    before, after = source.read_bytes(), the(built, "tiny.urdf").read_bytes()
    assert before != after
    assert re.sub(rb"\s+", b"", COLLISION.sub(b"", before)) == re.sub(
        rb"\s+", b"", COLLISION.sub(b"", after)
    )
    for kept in (b"<!-- odd spacing stays -->", b"<link   name='arm'>", b"<gazebo reference="):
        assert kept in after


def test_every_reference_resolves_inside_the_output_and_no_element_is_lost(built: Path) -> None:
    robot = read_robot(the(built, "tiny.urdf")).robot
    counts = {link.name: len(link.collisions) for link in robot.links}
    assert counts == {"base": 1, "arm": 4, "tip": 2}
    for reference in robot.references:
        assert reference.uri.startswith("package://tiny/")
        assert reference.resolution.path is not None
        assert reference.resolution.path.is_relative_to(built)


def test_hulls_are_convex_and_cover_the_solid(built: Path, source: Path) -> None:
    original = read_robot(source).robot.link("arm").collisions
    hulls = read_robot(the(built, "tiny.urdf")).robot.link("arm").collisions
    for old, pieces in zip(original, (hulls[:2], hulls[2:]), strict=True):
        assert isinstance(old.shape, MeshShape)
        solid = trimesh.load_mesh(old.shape.path)
        solid.vertices = solid.vertices * old.shape.scale
        if np.prod(old.shape.scale) < 0:
            solid.invert()
        samples = trimesh.sample.sample_surface(solid, 500, seed=0)[0]
        inside = np.zeros(len(samples), dtype=bool)
        for piece in pieces:
            np.testing.assert_allclose(piece.link_from_shape, old.link_from_shape)
            assert isinstance(piece.shape, MeshShape)
            assert piece.shape.scale == (1.0, 1.0, 1.0)
            hull = trimesh.load_mesh(piece.shape.path)
            assert hull.is_watertight
            assert hull.is_convex
            assert hull.volume > 0
            inside |= (
                np.max(
                    hull.face_normals @ samples.T
                    - np.einsum("ij,ij->i", hull.face_normals, hull.triangles[:, 0])[:, None],
                    axis=0,
                )
                < 1e-6
            )
        assert inside.all()


def test_shared_meshes_share_their_hulls(built: Path) -> None:
    robot = read_robot(the(built, "tiny.urdf")).robot

    def files(link: str, start: int) -> list[str]:
        shapes = [c.shape for c in robot.link(link).collisions[start : start + 2]]
        return [shape.uri for shape in shapes if isinstance(shape, MeshShape)]

    assert files("arm", 0) == files("tip", 0)
    assert files("arm", 0) != files("arm", 2)  # mirrored
    assert len(list(built.rglob("*_hull_*.obj"))) == 4


def test_report_and_provenance_hold_no_times_and_no_folders(built: Path, once: Path) -> None:
    for name in ("report.json", "assetpipe.json"):
        text = (built / name).read_text()
        assert str(once) not in text
        assert not re.search(r'"(time|date|seconds_taken)"', text)
    report = json.loads((built / "report.json").read_text())
    robot = report["robots"][0]
    assert robot["urdf"] == str(the(built, "tiny.urdf").relative_to(built))
    assert [e["treatment"] for e in robot["links"]["base"]] == ["primitive"]
    mesh = robot["meshes"][0]
    assert mesh["hulls"] == 2
    assert mesh["certificate"]["thickening"]["upper"] <= mesh["tolerance"]
    assert mesh["contact"]["holds"] is True
    assert robot["validation"]["engine"]["outcome"] == "loaded"
    assert sum(robot["validation"]["engine"]["shapes"].values()) == 7
    assert robot["validation"]["self_collision"]["new"] == []
    provenance = json.loads((built / "assetpipe.json").read_text())
    assert set(provenance["outputs"]) | {"assetpipe.json"} == set(tree(built))


def test_same_bytes_with_any_jobs_place_and_cache(
    cli: Cli, built: Path, package: Path, tmp_path: Path
) -> None:
    moved = tmp_path / "else where" / "tiny"
    moved.parent.mkdir()
    package.parents[1].rename(moved)
    for number, changes in enumerate((["--jobs", 1], ["--jobs", 3])):
        out = tmp_path / f"again{number}" / "o"
        done = cli("build", moved / "urdf/tiny.urdf", "-o", out, "--no-cache", *changes)
        assert done.returncode == 0, done.stderr
        assert tree(out) == tree(built)


def test_unchanged_second_run_computes_nothing_and_touches_nothing(
    workshop: Workshop, tmp_path: Path
) -> None:
    cli, package, built = workshop
    before = built.stat().st_ino
    done = cli("build", package, "-o", built)
    assert done.returncode == 0
    assert "cached" in done.stdout
    assert built.stat().st_ino == before
    other = tmp_path / "other"
    cli("build", package, "-o", other)
    assert tree(other) == tree(built)


def test_damaged_cache_is_computed_anew(workshop: Workshop, tmp_path: Path) -> None:
    cli, package, built = workshop
    for path in (tmp_path / "cache").rglob("*"):
        if path.is_file():
            data = bytearray(path.read_bytes())
            data[len(data) // 2] ^= 255
            path.write_bytes(bytes(data))
    done = cli("build", package, "-o", tmp_path / "other")
    assert done.returncode == 0
    assert tree(tmp_path / "other") == tree(built)


def test_changed_mesh_is_noticed(workshop: Workshop) -> None:
    cli, package, built = workshop
    mesh = package.parents[1] / "meshes/bracket.stl"
    mesh.write_text(mesh.read_text().replace("0.04", "0.05"))
    done = cli("build", package, "-o", built)
    assert done.returncode == 0, done.stdout
    hull = trimesh.load_mesh(sorted(built.rglob("*_hull_000.obj"))[0])
    assert np.isclose(np.sort(np.unique(hull.vertices.round(6)))[-2:].min(), 0.05) or (
        0.05 in hull.vertices.round(6)
    )


def test_what_cannot_be_built_is_a_located_finding_and_the_rest_goes_on(
    cli: Cli, package: Path, tmp_path: Path
) -> None:
    text = package.read_text().replace(
        'filename="package://tiny/meshes/bracket.stl"/></geometry></collision>',
        'filename="package://tiny/meshes/brakcet.stl"/></geometry></collision>',
    )
    package.write_text(text)
    broken = text.splitlines().index(next(x for x in text.splitlines() if "brakcet" in x)) + 1
    done = cli("build", package, "-o", "out", "--json", "r.json", "--sarif", "r.sarif",
               "--junit", "r.xml")  # fmt: skip
    assert done.returncode == 1
    assert f"tiny.urdf:{broken}:" in done.stdout
    findings = json.loads((tmp_path / "r.json").read_text())["findings"]
    errors = [f for f in findings if f["severity"] == "error"]
    assert (errors[0]["code"], errors[0]["line"], errors[0]["link"]) == ("AP101", broken, "tip")
    assert {f["code"] for f in errors} <= {"AP101", "AP406"}  # Bullet minds it, too
    log = json.loads((tmp_path / "r.sarif").read_text())["runs"][0]["results"]
    place = next(r for r in log if r["level"] == "error")["locations"][0]["physicalLocation"]
    assert place["region"]["startLine"] == broken
    assert place["artifactLocation"]["uri"] == "tiny/urdf/tiny.urdf"
    assert '<failure type="AP101"' in (tmp_path / "r.xml").read_text()
    after = the(tmp_path / "out", "tiny.urdf").read_text()
    assert "brakcet.stl" in after
    assert after.count("_hull_") == 4


def test_json_alone_goes_to_stdout_and_spares_the_input(cli: Cli, package: Path) -> None:
    before = package.read_bytes()
    done = cli("build", "-o", "out", "--no-validate", "--json", package)
    assert done.returncode == 0
    assert json.loads(done.stdout)["robots"][0]["name"] == "tiny"
    assert package.read_bytes() == before


def test_output_of_others_is_refused(cli: Cli, package: Path, tmp_path: Path) -> None:
    (tmp_path / "thesis").mkdir()
    (tmp_path / "thesis/text.tex").write_text("precious")
    done = cli("build", package, "-o", "thesis")
    assert done.returncode == 2
    assert "not written by assetpipe" in done.stderr
    assert tree(tmp_path / "thesis") == {"text.tex": b"precious"}


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_interrupted_run_leaves_the_old_output(
    workshop: Workshop, tmp_path: Path, number: int
) -> None:
    _cli, package, built = workshop
    before = tree(built)
    root = Path(__file__).resolve().parents[2]
    process = subprocess.Popen(
        [sys.executable, "-m", "assetpipe", "build", package, "-o", built, "--no-cache",
         "--tolerance", "0.1mm"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(root)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )  # fmt: skip
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    until = time.monotonic() + 60
    while process.poll() is None and time.monotonic() < until:
        if not children.exists() or children.read_text().strip():
            break
        time.sleep(0.01)
    process.send_signal(number)
    _, said = process.communicate(timeout=60)
    assert process.returncode == {signal.SIGINT: 130, signal.SIGTERM: 143}[number]
    assert "Traceback" not in said
    assert tree(built) == before
    assert [p.name for p in tmp_path.iterdir() if "stage" in p.name] == []


def test_check_says_whether_the_output_is_up_to_date(workshop: Workshop, tmp_path: Path) -> None:
    cli, package, built = workshop
    before = tree(tmp_path / "out")
    assert cli("build", package, "-o", built, "--check").returncode == 0
    late = cli("build", package, "-o", built, "--check", "--max-hulls", 1)
    assert late.returncode == 1
    assert "AP601" in late.stdout
    assert tree(built) == before
    missing = cli("build", package, "-o", "nowhere", "--check")
    assert missing.returncode == 1
    assert not (tmp_path / "nowhere").exists()


def test_folder_and_shards_build_every_robot_once(cli: Cli, package: Path, tmp_path: Path) -> None:
    text = package.read_text()
    (package.parent / "second.urdf").write_text(text.replace('name="tiny"', 'name="second"'))
    root = package.parents[1]
    whole = cli("build", root, "-o", "whole", "--no-validate")
    assert whole.returncode == 0, whole.stderr
    for part in ("1/2", "2/2"):
        assert cli("build", root, "-o", "parts", "--no-validate", "--shard", part).returncode == 0
    assert tree(tmp_path / "parts") == tree(tmp_path / "whole")
    assert sorted(p.name for p in (tmp_path / "whole").iterdir()) == ["second", "tiny"]


def test_visual_source_replaces_collisions_by_hulls_of_what_one_sees(
    cli: Cli, package: Path, tmp_path: Path
) -> None:
    done = cli("build", package, "-o", "out", "--source", "visual")
    assert done.returncode == 0, done.stdout + done.stderr
    robot = read_robot(the(tmp_path / "out", "tiny.urdf")).robot
    base = robot.link("base").collisions
    assert [type(c.shape) for c in base] == [MeshShape, MeshShape]
    assert len(robot.link("base").visuals) == 1
    assert len(robot.link("arm").collisions) == 2  # nothing to see: as it was


def test_mesh_input_gives_hulls_and_report(cli: Cli, package: Path, tmp_path: Path) -> None:
    mesh = package.parents[1] / "meshes/bracket.stl"
    done = cli("decompose", mesh, "-o", "hulls", "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["robots"][0]["meshes"][0]["hulls"] == 2
    assert set(tree(tmp_path / "hulls")) == {
        "assetpipe.json", "bracket_hull_000.obj", "bracket_hull_001.obj", "report.json"
    }  # fmt: skip


def test_other_engines_run_through_the_same_pipeline(cli: Cli, package: Path) -> None:
    done = cli("build", package, "-o", "out", "--engine", "hull", "--json")
    assert done.returncode == 1
    codes = {f["code"] for f in json.loads(done.stdout)["findings"]}
    assert "AP302" in codes  # one hull of an L is far too thick


def test_limits_keep_the_old_geometry(cli: Cli, package: Path, tmp_path: Path) -> None:
    (tmp_path / "c.yaml").write_text("limits:\n  faces: 5\n")
    done = cli("build", package, "-o", "out", "--config", "c.yaml", "--json")
    assert done.returncode == 1
    assert {f["code"] for f in json.loads(done.stdout)["findings"]} == {"AP206"}
    before, after = package.read_bytes(), the(tmp_path / "out", "tiny.urdf").read_bytes()
    assert before == after


def test_inspect_tells_the_health_of_every_mesh(cli: Cli, package: Path) -> None:
    table = cli("inspect", package)
    assert table.returncode == 0
    assert "bracket.stl" in table.stdout
    done = cli("inspect", package, "--json")
    meshes = json.loads(done.stdout)["meshes"]
    assert [m["scale"] for m in meshes] == [[1, 1, 1], [1, -1, 1]]
    assert all(m["repair"]["solid"] for m in meshes)


def test_check_writes_nothing_and_finds_edited_files(workshop: Workshop, tmp_path: Path) -> None:
    cli, package, built = workshop
    before = tree(package.parents[1])
    assert cli("check", package).returncode == 0
    assert tree(package.parents[1]) == before
    hull = sorted(built.rglob("*_hull_000.obj"))[0]
    hull.write_text(hull.read_text() + "# edited\n")
    done = cli("check", built, "--json")
    assert done.returncode == 1
    assert [f["code"] for f in json.loads(done.stdout)["findings"]] == ["AP602"]


def test_report_shows_a_stored_one_again(workshop: Workshop, tmp_path: Path) -> None:
    cli, _package, built = workshop
    done = cli("report", built, "--sarif", "again.sarif")
    assert done.returncode == 0
    assert "bracket.stl" in done.stdout
    assert (tmp_path / "again.sarif").exists()


def test_an_original_that_the_engine_does_not_load_is_not_the_builds_fault(
    cli: Cli, package: Path
) -> None:
    text = package.read_text().replace(
        '<link name="tip">', '<link name="tip"><inertial><origin xyz="0 0 0"/></inertial>'
    )
    package.write_text(text)
    cli("build", package, "-o", "out", "--json", "told.json")
    told = json.loads((package.parents[2] / "told.json").read_text())["findings"]
    refused = [finding for finding in told if finding["code"] == "AP406"]
    assert [finding["severity"] for finding in refused] == ["warning"]
    assert "neither the original nor the result" in refused[0]["message"]
