"""The files that mesh files refer to: materials, textures, buffers."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path, PurePosixPath
from urllib.parse import unquote, urlsplit

from assetpipe import secure_xml
from assetpipe.errors import AssetpipeError

_MAX_BYTES = 256 * 1024 * 1024
_MOST = 10_000
"""References of a mesh or material library that are followed."""
_WORDS = 32
"""Words of a texture's line, from its end, that may be its name: options come before it."""
_SUFFIXES = {
    ".mtl", ".bin", ".png", ".jpg", ".jpeg", ".jpe", ".tga", ".bmp", ".gif", ".tif", ".tiff",
    ".dds", ".ktx", ".ktx2", ".webp", ".hdr", ".exr", ".pbm", ".pgm", ".ppm", ".psd", ".material",
}  # fmt: skip
_DRAWN = {
    ".3ds", ".3mf", ".blend", ".fbx", ".igs", ".iges", ".lwo", ".mesh", ".step", ".stp", ".usd",
    ".usda", ".usdc", ".usdz", ".vrml", ".wrl", ".x3d",
}  # fmt: skip
"""Kinds of meshes that others draw and nobody here reads."""
_LIBRARY = re.compile(rb"^[ \t]*mtllib[ \t]+([^\r\n]+)", re.MULTILINE)
_MAP = re.compile(
    rb"^[ \t]*(?:map_\w+|bump|disp|decal|refl|norm)[ \t]+([^\r\n]+)", re.MULTILINE | re.IGNORECASE
)


@dataclass(frozen=True)
class Companion:
    """A file beside a mesh.

    Attributes:
        reference: its place relative to the mesh's folder, ``/`` between parts.
        source: the file.
    """

    reference: PurePosixPath
    source: Path


def companions(mesh: Path, root: Path) -> tuple[Companion, ...]:
    """Files that a mesh needs to look as it does, in the order in which they are named.

    Args:
        mesh: OBJ (material libraries and their textures), DAE (images) or glTF (buffers and
            images); other formats have none.
        root: what lies outside of it, symbolic links resolved, is left out, as is what is
            no material, image or buffer.
    """
    found: dict[PurePosixPath, Companion] = {}
    for reference in _references(mesh):
        for companion in _followed(mesh.parent, reference, root):
            found.setdefault(companion.reference, companion)
    return tuple(found.values())


def _followed(folder: Path, reference: str, root: Path) -> Iterator[Companion]:
    first = _companion(folder, reference, root)
    if first is None:
        return
    yield first
    if first.source.suffix.lower() != ".mtl":
        return
    # textures count from the library's own folder
    shift = first.reference.parent
    for texture in _textures(first.source):
        second = _companion(first.source.parent, texture, root)
        if second is not None:
            yield Companion(shift / second.reference, second.source)


def is_drawn(path: Path) -> bool:
    """Whether a file is of a kind that robots are drawn with: a mesh, or an image."""
    from assetpipe.geometry.files import SUFFIXES

    suffix = path.suffix.lower()
    return suffix in _DRAWN or suffix in _SUFFIXES or suffix in SUFFIXES


def _companion(folder: Path, reference: str, root: Path) -> Companion | None:
    text = reference.strip().replace("\\", "/")
    try:
        if not text or urlsplit(text).scheme or text.startswith("/"):
            return None
    except ValueError:
        return None
    for spelling in dict.fromkeys((text, unquote(text))):
        path = folder / spelling
        try:
            real = path.resolve()
            if path.is_file() and real.is_relative_to(root.resolve()):
                known = path.suffix.lower() in _SUFFIXES and not path.name.startswith(".")
                return Companion(PurePosixPath(spelling), path) if known else None
        except (OSError, ValueError, RuntimeError):
            # Nothing can be called so; or symbolic links lead in a circle.
            continue
    return None


def _references(mesh: Path) -> list[str]:
    reader = {".obj": _of_obj, ".dae": _of_dae, ".gltf": _of_gltf}.get(mesh.suffix.lower())
    data = _bytes(mesh) if reader is not None else None
    if reader is None or data is None:
        return []
    return list(islice(dict.fromkeys(reader(data, mesh)), _MOST))


def _bytes(path: Path) -> bytes | None:
    try:
        return path.read_bytes() if path.stat().st_size <= _MAX_BYTES else None
    except OSError:
        return None


def _of_obj(data: bytes, _mesh: Path) -> list[str]:
    found = islice(_LIBRARY.finditer(data), _MOST)
    names = [match[1].decode("utf-8", "replace").strip() for match in found]
    # several names, or names with spaces: whatever there is
    return [name for whole in names for name in _runs(whole.split()[:12])]


def _runs(words: list[str]) -> list[str]:
    """All words and sequences of words, long ones first."""
    return [
        " ".join(words[start : start + length])
        for length in range(len(words), 0, -1)
        for start in range(len(words) - length + 1)
    ]


def _textures(library: Path) -> list[str]:
    data = _bytes(library)
    if data is None:
        return []
    found = islice(_MAP.finditer(data), _MOST)
    lines = [match[1].decode("utf-8", "replace") for match in found]
    # a name may hold spaces
    tails = [
        " ".join(words[k:])
        for line in lines
        for words in (line.split()[-_WORDS:],)
        for k in range(len(words))
    ]
    return list(islice(dict.fromkeys(tails), _MOST))


def _of_dae(data: bytes, mesh: Path) -> list[str]:
    try:
        root = secure_xml.parse(data, mesh)
    except AssetpipeError:
        return []
    found = []
    for element in root.iter():
        if str(element.tag).rpartition("}")[2] in ("init_from", "ref") and element.text:
            text = element.text.strip()
            found.append(text[len("file://") :] if text.startswith("file://") else text)
    return found


def _of_gltf(data: bytes, _mesh: Path) -> list[str]:
    try:
        tree = json.loads(data.decode("utf-8-sig"))
    except (ValueError, RecursionError):
        return []
    found = []
    for name in ("buffers", "images"):
        items = tree.get(name, []) if isinstance(tree, dict) else []
        for item in items if isinstance(items, list) else []:
            uri = item.get("uri") if isinstance(item, dict) else None
            if isinstance(uri, str) and not uri.startswith("data:"):
                found.append(uri)
    return found
