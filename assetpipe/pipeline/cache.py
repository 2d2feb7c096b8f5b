"""A content-addressed cache: what was computed once is not computed again.

Safe against damage (every entry carries its digest; a bad one is a miss and is
removed), interruption and concurrent writers (entries are renamed into place).
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import tempfile
from dataclasses import dataclass
from pathlib import Path

MAX_BYTES = 4 * 2**30
"""Past this size :meth:`Cache.prune` removes what was not used for longest."""


def default_root() -> Path:
    """``$XDG_CACHE_HOME/assetpipe``, or ``~/.cache/assetpipe``."""
    base = os.environ.get("XDG_CACHE_HOME", "")
    return (Path(base) if os.path.isabs(base) else Path.home() / ".cache") / "assetpipe"


@dataclass(frozen=True)
class Cache:
    """Bytes by key in a folder.

    Attributes:
        root: the folder; ``None`` keeps nothing and finds nothing.
    """

    root: Path | None

    def get(self, room: str, key: str) -> bytes | None:
        """The bytes stored under a key, or ``None``; damaged entries are removed.

        Args:
            room: subfolder, a kind of entry.
            key: hexadecimal digest.
        """
        path = self._path(room, key)
        if path is None:
            return None
        try:
            data = path.read_bytes()
        except OSError:
            return None
        payload = data[65:]
        if data[:65] != hashlib.sha256(payload).hexdigest().encode() + b"\n":
            with contextlib.suppress(OSError):
                path.unlink()
            return None
        with contextlib.suppress(OSError):
            os.utime(path)  # used lately
        return payload

    def put(self, room: str, key: str, payload: bytes) -> None:
        """Store bytes; a cache that cannot be written is no error."""
        path = self._path(room, key)
        if path is None:
            return
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            handle, name = tempfile.mkstemp(prefix=".new-", dir=path.parent)
            try:
                with os.fdopen(handle, "wb") as file:
                    file.write(hashlib.sha256(payload).hexdigest().encode() + b"\n" + payload)
                os.replace(name, path)
            except BaseException:
                with contextlib.suppress(OSError):
                    os.unlink(name)
                raise
        except OSError:
            return

    def prune(self, limit: int = MAX_BYTES) -> None:
        """Remove what was not used for longest until ``limit`` bytes are left."""
        if self.root is None:
            return
        entries: list[tuple[float, int, Path]] = []
        for folder, _, names in os.walk(self.root):
            for name in names:
                path = Path(folder, name)
                with contextlib.suppress(OSError):
                    stat = path.stat()
                    entries.append((stat.st_mtime, stat.st_size, path))
        total = sum(size for _, size, _ in entries)
        for _, size, path in sorted(entries):
            if total <= limit:
                return
            with contextlib.suppress(OSError):
                path.unlink()
                total -= size

    def _path(self, room: str, key: str) -> Path | None:
        if self.root is None:
            return None
        return self.root / room / key[:2] / key
