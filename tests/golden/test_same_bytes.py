"""What a command writes does not depend on who runs it, where, or on how many threads."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
MESH = ROOT / "sample_assets" / "arm_gripper" / "meshes" / "base_link.stl"


def written(
    mesh: Path, out: Path, *, cwd: Path, threads: int, seed: int, locale: str
) -> dict[str, bytes]:
    environment = {
        **os.environ,
        "ASSETPIPE_THREADS": str(threads),
        "RAYON_NUM_THREADS": str(threads),
        "PYTHONHASHSEED": str(seed),
        "LC_ALL": locale,
        "LANG": locale,
        "PYTHONPATH": os.pathsep.join([str(ROOT), *sys.path]),
    }
    command = [sys.executable, "-m", "assetpipe", "decompose", str(mesh), "-o", str(out)]
    done = subprocess.run(command, cwd=cwd, env=environment, capture_output=True, check=False)
    assert done.returncode in (0, 1), done.stderr.decode()
    return {
        str(path.relative_to(out)): path.read_bytes() for path in out.rglob("*") if path.is_file()
    }


@pytest.mark.parametrize("name", ["base_link.stl", "Bäse link.STL"])
def test_surroundings_change_no_byte(tmp_path: Path, name: str) -> None:
    first = written(MESH, tmp_path / "a", cwd=ROOT, threads=1, seed=0, locale="C")
    assert any(path.endswith(".obj") for path in first)
    elsewhere = tmp_path / "else where"
    elsewhere.mkdir()
    shutil.copy(MESH, elsewhere / name)
    second = written(
        Path(name), tmp_path / "b", cwd=elsewhere, threads=2, seed=4711, locale="C.UTF-8"
    )
    hulls = [
        sorted(data for path, data in tree.items() if path.endswith(".obj"))
        for tree in (first, second)
    ]
    assert hulls[0] == hulls[1]
    if name == MESH.name:
        assert first == second
