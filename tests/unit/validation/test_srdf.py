import numpy as np
import pytest
import trimesh
from lxml import etree

from assetpipe.errors import InputError
from assetpipe.geometry.mesh import Mesh
from assetpipe.validation import LinkBody, self_collisions
from assetpipe.validation.srdf import DisabledPair, disabled_pairs, new_srdf, patch_srdf

PAIRS = (
    DisabledPair(("base", "hand"), "Default"),
    DisabledPair(("base", "link1"), "Adjacent"),
)

SOURCE = b"""<?xml version="1.0"?>
<!-- kept: \xc3\xa4 -->
<robot name="r">
  <group name="arm"   ><chain base_link='base' tip_link="hand"/></group>
  <disable_collisions link1="link1" link2="base" reason="User"/>
  <unknown/>
</robot>
<!-- after the end </robot> -->
"""


def entries(source):
    root = etree.fromstring(source)
    return [
        (e.get("link1"), e.get("link2"), e.get("reason")) for e in root.iter("disable_collisions")
    ]


def test_missing_entries_are_added_and_nothing_is_lost():
    patched = patch_srdf(SOURCE, PAIRS)
    assert entries(patched) == [("link1", "base", "User"), ("base", "hand", "Default")]
    added = b'    <disable_collisions link1="base" link2="hand" reason="Default"/>\n'
    assert added in patched
    assert patched.replace(added, b"") == SOURCE


MOVEIT = b"""<?xml version="1.0" encoding="UTF-8"?>
<!--This does not replace URDF, and is not an extension of URDF.-->
<robot name="panda" xmlns:xacro="http://www.ros.org/wiki/xacro">
    <group name="panda_arm">
        <chain base_link="panda_link0" tip_link="panda_link8" />
    </group>
    <group_state name="ready" group="panda_arm">
        <joint name="panda_joint1" value="0" />
    </group_state>
    <end_effector name="hand" parent_link="panda_link8" group="hand" />
    <virtual_joint name="v" type="fixed" parent_frame="world" child_link="panda_link0" />
    <disable_default_collisions link="panda_hand" />
    <enable_collisions link1="panda_hand" link2="panda_link5" />
    <disable_collisions link1="panda_link0" link2="panda_link1" reason="Adjacent" />
    <link_sphere_approximation link="panda_link0"><sphere center="0 0 0" radius="0.1"/>
    </link_sphere_approximation>
</robot>
"""


def test_an_srdf_as_moveit_writes_it_keeps_all_and_what_was_enabled_stays_enabled():
    pairs = [
        DisabledPair(("panda_hand", "panda_link5"), "Never"),
        DisabledPair(("panda_link0", "panda_link1"), "Adjacent"),
        DisabledPair(("panda_link0", "panda_link2"), "Never"),
    ]
    patched = patch_srdf(MOVEIT, pairs)
    assert entries(patched) == [
        ("panda_link0", "panda_link1", "Adjacent"),
        ("panda_link0", "panda_link2", "Never"),
    ]
    before, after = MOVEIT.splitlines(), patched.splitlines()
    assert [line for line in after if line in before] == before
    assert len(after) == len(before) + 1


def test_a_second_patch_changes_nothing():
    patched = patch_srdf(SOURCE, PAIRS)
    assert patch_srdf(patched, PAIRS) == patched


@pytest.mark.parametrize(
    "source",
    [b'<robot name="r"/>', b'<robot name="r"></robot>', b'<robot name="r">\r\n</robot>\r\n'],
)
def test_empty_ones(source):
    assert len(entries(patch_srdf(source, PAIRS))) == 2


def test_names_are_escaped():
    pair = DisabledPair(('a"<', "b&"), "Always")
    assert entries(new_srdf("r", [pair])) == [('a"<', "b&", "Always")]


@pytest.mark.parametrize(
    ("source", "told"),
    [(b"<robot>", "well-formed"), (b"<urdf/>", "'urdf', not 'robot'"), (b"", "well-formed")],
)
def test_what_is_no_srdf(source, told):
    with pytest.raises(InputError, match=told):
        patch_srdf(source, PAIRS)


def test_reasons_come_from_what_was_seen():
    def box(size):
        return Mesh.of(trimesh.creation.box((size,) * 3))

    def at(x):
        matrix = np.eye(4)
        matrix[0, 3] = x
        return matrix

    before = [LinkBody(n, (box(1),)) for n in ("a", "b", "c", "d")]
    after = [LinkBody("d", (box(2.2),)), *before[:3]]
    configurations = [{"a": at(0), "b": at(0.5), "c": at(9), "d": at(1.55)}] * 1001
    found = self_collisions(before, after, configurations[:3], excluded=[("a", "c")])
    assert {(p.pair, p.reason) for p in disabled_pairs(found)} == {
        (("a", "b"), "Always"),
        (("a", "c"), "Adjacent"),
    }
    many = self_collisions(before, before, configurations, excluded=[("a", "c")])
    reasons = {p.pair: p.reason for p in disabled_pairs(many)}
    assert reasons["b", "c"] == "Never"
    assert reasons["a", "b"] == "Always"
    assert [p.pair for p in disabled_pairs(many, with_geometry=["a", "b"])] == [("a", "b")]


@pytest.mark.parametrize(
    "inside",
    [
        b"<![CDATA[</robot>" + b"<!--a-->" * 100 + b"x]]>",
        b" " * 300_000 + b"<a/>",
    ],
)
def test_text_like_an_end_takes_no_time(inside):
    patched = patch_srdf(b'<robot name="r">' + inside + b"</robot>", PAIRS[:1])
    assert entries(patched) == [("base", "hand", "Default")]
    assert inside in patched
