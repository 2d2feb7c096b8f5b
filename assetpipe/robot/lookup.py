"""From the references in a robot description to files, without leaving the packages.

Order for ``package://name/rest`` (and ``model://``, ``$(find name)/rest``):

1. an explicit mapping,
2. the package that the URDF lies in: by its ``package.xml``, else by the name of a folder,
3. neighbouring packages by their ``package.xml``, up to two levels above the URDF's own package,
4. ``ROS_PACKAGE_PATH``,
5. ``AMENT_PREFIX_PATH`` (``share/name``), for ``model://`` the model paths of Gazebo,
6. a folder called ``name`` above the URDF or next to one of those (no link to elsewhere, unless a
   package lies there),
7. ``rest`` in the folders from the URDF up to its package's root.

(6) is what PyBullet does with ``name/rest``. A relative reference counts from the URDF's
folder, then from those above it (PyBullet), up to the package's root.

What a reference leads to must lie, symbolic links resolved, inside of a package that is known
or of a root that the user allows; else it is refused.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from difflib import get_close_matches
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any
from urllib.parse import unquote

from assetpipe.robot.packages import (
    Package,
    PackageIndex,
    ancestors,
    colcon_workspace,
    is_name,
)
from assetpipe.robot.resolution import Means, Resolution

if TYPE_CHECKING:
    from assetpipe.robot.resources import Resolver

_SHELVES = {
    "urdf", "urdfs", "robot", "robots", "xacro", "xacros", "model", "models", "sdf",
    "description", "descriptions", "config", "gazebo", "mjcf",
}  # fmt: skip
"""Folders that hold descriptions beside ``meshes``: the package is the folder above."""
_DEEP_SHELVES = {"urdf", "urdfs", "xacro", "xacros"}
"""Of these, the ones that hold nothing but descriptions, sorted in folders of their own too."""
_MESHES = ("meshes", "mesh")
"""What lies beside folders of descriptions: the package is the folder that holds both."""
_HOME_LEVELS = 3
"""Folders from a description up to such a shelf, or to the folder of the meshes."""
_LEVELS = 6
"""Folders above a description in which its package.xml is sought."""
_BEYOND = 2
"""Folders above a package in which others are sought: workspaces hold repositories of packages."""
_DEPTH = 2
"""How deep in each of these folders a package may lie."""
_LOOSE_LEVELS = 4
"""Folders in which a relative reference is sought where no package says where to stop."""
_SCHEMES = ("package://", "model://")


class Lookup:
    """Resolves the references of one description; remembers where packages lie meanwhile."""

    def __init__(self, resolver: Resolver, description: Path) -> None:
        self._resolver = resolver
        self._folder = description.parent
        self._index = PackageIndex()
        self.package: Package | None = self._index.around(self._folder, _LEVELS)
        """The package that the description lies in."""
        self.home: Path = self.package.root if self.package else _home(self._folder)
        """The folder that relative references must not leave."""
        self._trusted = [root.resolve() for root in self._trusted_roots()]
        self._around: dict[str, tuple[Path, ...]] | None = None

    def settings(self) -> dict[str, Any]:
        """The resolver's settings, JSON-ready."""
        return self._resolver.settings()

    def resolve(self, uri: str) -> Resolution:
        """What a reference leads to; says why where it leads nowhere."""
        try:
            return self._resolved(uri)
        except (OSError, ValueError):
            return Resolution(uri, "missing", hint="no file can be called so")
        except RuntimeError:
            return Resolution(uri, "missing", hint="symbolic links lead in a circle")

    def _resolved(self, uri: str) -> Resolution:
        text = uri.strip().replace("\\", "/")
        if not text or "\0" in text:
            return Resolution(uri, "missing", hint="the reference is empty")
        for scheme in _SCHEMES:
            if text.lower().startswith(scheme):
                return self._of_scheme(uri, text[len(scheme) :], scheme)
        unexpanded = text.removeprefix("file://")
        if unexpanded.startswith("$(find "):
            name, closed, rest = unexpanded[len("$(find ") :].partition(")")
            if closed:
                return self._in_package(uri, name.strip(), rest.lstrip("/"), "package://")
        if text.lower().startswith("file:"):
            return self._of_file(uri, text)
        if "://" in text:
            return Resolution(uri, "unsupported", hint="only files on this machine are read")
        if text.startswith("/") or _has_drive(text):
            return self._absolute(uri, Path(text))
        return self._relative(uri, text)

    def package_root(self, name: str) -> Path | None:
        """The folder of a package by its name alone, as ``$(find name)`` asks for.

        A name that is found nowhere stands for the description's own package where that
        declares none.
        """
        found = next((root for root, _ in self._roots(name, "package://")), None)
        return self.home if found is None and self.package is None else found

    def allows(self, path: Path) -> bool:
        """Whether a file may be read: it lies in a known package or an allowed root."""
        if self._resolver.outside == "read":
            return True
        real = path.resolve()
        if any(real.is_relative_to(root) for root in self._trusted):
            return True
        known = (root for roots in self._neighbours().values() for root in roots)
        return any(real.is_relative_to(root.resolve()) for root in known)

    def _trusted_roots(self) -> Iterator[Path]:
        resolver = self._resolver
        yield self.home
        yield from resolver.packages.values()
        yield from resolver.ros_package_path
        yield from resolver.model_path
        yield from resolver.allow_roots
        for prefix in resolver.ament_prefix_path:
            yield prefix
            workspace = colcon_workspace(prefix)
            if workspace is not None:
                yield workspace

    def _neighbours(self) -> dict[str, tuple[Path, ...]]:
        """Packages around the description by name, nearest first."""
        if self._around is None:
            found: dict[str, list[Path]] = {}
            for above in self._surroundings():
                for name, roots in self._index.below(above, _DEPTH).items():
                    found.setdefault(name, []).extend(roots)
            self._around = {name: tuple(dict.fromkeys(roots)) for name, roots in found.items()}
        return self._around

    def _roots(self, name: str, scheme: str) -> Iterator[tuple[Path, Means]]:
        """Folders that may be the package of this name, best first."""
        if not is_name(name):
            return
        resolver = self._resolver
        if name in resolver.packages:
            yield resolver.packages[name], "mapping"
        for above in self._own_folders():
            declared = self._index.name_of(above)
            if declared == name or (declared is None and above.name == name):
                yield above, "package.xml" if declared else "folder name"
        for root in self._neighbours().get(name, ()):
            yield root, "package.xml"
        for path in resolver.ros_package_path:
            for root in self._index.below(path, 4).get(name, ()):
                yield root, "ROS_PACKAGE_PATH"
        for prefix in resolver.ament_prefix_path:
            share = prefix / "share" / name
            if share.is_dir():
                yield share, "AMENT_PREFIX_PATH"
        if scheme == "model://":
            for path in resolver.model_path:
                if (path / name).is_dir():
                    yield path / name, "model path"
        for above in self._surroundings():
            if above.name == name:
                yield above, "folder name"
            elif (above / name).is_dir() and self._stays(above / name):
                yield above / name, "folder name"

    def _stays(self, folder: Path) -> bool:
        """Whether a folder that no manifest makes a package is one where it seems to be: a link
        may lead anywhere."""
        inside = folder.resolve().is_relative_to(folder.parent.resolve())
        return inside or self._index.name_of(folder) is not None or self.allows(folder)

    def _of_scheme(self, uri: str, text: str, scheme: str) -> Resolution:
        name, _, rest = text.lstrip("/").partition("/")
        if not text.startswith("/"):
            return self._in_package(uri, name, rest, scheme)
        # package:///a.stl names no package: exporters write it for what lies beside the file
        named = self._in_package(uri, name, rest, scheme) if rest else None
        if named is not None and named.state == "found":
            return named
        return self._relative(uri, text.lstrip("/"))

    def _in_package(self, uri: str, name: str, rest: str, scheme: str) -> Resolution:
        parts = PurePosixPath(rest)
        tried: list[str] = []
        places: list[Path] = []
        refused = False
        spellings = list(dict.fromkeys((rest, unquote(rest))))
        candidates = [*self._roots(name, scheme)]
        candidates += [(above, "walk up") for above in self._own_folders()]
        for root, means in candidates:
            for spelling in spellings:
                path = Path(os.path.normpath(root / spelling.lstrip("/")))
                if self._shown(path) in tried:
                    continue
                tried.append(self._shown(path))
                places.append(root)
                if not self._inside(path, root):
                    refused = True
                    continue
                if not path.is_file():
                    continue
                return Resolution(uri, "found", path, name, str(parts), root, means, tuple(tried))
        if refused:
            return Resolution(uri, "outside", package=name, rest=rest, hint=_ALLOW)
        known = sorted({*self._neighbours(), *self._resolver.packages})
        hint = self._near(places, rest)
        if hint is None and not any(m != "walk up" for _, m in candidates):
            close = get_close_matches(name, known, n=1)
            there = f"; did you mean '{close[0]}'?" if close else ""
            hint = (
                f"package '{name}' is not known{there}; "
                "add the folder that holds it to ROS_PACKAGE_PATH"
            )
        return Resolution(uri, "missing", package=name, rest=rest, tried=tuple(tried), hint=hint)

    def _relative(self, uri: str, text: str) -> Resolution:
        tried: list[str] = []
        places: list[Path] = []
        around = ancestors(self._folder, _LOOSE_LEVELS)
        for above in self._own_folders() if self.package else around:
            upwards = above != self._folder
            if upwards and PurePosixPath(text).parts[:1] == ("..",):
                break
            for spelling in dict.fromkeys((text, unquote(text))):
                path = Path(os.path.normpath(above / spelling))
                tried.append(self._shown(path))
                places.append(above)
                if not (path.is_file() or not path.is_relative_to(above)):
                    continue
                if not (self.allows(path) or (upwards and self._inside(path, above))):
                    return Resolution(uri, "outside", rest=text, hint=_ALLOW)
                if not path.is_file():
                    continue
                means: Means = "relative, upwards" if upwards else "relative"
                return Resolution(uri, "found", path, None, text, above, means, tuple(tried))
        return Resolution(
            uri, "missing", rest=text, tried=tuple(tried), hint=self._near(places, text)
        )

    def _of_file(self, uri: str, text: str) -> Resolution:
        body = text[len("file:") :]
        if not body.startswith("//"):
            return self._absolute_or_relative(uri, unquote(body))
        host, slash, rest = body[2:].partition("/")
        if host in ("", "localhost"):
            path = unquote(rest)
            return self._absolute_or_relative(uri, path if _has_drive(path) else slash + path)
        # file://meshes/a.stl is not what RFC 8089 says, but what people write
        return self._relative(uri, unquote(body[2:]))

    def _absolute_or_relative(self, uri: str, text: str) -> Resolution:
        if text.startswith("/") or _has_drive(text):
            return self._absolute(uri, Path(text))
        return self._relative(uri, text)

    def _absolute(self, uri: str, path: Path) -> Resolution:
        path = Path(os.path.normpath(path))
        if not self.allows(path):
            # whether it exists there is nobody's business
            return Resolution(uri, "outside", rest=str(path), hint=_ALLOW)
        if not path.is_file():
            return Resolution(
                uri,
                "missing",
                rest=str(path),
                tried=(str(path),),
                hint=self._near([path.parent], path.name),
            )
        return Resolution(uri, "found", path, None, str(path), path.parent, "file", (str(path),))

    def _own_folders(self) -> list[Path]:
        """The description's folder and those above it up to its home."""
        around = ancestors(self._folder, len(self._folder.parts))
        return [above for above in around if above.is_relative_to(self.home)]

    def _surroundings(self) -> list[Path]:
        """The description's own folders and those around its home."""
        own = self._own_folders()
        return [*own, *list(ancestors(self.home, 1 + _BEYOND))[1:]]

    def _inside(self, path: Path, root: Path) -> bool:
        return path.resolve().is_relative_to(root.resolve()) or self.allows(path)

    def _near(self, places: Sequence[Path], rest: str) -> str | None:
        """What the reference may have meant: the same name in other letters, or a close one."""
        for place in places:
            folder = place
            parts = [p for p in PurePosixPath(rest).parts if p not in (".", "/")]
            for part in parts:
                if part == "..":
                    folder = folder.parent
                    continue
                names = _names(folder)
                if part in names:
                    folder = folder / part
                    continue
                same = [n for n in names if n.casefold() == part.casefold()]
                close = same or get_close_matches(part, names, n=1, cutoff=0.75)
                if close:
                    what = "only the case differs" if same else "did you mean it?"
                    return f"there is '{self._shown(folder / close[0])}': {what}"
                break
        return None

    def _shown(self, path: Path) -> str:
        """A path for people: from the description's folder unless it is far away."""
        near = os.path.relpath(path, self._folder)
        return str(path) if near.count("..") > _LEVELS else near


_ALLOW = "add its folder to ASSETPIPE_ALLOW_ROOTS if you trust the description"


def _home(folder: Path) -> Path:
    """Without a package: the repository, else the folder above a shelf, or of the meshes."""
    for above in ancestors(folder, 6):
        if (above / ".git").exists():
            return above
    near = list(ancestors(folder, _HOME_LEVELS))
    for level, above in enumerate(near):
        shelves = _DEEP_SHELVES if level else _SHELVES
        if above.name.lower() in shelves and above.parent.parent != above.parent:
            return above.parent
    for above in near:
        if any((above / name).is_dir() for name in _MESHES):
            return above
    return folder


def _has_drive(text: str) -> bool:
    return len(text) > 2 and text[0].isalpha() and text[1] == ":" and text[2] == "/"


def _names(folder: Path) -> list[str]:
    try:
        with os.scandir(folder) as entries:
            return sorted(entry.name for entry in entries)[:5000]
    except OSError:
        return []
