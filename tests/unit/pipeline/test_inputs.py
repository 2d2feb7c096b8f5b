import json
from pathlib import Path

import pytest

from assetpipe.errors import InputError, UsageError
from assetpipe.pipeline.inputs import find_sources
from assetpipe.pipeline.output import PROVENANCE
from assetpipe.pipeline.shards import Shard
from assetpipe.pipeline.targets import labels, targets

ROBOT = '<robot name="r"><link name="a"/></robot>'


def put(folder: Path, *names: str) -> None:
    for name in names:
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(ROBOT)


def names(folder: Path, *inputs: Path) -> list[str]:
    return [str(s.path.relative_to(folder)) for s in find_sources(inputs or (folder,))]


def test_folders_are_searched_and_files_taken_once(tmp_path: Path) -> None:
    put(tmp_path, "a/urdf/a.urdf", "b/b.urdf.xacro", "a/urdf/a.urdf.xacro", ".git/x.urdf")
    assert names(tmp_path) == ["a/urdf/a.urdf", "b/b.urdf.xacro"]
    again = names(tmp_path, tmp_path / "a/urdf/a.urdf", tmp_path)
    assert again == ["a/urdf/a.urdf", "b/b.urdf.xacro"]


def test_what_we_built_is_not_built_again_unless_it_is_named(tmp_path: Path) -> None:
    put(tmp_path, "a.urdf", "out/deep/a.urdf")
    (tmp_path / "out" / PROVENANCE).write_text(json.dumps({"assetpipe": {}}))
    assert names(tmp_path) == ["a.urdf"]
    assert names(tmp_path, tmp_path / "out") == ["out/deep/a.urdf"]


def test_kinds_are_told_by_their_endings(tmp_path: Path) -> None:
    put(tmp_path, "a.urdf", "b.STL", "c.xml")
    kinds = [s.kind for s in find_sources([tmp_path / n for n in ("a.urdf", "b.STL", "c.xml")])]
    assert kinds == ["robot", "mesh", "robot"]


@pytest.mark.parametrize("name", ["notes.txt", "missing.urdf"])
def test_the_rest_is_refused_by_name(tmp_path: Path, name: str) -> None:
    (tmp_path / "notes.txt").write_text("")
    with pytest.raises(InputError, match=name.replace(".", r"\.")):
        find_sources([tmp_path / name])


def test_folder_without_robots_says_what_was_looked_for(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no URDF and no xacro"):
        find_sources([tmp_path])


def test_one_source_takes_out_and_several_get_folders_whatever_the_shard(tmp_path: Path) -> None:
    put(tmp_path / "in", "a/model.urdf", "b/model.urdf", "b-model.urdf", "c d/x.urdf")
    sources = find_sources([tmp_path / "in"])
    assert [t.out for t in targets(sources[:1], tmp_path / "out", Shard())] == [tmp_path / "out"]
    found = labels(sources)
    assert len(set(found)) == len(found) == 4
    assert all(name == name.strip() and "/" not in name for name in found)
    whole = targets(sources, tmp_path / "out", Shard())
    parts = [t for n in (1, 2, 3) for t in targets(sources, tmp_path / "out", Shard(n, 3))]
    assert {t.out for t in parts} == {t.out for t in whole}


def test_labels_say_what_people_would(tmp_path: Path) -> None:
    put(tmp_path, "arm/urdf/arm.urdf", "arm/urdf/left.urdf", "kuka/model.urdf", "x.urdf")
    assert labels(find_sources([tmp_path])) == ("arm", "arm-left", "kuka-model", "x")


def test_output_never_replaces_its_own_input(tmp_path: Path) -> None:
    put(tmp_path, "out/a.urdf")
    (tmp_path / "out" / PROVENANCE).write_text(json.dumps({"assetpipe": {}}))
    with pytest.raises(UsageError, match="holds the input"):
        targets(find_sources([tmp_path / "out"]), tmp_path / "out", Shard())


@pytest.mark.parametrize("name", ["r\udcff.urdf", "in\udcff/r.urdf"])
def test_what_reports_could_not_name_is_refused(tmp_path: Path, name: str) -> None:
    try:
        put(tmp_path, name)
    except (OSError, UnicodeError):
        pytest.skip("this file system has UTF-8 names only")
    for given in (tmp_path, tmp_path / name):
        with pytest.raises(InputError, match=r"\\udcff.*not UTF-8"):
            find_sources((given,))
