"""References to files: every way to find one, and none out of the packages."""

from pathlib import Path

import pytest

from assetpipe.errors import Location
from assetpipe.findings import Severity
from assetpipe.robot import Resolution, Resolver


def touch(path: Path) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("x")
    return path


def manifest(folder: Path, name: str) -> None:
    touch(folder / "package.xml").write_text(
        f'<?xml version="1.0"?><?x y?><package format="3"><name> {name} </name></package>'
    )


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """A package ``arm`` in a folder of another name, in a workspace."""
    root = tmp_path / "ws" / "src" / "arm_folder"
    manifest(root, "arm")
    touch(root / "meshes" / "a.stl")
    touch(root / "urdf" / "local.stl")
    touch(root / "urdf" / "arm.urdf")
    return root


def resolve(package: Path, uri: str, resolver: Resolver | None = None) -> Resolution:
    return (resolver or Resolver()).beside(package / "urdf" / "arm.urdf").resolve(uri)


@pytest.mark.parametrize(
    ("uri", "file", "means"),
    [
        ("package://arm/meshes/a.stl", "meshes/a.stl", "package.xml"),
        ("PACKAGE://arm//meshes/./a.stl", "meshes/a.stl", "package.xml"),
        ("package://arm/urdf/../meshes/a.stl", "meshes/a.stl", "package.xml"),
        ("model://arm/meshes/a.stl", "meshes/a.stl", "package.xml"),
        ("$(find arm)/meshes/a.stl", "meshes/a.stl", "package.xml"),
        ("file://$(find arm)/meshes/a.stl", "meshes/a.stl", "package.xml"),
        ("package://arm_folder/meshes/a.stl", "meshes/a.stl", "folder name"),
        ("package://meshes/a.stl", "meshes/a.stl", "folder name"),
        ("package://unknown/meshes/a.stl", "meshes/a.stl", "walk up"),
        ("package:///arm/meshes/a.stl", "meshes/a.stl", "package.xml"),
        ("package:///local.stl", "urdf/local.stl", "relative"),
        ("../meshes/a.stl", "meshes/a.stl", "relative"),
        ("..\\meshes\\a.stl", "meshes/a.stl", "relative"),
        (" ./local.stl ", "urdf/local.stl", "relative"),
        ("meshes/a.stl", "meshes/a.stl", "relative, upwards"),
        ("file://../meshes/a.stl", "meshes/a.stl", "relative"),
        ("file:local.stl", "urdf/local.stl", "relative"),
    ],
)
def test_ways_to_find_a_file(package: Path, uri: str, file: str, means: str) -> None:
    found = resolve(package, uri)
    assert (found.state, found.path, found.means) == ("found", package / file, means)
    assert found.uri == uri


def test_percent_encoding(package: Path) -> None:
    spaced = touch(package / "meshes" / "a b.stl")
    percent = touch(package / "meshes" / "a%20c.stl")
    assert resolve(package, "package://arm/meshes/a%20b.stl").path == spaced
    assert resolve(package, f"file://{package}/meshes/a%20b.stl").path == spaced
    assert resolve(package, f"file://localhost{package}/meshes/a%20b.stl").path == spaced
    # what is there literally wins
    assert resolve(package, "package://arm/meshes/a%20c.stl").path == percent


def test_neighbours_in_the_workspace(package: Path) -> None:
    workspace = package.parent
    manifest(workspace / "repository" / "gripper", "grip")
    mesh = touch(workspace / "repository" / "gripper" / "g.stl")
    found = resolve(package, "package://grip/g.stl")
    assert (found.path, found.means) == (mesh, "package.xml")
    # a neighbour may be reached by a relative path too
    assert resolve(package, "../../repository/gripper/g.stl").path == mesh


def test_mapping_comes_first(package: Path, tmp_path: Path) -> None:
    mesh = touch(tmp_path / "elsewhere" / "meshes" / "a.stl")
    resolver = Resolver(packages={"arm": tmp_path / "elsewhere"})
    found = resolve(package, "package://arm/meshes/a.stl", resolver)
    assert (found.path, found.means) == (mesh, "mapping")


