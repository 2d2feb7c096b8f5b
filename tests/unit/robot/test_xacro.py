"""xacro: expanded like the original, and kept from doing harm."""

import os
from pathlib import Path

import pytest

from assetpipe.errors import InputError, LimitError
from assetpipe.robot import Resolver, Robot, XacroError, find_robots, finding_of, read_robot
from assetpipe.robot import xacro as expansion
from assetpipe.robot.xacro_worker import check_expression

HEAD = '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="r">'


def write(path: Path, body: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f'<?xml version="1.0"?>\n{HEAD}\n{body}\n</robot>')
    return path


def expand(path: Path, body: str, **arguments: str) -> Robot:
    return read_robot(write(path, body), resolver=Resolver(), arguments=arguments).robot


def manifest(folder: Path, name: str) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "package.xml").write_text(f"<package><name>{name}</name></package>")


def test_macros_includes_arguments_yaml_and_packages(tmp_path: Path) -> None:
    package = tmp_path / "arm_folder"
    manifest(package, "arm")
    (package / "meshes").mkdir()
    (package / "meshes" / "a.stl").write_text("x")
    (package / "config.yaml").write_text("size: {x: 0.25, angle: !degrees 180}")
    write(
        package / "urdf" / "parts" / "macro.xacro",
        """<xacro:include filename="more.xacro"/>
        <xacro:macro name="part" params="name *origin">
          <link name="${name}"><collision><xacro:insert_block name="origin"/><geometry>
            <mesh filename="file://$(find arm)/meshes/a.stl"/></geometry></collision>
          <collision><geometry><mesh filename="package://arm/meshes/a.stl"/></geometry></collision>
          </link></xacro:macro>""",
    )
    write(package / "urdf" / "parts" / "more.xacro", '<xacro:property name="k" value="2"/>')
    robot = expand(
        package / "urdf" / "r.urdf.xacro",
        """<xacro:arg name="count" default="1"/>
        <xacro:include filename="$(find arm)/urdf/parts/macro.xacro"/>
        <xacro:property name="y" value="${xacro.load_yaml('../config.yaml')}"/>
        <xacro:property name="fmt" value="${'%.1f' % (k * 1.5)}"/>
        <xacro:if value="${$(arg count) > 1}"><link name="${'l_%d' % len([i for i in range(3)])}"/>
        </xacro:if>
        <xacro:part name="a"><origin xyz="${y['size']['x']} ${fmt} ${k * pi}"/></xacro:part>""",
        count="2",
    )
    assert robot.urdf_name == "r.urdf"
    assert [link.name for link in robot.links] == ["l_3", "a"]
    first = robot.link("a").collisions[0]
    assert first.link_from_shape[:3, 3].tolist() == pytest.approx([0.25, 3.0, 6.283185307])
    # the same on every machine: no folder of this one
    assert str(tmp_path).encode() not in robot.source
    uris = [r.uri for r in robot.references]
    assert uris == ["package://arm/meshes/a.stl"] * 2
    assert all(r.resolution.state == "found" for r in robot.references)
    assert [p.name for p in robot.includes] == ["macro.xacro", "more.xacro", "config.yaml"]


def test_the_same_bytes_every_time(tmp_path: Path) -> None:
    body = '<link name="a"/><xacro:property name="p" value="1"/><link name="${p}"/>'
    first = expand(tmp_path / "one" / "r.xacro", body)
    second = expand(tmp_path / "two" / "r.xacro", body)
    assert first.source == second.source
    assert first.urdf_name == "r.urdf"


def test_an_undeclared_package_stands_for_the_files_own(tmp_path: Path) -> None:
    write(tmp_path / "arm" / "urdf" / "part.xacro", '<link name="a"/>')
    body = '<xacro:include filename="$(find arm_description)/urdf/part.xacro"/>'
    robot = expand(tmp_path / "arm" / "urdf" / "r.xacro", body)
    assert [link.name for link in robot.links] == ["a"]


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ('<link name="${none}"/>', "name 'none' is not defined"),
        ("<xacro:unknown/>", "unknown macro name: xacro:unknown"),
        ('<xacro:arg name="a" default=""/><link name="$(arg b)"/>', "Undefined substitution"),
        ('<xacro:include filename="none.xacro"/>', "No such file"),
        ('<xacro:property name="a" value="${a}"/><link name="${a}"/>', "circular"),
        ('<link name="${1/0}"/>', "division by zero"),
        ('<link name="${1 +}"/>', "invalid syntax"),
    ],
)
def test_errors_say_what_and_where(tmp_path: Path, body: str, message: str) -> None:
    path = tmp_path / "r.urdf.xacro"
    with pytest.raises(XacroError, match=message) as caught:
        expand(path, body)
    assert caught.value.location is not None
    assert finding_of(caught.value).code == "AP108"


def test_a_broken_include_is_located_in_its_own_file(tmp_path: Path) -> None:
    (tmp_path / "part.xacro").write_text("<robot>\n<link></robot>")
    with pytest.raises(InputError, match="not well-formed") as caught:
        expand(tmp_path / "r.xacro", '<xacro:include filename="part.xacro"/>')
    assert caught.value.location is not None
    assert caught.value.location.file == tmp_path / "part.xacro"
    assert caught.value.location.line == 2


def test_a_package_that_is_not_there(tmp_path: Path) -> None:
    manifest(tmp_path, "arm")
    with pytest.raises(XacroError, match="package 'other' not found; add the folder that holds it"):
        expand(tmp_path / "r.xacro", '<xacro:include filename="$(find other)/x.xacro"/>')


