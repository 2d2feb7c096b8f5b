"""What both robots have still takes part in comparing them."""

import trimesh

import assetpipe


def channel_and_block(folder):
    """A channel, and a block between its walls on a link two joints away."""
    walls = [trimesh.creation.box((0.02, 0.2, 0.1)) for _ in range(2)]
    walls[0].apply_translation((-0.09, 0, 0.06))
    walls[1].apply_translation((0.09, 0, 0.06))
    floor = trimesh.creation.box((0.2, 0.2, 0.02))
    trimesh.boolean.union([floor, *walls], engine="manifold").export(folder / "channel.stl")
    urdf = folder / "channel.urdf"
    urdf.write_text(
        """<robot name="channel">
  <link name="base">
    <collision><geometry><mesh filename="channel.stl"/></geometry></collision></link>
  <link name="mid"/>
  <link name="block">
    <collision><geometry><box size="0.06 0.06 0.04"/></geometry></collision></link>
  <joint name="first" type="revolute"><parent link="base"/><child link="mid"/>
    <axis xyz="0 1 0"/><limit lower="0" upper="0.001" effort="1" velocity="1"/></joint>
  <joint name="second" type="revolute"><parent link="mid"/><child link="block"/>
    <origin xyz="0 0 0.07"/>
    <axis xyz="0 1 0"/><limit lower="0" upper="0.001" effort="1" velocity="1"/></joint>
</robot>
""",
        encoding="utf-8",
    )
    return urdf


def test_a_hull_that_swallows_an_unchanged_box_is_a_new_pair(tmp_path):
    urdf = channel_and_block(tmp_path)
    said = {}
    for engine in ("hull", "assetpipe"):
        config = assetpipe.Config(engine=engine, validation={"checks": ()})
        built = assetpipe.build(urdf, tmp_path / engine, config=config)
        said[engine] = assetpipe.validate(urdf, built.urdf).checks["self_collision"]
    assert [set(pair["pair"]) for pair in said["hull"]["new"]] == [{"base", "block"}]
    assert said["assetpipe"]["new"] == []