def test_environment(package: Path, tmp_path: Path) -> None:
    manifest(tmp_path / "ros" / "stack" / "one", "one")
    one = touch(tmp_path / "ros" / "stack" / "one" / "m.stl")
    two = touch(tmp_path / "install" / "share" / "two" / "m.stl")
    three = touch(tmp_path / "models" / "three" / "m.dae")
    resolver = Resolver.from_environment(
        {
            "ROS_PACKAGE_PATH": f"{tmp_path / 'none'}:{tmp_path / 'ros'}",
            "AMENT_PREFIX_PATH": str(tmp_path / "install"),
            "GAZEBO_MODEL_PATH": str(tmp_path / "models"),
        }
    )
    found = [
        resolve(package, uri, resolver)
        for uri in ("package://one/m.stl", "package://two/m.stl", "model://three/m.dae")
    ]
    assert [f.path for f in found] == [one, two, three]
    assert [f.means for f in found] == ["ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH", "model path"]
    assert resolve(package, "package://one/m.stl").state == "missing"


def test_symlinks_of_a_colcon_workspace_are_its_own(package: Path, tmp_path: Path) -> None:
    workspace = tmp_path / "colcon"
    real = touch(workspace / "src" / "two" / "m.stl")
    prefix = workspace / "install" / "two"
    (prefix / "share" / "two").mkdir(parents=True)
    (prefix / "share" / "two" / "m.stl").symlink_to(real)
    resolver = Resolver.from_environment({"AMENT_PREFIX_PATH": str(prefix)})
    assert resolve(package, "package://two/m.stl", resolver).state == "outside"
    touch(workspace / "install" / ".colcon_install_layout")
    assert resolve(package, "package://two/m.stl", resolver).state == "found"


def test_settings_survive_the_way_to_another_process(tmp_path: Path) -> None:
    resolver = Resolver(packages={"a": tmp_path}, allow_roots=(tmp_path,), outside="read")
    assert Resolver.from_settings(resolver.settings()) == resolver


@pytest.fixture
def secret(tmp_path: Path) -> Path:
    return touch(tmp_path / "secret.stl")


@pytest.mark.parametrize(
    "uri",
    [
        "package://arm/../../../secret.stl",
        "package://arm/%2e%2e/%2e%2e/%2e%2e/secret.stl",
        "package://meshes/../../../../secret.stl",
        "package://unknown/../../../../secret.stl",
        "package://../secret.stl",
        "model://arm/../../../secret.stl",
        "../../../../secret.stl",
        "..\\..\\..\\..\\secret.stl",
        "file://{tmp}/secret.stl",
        "file:///{tmp}/ws/../secret.stl",
        "{tmp}/secret.stl",
        "link.stl",
        "package://arm/urdf/link.stl",
        "linked/secret.stl",
        "/etc/passwd",
    ],
)
def test_nothing_leads_out_of_the_package(
    package: Path, secret: Path, tmp_path: Path, uri: str
) -> None:
    (package / "urdf" / "link.stl").symlink_to(secret)
    (package / "urdf" / "linked").symlink_to(tmp_path)
    found = resolve(package, uri.format(tmp=tmp_path))
    assert found.path is None
    assert found.state in ("outside", "missing")
    if uri != "package://../secret.stl":
        assert found.state == "outside"
    finding = found.finding(Location(package), link="a", severity=Severity.ERROR)
    assert finding is not None
    assert finding.code == ("AP103" if found.state == "outside" else "AP101")


def test_the_user_may_allow_more(package: Path, secret: Path, tmp_path: Path) -> None:
    uri = "../../../../secret.stl"
    for resolver in (
        Resolver(outside="read"),
        Resolver(allow_roots=(tmp_path,)),
        Resolver().allowing(tmp_path),
    ):
        assert resolve(package, uri, resolver).path == secret


@pytest.mark.parametrize("uri", ["http://x/y.stl", "https://x/y.stl", "ftp://x/y.stl"])
def test_nothing_is_fetched(package: Path, uri: str) -> None:
    found = resolve(package, uri)
    assert found.state == "unsupported"
    finding = found.finding(Location(package), link=None, severity=Severity.ERROR)
    assert finding is not None
    assert "is not followed" in finding.message


@pytest.mark.parametrize("uri", ["", "  ", "a\0b", "package://", "package://arm", "package://arm/"])
def test_empty_references(package: Path, uri: str) -> None:
    assert resolve(package, uri).state == "missing"


@pytest.mark.parametrize(
    ("uri", "hint"),
    [
        ("package://arm/Meshes/A.STL", "there is '../meshes': only the case differs"),
        ("package://arm/meshes/A.STL", "there is '../meshes/a.stl': only the case differs"),
        ("package://arm/meshes/a.stlx", "there is '../meshes/a.stl': did you mean it?"),
        (
            "package://arn/x.stl",
            "did you mean 'arm'?; add the folder that holds it to ROS_PACKAGE_PATH",
        ),
        ("locals.stl", "there is 'local.stl': did you mean it?"),
    ],
)
def test_hints_name_neighbours(package: Path, uri: str, hint: str) -> None:
    found = resolve(package, uri)
    assert found.state == "missing"
    assert found.hint is not None
    assert hint in found.hint


