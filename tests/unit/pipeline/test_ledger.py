import hashlib
import os
from collections.abc import Callable
from pathlib import Path

import pytest

from assetpipe.pipeline.cache import Cache
from assetpipe.pipeline.identity import digest_file
from assetpipe.pipeline.ledger import Entry, environment, recall, remember

KEY = hashlib.sha256(b"asked").hexdigest()


class Scene:
    def __init__(self, folder: Path) -> None:
        self.cache = Cache(folder / "cache")
        self.package = folder / "package"
        self.out = self.package / "out"
        self.urdf, self.visual = self.package / "a.urdf", self.package / "big.bin"
        self.out.mkdir(parents=True)
        self.urdf.write_text("<robot/>")
        self.visual.write_bytes(os.urandom(2**20 + 1))
        (self.out / "a.urdf").write_text("<robot/>")
        (self.out / "big.bin").write_bytes(self.visual.read_bytes())
        remember(
            self.cache,
            KEY,
            inputs={str(p): digest_file(p) for p in (self.urdf, self.visual)},
            folders=[str(self.package)],
            out=self.out,
            result={"robots": []},
            tree=self.out,
            names=["a.urdf", "big.bin"],
        )

    def recall(self) -> Entry | None:
        return recall(self.cache, KEY, self.out)


@pytest.fixture
def scene(tmp_path: Path) -> Scene:
    return Scene(tmp_path)


def test_unchanged_build_is_remembered_and_large_inputs_are_not_stored_twice(scene: Scene) -> None:
    entry = scene.recall()
    assert entry == Entry({"robots": []}, {"a.urdf": b"<robot/>"}, {"big.bin": str(scene.visual)})


@pytest.mark.parametrize(
    "change",
    [
        lambda s: s.urdf.write_text("<robot />"),
        lambda s: s.visual.unlink(),
        lambda s: (s.package / "package.xml").write_text("may lead elsewhere"),
        lambda s: (s.package / "meshes").mkdir(),
    ],
)
def test_any_change_of_what_mattered_forgets_it(
    scene: Scene, change: Callable[[Scene], object]
) -> None:
    change(scene)
    assert scene.recall() is None


def test_output_and_stages_in_the_same_folder_change_nothing(scene: Scene) -> None:
    (scene.package / ".out.assetpipe-stage-1-ab").mkdir()
    (scene.out / "new.txt").write_text("1")
    assert scene.recall() is not None


def test_same_content_with_another_time_is_unchanged(scene: Scene) -> None:
    os.utime(scene.urdf, (1, 1))
    assert scene.recall() is not None


def test_changed_content_with_the_same_time_is_changed(scene: Scene) -> None:
    stat = scene.urdf.stat()
    scene.urdf.write_text("<ROBOT/>")
    os.utime(scene.urdf, ns=(stat.st_atime_ns, stat.st_mtime_ns))
    assert scene.recall() is None


def test_environment_that_leads_references_is_part_of_the_question(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    before = environment()
    monkeypatch.setenv("ROS_PACKAGE_PATH", "/elsewhere")
    assert environment() != before
