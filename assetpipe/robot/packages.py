"""Where packages lie on disk: by ``package.xml``, in workspaces and around a file."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from assetpipe import secure_xml
from assetpipe.errors import AssetpipeError

_MANIFEST = "package.xml"
_MAX_ENTRIES = 2000
"""Entries of one folder that are looked at; a search must not become a scan of the disk."""
_MAX_MANIFEST = 1 << 20
_NAME = re.compile(r"(?!\.)[^/\\\x00-\x1f]{1,200}")
"""What a package may be called: what a folder may that is not hidden."""
_SKIPPED = {"build", "log", "node_modules", "__pycache__", "site-packages", "dist-packages"}


@dataclass(frozen=True)
class Package:
    """A robot package.

    Attributes:
        name: as references call it.
        root: its folder.
        declared: whether a ``package.xml`` says so; else the folder's name does.
    """

    name: str
    root: Path
    declared: bool


def ancestors(folder: Path, levels: int) -> Iterator[Path]:
    """``folder`` and those above it, ``levels`` at most; never the file system's root."""
    for above in [folder, *folder.parents][:levels]:
        if above.parent == above:
            return
        yield above


@dataclass
class PackageIndex:
    """Finds packages; remembers what it has looked at for the length of one reading."""

    _names: dict[Path, str | None] = field(default_factory=dict)
    _found: dict[tuple[Path, int], dict[str, tuple[Path, ...]]] = field(default_factory=dict)
    _entries: dict[Path, tuple[str, ...]] = field(default_factory=dict)

    def name_of(self, folder: Path) -> str | None:
        """The name in the folder's ``package.xml``, or ``None``."""
        if folder not in self._names:
            self._names[folder] = _declared_name(folder / _MANIFEST)
        return self._names[folder]

    def around(self, folder: Path, levels: int) -> Package | None:
        """The package that a folder belongs to."""
        for above in ancestors(folder, levels):
            name = self.name_of(above)
            if name is not None:
                return Package(name, above, True)
        return None

    def below(self, folder: Path, depth: int) -> dict[str, tuple[Path, ...]]:
        """Packages in a folder and at most ``depth`` levels below it, by name."""
        key = (folder, depth)
        if key not in self._found:
            found: dict[str, list[Path]] = {}
            name = self.name_of(folder)
            if name is not None:
                found.setdefault(name, []).append(folder)
            elif depth > 0:
                for entry in self.folders(folder):
                    for other, roots in self.below(folder / entry, depth - 1).items():
                        found.setdefault(other, []).extend(roots)
            self._found[key] = {n: tuple(roots) for n, roots in found.items()}
        return self._found[key]

    def folders(self, folder: Path) -> tuple[str, ...]:
        """Names of the folders in a folder, sorted; hidden and built ones left out."""
        if folder not in self._entries:
            try:
                with os.scandir(folder) as entries:
                    names = sorted(
                        entry.name
                        for entry in entries
                        if not entry.name.startswith(".")
                        and entry.name not in _SKIPPED
                        and entry.is_dir()
                    )
            except OSError:
                names = []
            self._entries[folder] = tuple(names[:_MAX_ENTRIES])
        return self._entries[folder]


def _declared_name(manifest: Path) -> str | None:
    try:
        if not manifest.is_file() or manifest.stat().st_size > _MAX_MANIFEST:
            return None
        root = secure_xml.parse(manifest.read_bytes(), manifest)
    except (OSError, AssetpipeError):
        return None
    for element in root:
        if str(element.tag).rpartition("}")[2] == "name":
            name = (element.text or "").strip()
            # It will be a folder in the output.
            return name if is_name(name) else None
    return None


def is_name(text: str) -> bool:
    """Whether a package may be called so: like a folder, and not like a path."""
    return _NAME.fullmatch(text) is not None


def colcon_workspace(prefix: Path) -> Path | None:
    """The workspace whose ``colcon build --symlink-install`` made this prefix, if one did."""
    for folder in (prefix, prefix.parent):
        if (folder / ".colcon_install_layout").is_file():
            return folder.parent
    return None
