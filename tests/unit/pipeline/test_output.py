import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from assetpipe.errors import UsageError
from assetpipe.pipeline.output import PROVENANCE, list_files, staged


def build(out: Path, files: dict[str, str]) -> tuple[str, ...]:
    with staged(out) as stage:
        for name, text in files.items():
            stage.path(name).write_text(text)
        outputs = dict.fromkeys(files, "")
        stage.path(PROVENANCE).write_text(json.dumps({"assetpipe": {}, "outputs": outputs}))
        return stage.commit()


def tree(folder: Path) -> dict[str, str]:
    return {name: (folder / name).read_text() for name in list_files(folder)}


def test_new_output_appears_whole_and_nothing_stays_beside_it(tmp_path: Path) -> None:
    build(tmp_path / "out", {"a/b.txt": "1"})
    assert (tmp_path / "out/a/b.txt").read_text() == "1"
    assert os.listdir(tmp_path) == ["out"]


def test_error_while_writing_leaves_the_old_output(tmp_path: Path) -> None:
    build(tmp_path / "out", {"a.txt": "old"})
    before = tree(tmp_path / "out")

    def fail_half_way() -> None:
        with staged(tmp_path / "out") as stage:
            stage.path("a.txt").write_text("new")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail_half_way()
    assert tree(tmp_path / "out") == before
    assert os.listdir(tmp_path) == ["out"]


def test_killed_run_leaves_the_old_output_and_the_next_run_tidies(tmp_path: Path) -> None:
    build(tmp_path / "out", {"a.txt": "old"})
    before = tree(tmp_path / "out")
    program = (
        "import os, signal; from pathlib import Path\n"
        "from assetpipe.pipeline.output import staged\n"
        f"with staged(Path({str(tmp_path / 'out')!r})) as stage:\n"
        "    stage.path('a.txt').write_text('half')\n"
        "    os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    root = Path(__file__).resolve().parents[3]
    done = subprocess.run(
        [sys.executable, "-c", program], env={**os.environ, "PYTHONPATH": str(root)}, check=False
    )
    assert done.returncode == -9
    assert tree(tmp_path / "out") == before
    assert len(os.listdir(tmp_path)) == 2
    build(tmp_path / "out", {"a.txt": "new"})
    assert os.listdir(tmp_path) == ["out"]


def test_old_files_of_ours_go_and_foreign_ones_stay(tmp_path: Path) -> None:
    build(tmp_path / "out", {"old.txt": "1", "both.txt": "1"})
    (tmp_path / "out/notes/mine.md").parent.mkdir()
    (tmp_path / "out/notes/mine.md").write_text("mine")
    changed = build(tmp_path / "out", {"new.txt": "1", "both.txt": "1"})
    assert set(tree(tmp_path / "out")) == {"new.txt", "both.txt", "notes/mine.md", PROVENANCE}
    assert set(changed) == {"old.txt", "new.txt", PROVENANCE}


def test_foreign_file_is_never_overwritten(tmp_path: Path) -> None:
    build(tmp_path / "out", {"a.txt": "1"})
    (tmp_path / "out/b.txt").write_text("mine")
    with pytest.raises(UsageError, match="not ours"):
        build(tmp_path / "out", {"b.txt": "ours"})
    assert (tmp_path / "out/b.txt").read_text() == "mine"
    assert (tmp_path / "out/a.txt").read_text() == "1"


def test_foreign_folder_is_refused(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out/thesis.tex").write_text("precious")
    with pytest.raises(UsageError, match="was not written by assetpipe"):
        build(tmp_path / "out", {"a.txt": "1"})
    assert tree(tmp_path / "out") == {"thesis.tex": "precious"}
    (tmp_path / "file").write_text("")
    with pytest.raises(UsageError, match="is a file"):
        build(tmp_path / "file", {"a.txt": "1"})


def test_empty_folder_is_taken(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    build(tmp_path / "out", {"a.txt": "1"})
    assert (tmp_path / "out/a.txt").exists()


def test_unchanged_output_is_not_touched(tmp_path: Path) -> None:
    build(tmp_path / "out", {"a.txt": "1"})
    before = (tmp_path / "out").stat().st_ino
    assert build(tmp_path / "out", {"a.txt": "1"}) == ()
    assert (tmp_path / "out").stat().st_ino == before


@pytest.mark.parametrize("name", ["../x", "/x", "a/../../x", ""])
def test_no_file_leaves_the_output(tmp_path: Path, name: str) -> None:
    with staged(tmp_path / "out") as stage, pytest.raises(UsageError):
        stage.path(name)


def test_lying_provenance_cannot_make_us_delete_elsewhere(tmp_path: Path) -> None:
    (tmp_path / "precious").write_text("1")
    build(tmp_path / "out", {"a.txt": "1"})
    lies = {"assetpipe": {}, "outputs": {"../precious": "", str(tmp_path / "precious"): ""}}
    (tmp_path / "out" / PROVENANCE).write_text(json.dumps(lies))
    build(tmp_path / "out", {"b.txt": "1"})
    assert (tmp_path / "precious").read_text() == "1"
    assert (tmp_path / "out/a.txt").read_text() == "1"  # nobody says that it was ours


def test_output_that_is_a_link_is_followed(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    (tmp_path / "out").symlink_to(tmp_path / "real")
    build(tmp_path / "out", {"a.txt": "1"})
    assert (tmp_path / "out").is_symlink()
    assert (tmp_path / "real/a.txt").read_text() == "1"