def test_without_a_package_the_folder_or_the_one_above_a_shelf_is_home(tmp_path: Path) -> None:
    touch(tmp_path / "thing" / "meshes" / "a.stl")
    touch(tmp_path / "thing" / "urdf" / "r.urdf")
    touch(tmp_path / "thing" / "r.urdf")
    outer = touch(tmp_path / "a.stl")
    shelved = Resolver().beside(tmp_path / "thing" / "urdf" / "r.urdf")
    assert shelved.resolve("../meshes/a.stl").state == "found"
    assert shelved.resolve("../../a.stl").state == "outside"
    plain = Resolver().beside(tmp_path / "thing" / "r.urdf")
    assert plain.resolve("../a.stl").state == "outside"
    (tmp_path / ".git").mkdir()
    repository = Resolver().beside(tmp_path / "thing" / "r.urdf")
    assert repository.resolve("../a.stl").path == outer


@pytest.mark.parametrize(
    ("folder", "meshes", "state"),
    [
        ("urdf/chair", "shapes", "found"),
        ("variants/chair", "shapes", "outside"),
        ("variants/chair", "meshes", "found"),
    ],
)
def test_home_holds_the_folders_of_descriptions_and_of_meshes(
    tmp_path: Path, folder: str, meshes: str, state: str
) -> None:
    touch(tmp_path / "things" / meshes / "chair" / "leg.obj")
    beside = Resolver().beside(touch(tmp_path / "things" / folder / "leg.urdf"))
    assert beside.resolve(f"../../{meshes}/chair/leg.obj").state == state
    assert beside.resolve("../../../leg.obj").state == "outside"


def test_a_broken_or_hostile_manifest_is_no_package(package: Path) -> None:
    bomb = '<!DOCTYPE p [<!ENTITY a "arm">]><package><name>&a;</name></package>'
    for text in ("<package><name>arm", bomb, "", "<package/>"):
        (package / "package.xml").write_text(text)
        assert resolve(package, "package://arm/meshes/a.stl").means == "walk up"


@pytest.mark.parametrize(
    "uri",
    [
        "package://arm/a%00b.stl",
        "file:///a%00b.stl",
        "a%00b.stl",
        "a" * 5000 + ".stl",
        f"package://{'a' * 5000}/b.stl",
        "a/" * 50_000 + "b.stl",
        "circle.stl",
        "package://arm/urdf/circle.stl",
    ],
)
def test_what_no_file_can_be_called_is_missing(package: Path, uri: str) -> None:
    (package / "urdf" / "circle.stl").symlink_to("circle.stl")
    found = resolve(package, uri)
    assert found.state == "missing"
    finding = found.finding(Location(package), link=None, severity=Severity.ERROR)
    assert finding is not None
    assert len(finding.message) < 1500


@pytest.mark.parametrize("name", ["..", ".", "/a/b", "../../a", "a\\b", "a\nb", "a" * 300])
def test_what_no_folder_can_be_called_names_no_package(package: Path, name: str) -> None:
    manifest(package, name)
    assert Resolver().beside(package / "urdf" / "arm.urdf").package is None


@pytest.mark.parametrize(
    "uri",
    [
        "$(find {secret})/a.stl",
        "file://$(find {secret})/a.stl",
        "$(find ../../../secret)/a.stl",
        "$(find linked/deep)/b.stl",
        "$(find linked)/a.stl",
        "package://linked/a.stl",
        "model://linked/a.stl",
        "linked/a.stl",
        "package://.hidden/a.stl",
        "$(find .hidden)/a.stl",
    ],
)
def test_neither_paths_for_packages_nor_links_nor_hidden_folders_lead_out(
    package: Path, uri: str
) -> None:
    secret = package.parents[2] / "secret"
    touch(secret / "a.stl")
    touch(secret / "deep" / "b.stl")
    (package / "urdf" / "linked").symlink_to(secret)
    touch(package.parent / ".hidden" / "a.stl")
    assert resolve(package, uri.format(secret=secret)).state in ("missing", "outside")


def test_links_to_packages_are_followed(package: Path) -> None:
    elsewhere = package.parents[2] / "elsewhere" / "repository"
    manifest(elsewhere, "hand")
    touch(elsewhere / "a.stl")
    (package.parent / "hand_link").symlink_to(elsewhere)
    assert resolve(package, "package://hand/a.stl").state == "found"
    assert resolve(package, "package://hand_link/a.stl").state == "found"
