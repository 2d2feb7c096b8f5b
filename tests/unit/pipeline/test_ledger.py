import hashlib
from pathlib import Path

from assetpipe.pipeline.cache import Cache
from assetpipe.pipeline.identity import digest_file
from assetpipe.pipeline.ledger import LARGE, ROOM, Entry, recall, remember

KEY = hashlib.sha256(b"asked").hexdigest()


def test_build_is_remembered_until_an_input_changes(tmp_path: Path) -> None:
    tree = tmp_path / "out"
    (tree / "meshes").mkdir(parents=True)
    (tree / "a.urdf").write_text("<robot/>")
    (tree / "meshes/big.dae").write_bytes(b"x" * (LARGE + 1))
    (tree / "meshes/hull.obj").write_bytes(b"y" * (LARGE + 1))
    outputs = {
        name: digest_file(tree / name) for name in ("a.urdf", "meshes/big.dae", "meshes/hull.obj")
    }
    visual = tmp_path / "visual.dae"
    visual.write_bytes(b"x" * (LARGE + 1))
    cache = Cache(tmp_path / "cache")
    remember(
        cache,
        KEY,
        result={"robots": []},
        tree=tree,
        outputs=outputs,
        inputs={str(visual): digest_file(visual)},
    )
    assert recall(cache, KEY) == Entry(
        {"robots": []},
        {"a.urdf": b"<robot/>", "meshes/hull.obj": b"y" * (LARGE + 1)},
        {"meshes/big.dae": str(visual)},  # large inputs are not stored twice
    )
    visual.write_bytes(b"z" * (LARGE + 1))
    assert recall(cache, KEY) is None
    visual.unlink()
    assert recall(cache, KEY) is None


def test_nothing_known_is_nothing_recalled(tmp_path: Path) -> None:
    cache = Cache(tmp_path)
    assert recall(cache, KEY) is None
    cache.put(ROOM, KEY, b"not an entry")
    assert recall(cache, KEY) is None
