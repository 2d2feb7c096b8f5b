import hashlib
import os
import threading
from pathlib import Path

from assetpipe.pipeline.cache import Cache, default_root

KEY = hashlib.sha256(b"key").hexdigest()


def entry(root: Path) -> Path:
    return root / "room" / KEY[:2] / KEY


def test_gives_back_what_was_put(tmp_path: Path) -> None:
    cache = Cache(tmp_path)
    assert cache.get("room", KEY) is None
    cache.put("room", KEY, b"bytes")
    assert cache.get("room", KEY) == b"bytes"


def test_damage_is_a_miss_and_is_removed(tmp_path: Path) -> None:
    cache = Cache(tmp_path)
    cache.put("room", KEY, b"bytes")
    for damaged in (b"", b"short", entry(tmp_path).read_bytes()[:-1], b"x" * 200):
        entry(tmp_path).write_bytes(damaged)
        assert cache.get("room", KEY) is None
        assert not entry(tmp_path).exists()


def test_no_cache_keeps_nothing() -> None:
    cache = Cache(None)
    cache.put("room", KEY, b"bytes")
    assert cache.get("room", KEY) is None


def test_unwritable_root_is_no_error(tmp_path: Path) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("not a folder")
    cache = Cache(blocked)
    cache.put("room", KEY, b"bytes")
    assert cache.get("room", KEY) is None


def test_concurrent_writers_leave_one_whole_entry(tmp_path: Path) -> None:
    cache = Cache(tmp_path)
    payloads = [bytes([n]) * 100_000 for n in range(8)]
    threads = [threading.Thread(target=cache.put, args=("room", KEY, p)) for p in payloads]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert cache.get("room", KEY) in payloads
    assert os.listdir(entry(tmp_path).parent) == [KEY]


def test_prune_removes_the_least_recently_used(tmp_path: Path) -> None:
    cache = Cache(tmp_path)
    keys = [hashlib.sha256(bytes([n])).hexdigest() for n in range(3)]
    for age, key in enumerate(keys):
        cache.put("room", key, b"x" * 1000)
        os.utime(tmp_path / "room" / key[:2] / key, (1000 + age, 1000 + age))
    cache.get("room", keys[0])  # used just now
    cache.prune(limit=2200)
    assert [cache.get("room", key) is not None for key in keys] == [True, False, True]


def test_root_follows_xdg(monkeypatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert default_root() == tmp_path / "assetpipe"
    monkeypatch.setenv("XDG_CACHE_HOME", "relative/is/ignored")
    assert default_root() == Path.home() / ".cache" / "assetpipe"
