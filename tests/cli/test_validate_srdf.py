"""``validate --srdf-out``: pairs that a planner need not ask."""

import subprocess
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from xml.etree import ElementTree

import pytest

Cli = Callable[..., subprocess.CompletedProcess[str]]

MESH = (
    '<collision><geometry><mesh filename="package://tiny/meshes/bracket.stl"/></geometry>'
    "</collision>"
)
BALL = '<collision><origin xyz="0 0 -1"/><geometry><sphere radius="0.01"/></geometry></collision>'
JOINT = (
    '<joint name="{1}" type="revolute"><parent link="{0}"/><child link="{1}"/>'
    '<origin xyz="1 0 0"/><axis xyz="0 0 1"/>'
    '<limit lower="-0.1" upper="0.1" effort="1" velocity="1"/></joint>'
)
CHAIN = ("base", "arm", "tip", "flag")

SRDF = b"""<?xml version="1.0"?>
<robot name="tiny">
  <group name="all"   />  <!-- stays -->
  <disable_collisions link1="tip" link2="base" reason="User"/>
</robot>
"""


def entries(text: bytes) -> dict[tuple[str, ...], str | None]:
    return {
        tuple(sorted((e.attrib["link1"], e.attrib["link2"]))): e.get("reason")
        for e in ElementTree.fromstring(text).iter("disable_collisions")
    }


@pytest.fixture
def chain(package: Path) -> Path:
    """Four parts in a row, the last with a ball besides its mesh."""
    links = "".join(
        f'<link name="{name}">{MESH}{BALL if name == "flag" else ""}</link>' for name in CHAIN
    )
    joints = "".join(JOINT.format(*pair) for pair in pairwise(CHAIN))
    package.write_text(f'<robot name="tiny">{links}{joints}</robot>')
    return package


def test_pairs_are_written_new_and_into_what_is_there(cli: Cli, chain: Path) -> None:
    folder = chain.parents[2]
    assert cli("build", chain, "-o", "out", "--no-validate").returncode == 0
    (folder / "in.srdf").write_bytes(SRDF)
    done = cli("validate", chain, "out", "--srdf-out", "new/tiny.srdf")
    assert done.returncode == 0, done.stdout + done.stderr
    # Of 'flag' the ball was not asked: that its mesh never touches 'base' is no reason.
    expected = {
        ("arm", "base"): "Adjacent",
        ("arm", "tip"): "Adjacent",
        ("flag", "tip"): "Adjacent",
        ("base", "tip"): "Never",
    }
    assert entries((folder / "new/tiny.srdf").read_bytes()) == expected
    patched = cli("validate", chain, "out", "--srdf", "in.srdf", "--srdf-out", "out.srdf")
    assert patched.returncode == 0, patched.stdout + patched.stderr
    text = (folder / "out.srdf").read_bytes()
    assert entries(text) == {**expected, ("base", "tip"): "User"}
    kept = text.splitlines(keepends=True)
    assert b"".join(kept[:4] + kept[-1:]) == SRDF
    assert (folder / "in.srdf").read_bytes() == SRDF


def test_what_does_not_fit_is_refused_before_anything_runs(cli: Cli, package: Path) -> None:
    bad = package.parents[2] / "bad.srdf"
    bad.write_text("<sdf/>")
    (package.parents[2] / "quiet.yaml").write_text("validation: {checks: [contact]}\n")
    for arguments, words in (
        ((package, package, "--srdf", bad), "--srdf-out"),
        (("--scene", "tower_settles", "--srdf-out", "x.srdf"), "ORIGINAL and BUILT"),
        ((package, package, "--srdf", bad, "--srdf-out", "x.srdf"), "root is 'sdf'"),
        ((package, package, "--srdf", "none", "--srdf-out", "x.srdf"), "cannot be read"),
        ((package, package, "--config", "quiet.yaml", "--srdf-out", "x.srdf"), "self_collision"),
    ):
        done = cli("validate", *arguments)
        assert done.returncode == 2, done.stdout
        assert words in done.stderr
    assert not (package.parents[2] / "x.srdf").exists()