ESCAPES = [
    "().__class__",
    "[c for c in ().__class__.__base__.__subclasses__()]",
    "(lambda: ().__class__)()",
    "(i for i in [1]).gi_frame",
    "(lambda: 0).func_globals",
    "'{0.__class__}'.format(1)",
    "'{0[__class__]}'.format({})",
    "('{0._' + '_class__}').format(1)",
    "str.format('{0.__class__}', 1)",
    "'{0.__class__}'.format_map({})",
    "__import__('os')",
    "(lambda __x: 1)(__builtins__)",
    "list.mro",
    "f'{().__class__}'",
]


@pytest.mark.parametrize("expression", ESCAPES)
def test_expressions_that_reach_into_the_interpreter_are_refused(expression: str) -> None:
    with pytest.raises(Exception, match="is refused in"):
        check_expression(expression)


@pytest.mark.parametrize(
    "expression",
    ["a.b.c", " math.sin(pi)", "[x for x in range(3)][0]", "'%s' % name", "python.abs(-1)"],
)
def test_expressions_that_stay_outside_are_not(expression: str) -> None:
    check_expression(expression)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("${(lambda: ().__class__)()}", "'.__class__' is refused"),
        ("${python.vars(python)}", "'vars' is not defined"),
        ("${python.type(1)}", "'type' is not defined"),
        ("${open('/etc/passwd')}", "'open' is not defined"),
        ("$(eval open('/etc/hostname').read())", "is refused: it may run anything"),
    ],
)
def test_refusals_reach_the_user(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(XacroError, match=message):
        expand(tmp_path / "r.xacro", f'<link name="{text}"/>')


def test_secrets_of_the_environment_stay_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TOKEN", "secret")
    with pytest.raises(XacroError, match="environment variable 'TOKEN' is not set"):
        expand(tmp_path / "r.xacro", '<link name="$(env TOKEN)"/>')
    robot = expand(tmp_path / "r.xacro", '<link name="$(optenv TOKEN none)"/>')
    assert robot.links[0].name == "none"


def test_files_outside_of_the_package_are_not_read(tmp_path: Path) -> None:
    write(tmp_path / "secret.xacro", '<link name="secret"/>')
    (tmp_path / "secret.yaml").write_text("key: secret")
    manifest(tmp_path / "arm", "arm")
    (tmp_path / "arm" / "link.xacro").symlink_to(tmp_path / "secret.xacro")
    for body in (
        '<xacro:include filename="../secret.xacro"/>',
        f'<xacro:include filename="{tmp_path}/secret.xacro"/>',
        '<xacro:include filename="../*.xacro"/>',
        '<xacro:include filename="link.xacro"/>',
        '<xacro:include filename="$(find arm)/../secret.xacro"/>',
        "<link name=\"${xacro.load_yaml('../secret.yaml')['key']}\"/>",
        "<link name=\"${load_yaml('../secret.yaml')['key']}\"/>",
    ):
        with pytest.raises(XacroError, match="lies outside of the package: refused"):
            expand(tmp_path / "arm" / "r.xacro", body)
    path = write(tmp_path / "arm" / "r.xacro", '<xacro:include filename="../secret.xacro"/>')
    allowed = read_robot(path, resolver=Resolver(allow_roots=(tmp_path,))).robot
    assert [link.name for link in allowed.links] == ["secret"]


def test_entities_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "r.xacro"
    path.write_text(f'<!DOCTYPE r [<!ENTITY a "b">]>{HEAD}<link name="&a;"/></robot>')
    with pytest.raises(InputError, match="entities may be bombs"):
        read_robot(path, resolver=Resolver())


@pytest.mark.parametrize(
    "body",
    [
        '<xacro:macro name="m"><xacro:m/></xacro:macro><xacro:m/>',
        '<xacro:include filename="r.xacro"/>',
        "<link name=\"${len('a' * 10 ** 11)}\"/>",
    ],
)
def test_growth_without_end_is_stopped(tmp_path: Path, body: str) -> None:
    with pytest.raises((LimitError, XacroError)):
        expand(tmp_path / "r.xacro", body)


@pytest.mark.skipif(os.name == "nt", reason="limits of processes are POSIX")
def test_time_is_limited(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(expansion, "SECONDS", 2.0)
    body = '<link name="${[i for i in range(10 ** 12) if i &lt; 0]}"/>'
    with pytest.raises((LimitError, XacroError), match=r"takes longer|ended with code"):
        expand(tmp_path / "r.xacro", body)


def test_robots_are_found_and_ingredients_are_not(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "plain.urdf").write_text('<robot name="p"/>')
    (tmp_path / "a" / "broken.urdf").write_text("<robot")
    (tmp_path / "a" / "model.urdf").write_text("<sdf/>")
    write(tmp_path / "a" / "plain.urdf.xacro", '<link name="x"/>')
    write(tmp_path / "b.xacro", '<link name="x"/>')
    write(tmp_path / "c" / "calls.urdf.xacro", "<xacro:if value='1'><xacro:arm/></xacro:if>")
    write(tmp_path / "c" / "macros.xacro", '<xacro:macro name="m"><link name="l"/></xacro:macro>')
    write(tmp_path / "c" / "materials.xacro", '<material name="m"/>')
    unnamed = write(tmp_path / "c" / "unnamed.xacro", '<link name="x"/>')
    unnamed.write_text(unnamed.read_text().replace(' name="r"', ""))
    write(tmp_path / ".hidden" / "r.xacro", '<link name="x"/>')
    write(tmp_path / "build" / "r.xacro", '<link name="x"/>')
    found = [str(path.relative_to(tmp_path)) for path in find_robots(tmp_path)]
    assert found == ["a/broken.urdf", "a/plain.urdf", "b.xacro", "c/calls.urdf.xacro"]
    assert find_robots(tmp_path / "b.xacro") == (tmp_path / "b.xacro",)
    with pytest.raises(InputError, match="no such file or folder"):
        find_robots(tmp_path / "none")
