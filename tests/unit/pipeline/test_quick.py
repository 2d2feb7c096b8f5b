import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from assetpipe.pipeline import ledger
from assetpipe.pipeline.cache import Cache
from assetpipe.pipeline.identity import digest_file
from assetpipe.pipeline.inputs import find_sources
from assetpipe.pipeline.quick import Command, Part, again, remember
from assetpipe.pipeline.references import references

ROOT = Path(__file__).resolve().parents[3]
URDF = (
    '<robot name="r"><link name="a"><collision><geometry>{}</geometry></collision></link></robot>'
)
KEY = "0" * 64


class Scene:
    """A command that was done once, with a package, a configuration and a cache."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.package = root / "ws/p"
        self.urdf = self.package / "urdf/a.urdf"
        self.mesh = self.package / "meshes/a.stl"
        self.out, self.config = root / "out", root / "c.yaml"
        for path in (self.urdf, self.mesh):
            path.parent.mkdir(parents=True)
        self.urdf.write_text(URDF.format('<mesh filename="package://p/meshes/a.stl"/>'))
        self.mesh.write_text("solid")
        (self.package / "package.xml").write_text("<package><name>p</name></package>")
        self.config.write_text("seed: 1\n")
        arguments = (
            "build",
            str(self.package),
            "-o",
            str(self.out),
            "--cache-dir",
            str(root / "k"),
        )
        self.command = Command(arguments, 0)
        self.cache = Cache(root / "k")
        tree = root / "tree"
        tree.mkdir()
        (tree / "a.urdf").write_text("<robot/>")
        (tree / "assetpipe.json").write_text('{"assetpipe": {}, "outputs": {"a.urdf": ""}}')
        outputs = {name: digest_file(tree / name) for name in ("a.urdf", "assetpipe.json")}
        ledger.remember(self.cache, KEY, result={}, tree=tree, outputs=outputs, inputs={})
        sources = find_sources([self.package])
        found = references(sources[0])
        assert found is not None
        remember(
            self.command,
            [Part(sources[0], self.out, found, KEY)],
            inputs=[self.package],
            files=[self.config],
            code=1,
            text="a table\n",
        )


@pytest.fixture
def scene(tmp_path: Path) -> Scene:
    return Scene(tmp_path)


def test_unchanged_command_is_done_again(scene: Scene) -> None:
    assert again(scene.command) == (1, "a table\n")
    assert (scene.out / "a.urdf").read_text() == "<robot/>"


def test_foreign_output_is_left_to_the_full_way(scene: Scene) -> None:
    scene.out.mkdir()
    (scene.out / "thesis.tex").write_text("precious")
    assert again(scene.command) is None
    assert os.listdir(scene.out) == ["thesis.tex"]


@pytest.mark.parametrize(
    "change",
    [
        lambda s: s.urdf.write_text(s.urdf.read_text() + "\n"),
        lambda s: s.mesh.write_text("solid other"),
        lambda s: s.mesh.unlink(),
        lambda s: s.config.write_text("seed: 2\n"),
        lambda s: (s.package / "package.xml").write_text("<package><name>q</name></package>"),
        lambda s: (s.urdf.parent / "b.urdf").write_text(s.urdf.read_text()),
        lambda s: [p.unlink() for p in (s.root / "k/builds").rglob("*") if p.is_file()],
    ],
    ids=["urdf", "mesh", "no mesh", "config", "manifest", "another robot", "ledger"],
)
def test_any_change_that_matters_needs_the_full_way(
    scene: Scene, change: Callable[[Scene], object]
) -> None:
    change(scene)
    assert again(scene.command) is None
    assert not scene.out.exists()


def test_package_that_moves_into_the_way_is_noticed(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    other = scene.root / "elsewhere/p"
    (other / "meshes").mkdir(parents=True)
    (other / "package.xml").write_text("<package><name>p</name></package>")
    (other / "meshes/a.stl").write_text("solid other")
    scene.mesh.unlink()
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(scene.root / "elsewhere"))
    assert again(scene.command) is None


@pytest.mark.parametrize(
    "arguments",
    [
        ("check", "."),
        ("build", ".", "-o", "out", "--no-cache"),
        ("build", ".", "-o", "out", "--json"),
        ("build", ".", "-o", "out", "--json=x.json"),
        ("build", ".", "-o", "out", "--sarif", "x"),
        ("build", ".", "-o", "out", "--check"),
        (),
    ],
)
def test_commands_that_do_more_are_never_recalled(arguments: tuple[str, ...]) -> None:
    assert Command(arguments, 0).cache is None


def test_cache_folder_is_the_one_that_is_named(tmp_path: Path) -> None:
    for words in (("--cache-dir", str(tmp_path)), (f"--cache-dir={tmp_path}",)):
        assert Command(("build", *words), 0).cache == Cache(tmp_path)


def test_nothing_slow_is_loaded(scene: Scene) -> None:
    program = (
        "import sys; from assetpipe.pipeline.quick import Command, again\n"
        f"assert again(Command({scene.command.arguments!r}, 0)) is not None\n"
        "slow = {'numpy', 'pydantic', 'rich', 'trimesh', 'yaml'} & set(sys.modules)\n"
        "assert not slow, slow"
    )
    subprocess.run(
        [sys.executable, "-c", program], check=True, env={**os.environ, "PYTHONPATH": str(ROOT)}
    )
