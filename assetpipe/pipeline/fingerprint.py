"""What decides a build of one source, without parsing it as a robot.

Reading a robot costs more than all the rest of an unchanged build; the description's
markup and where its references lead are enough to know that nothing has changed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from assetpipe.errors import AssetpipeError
from assetpipe.pipeline.config import Config
from assetpipe.pipeline.identity import code_stamp, digest_mesh, digest_of, versions
from assetpipe.pipeline.inputs import Source
from assetpipe.robot.markup import Element, read_markup
from assetpipe.robot.resources import Lookup, Resolver


@dataclass(frozen=True)
class Fingerprint:
    """What decides a build.

    Attributes:
        key: digest of all that decides it.
        files: a path by SHA-256, of every file that it refers to.
    """

    key: str
    files: Mapping[str, Path]


def fingerprint(source: Source, config: Config) -> Fingerprint | None:
    """The fingerprint; ``None`` if the source can only be judged by reading it (xacro)."""
    try:
        if source.kind == "mesh":
            references = [(source.path.name, "found", "", digest_mesh(source.path))]
            files = {references[0][3]: source.path}
            text = b""
        elif source.path.suffix.lower() == ".xacro":
            return None
        else:
            text = source.path.read_bytes()
            references, files = _references(source.path, text)
    except (AssetpipeError, OSError):
        return None
    asked = config.as_dict()
    key = digest_of(
        {
            "code": code_stamp(),
            "versions": versions(config.engine),
            "config": asked,
            "limits": config.limits.model_dump(),
            "path": str(source.path),
            "source": text.decode("latin-1"),
            "references": references,
        }
    )
    return Fingerprint(key, files)


def _references(path: Path, text: bytes) -> tuple[list[tuple[str, str, str, str]], dict[str, Path]]:
    """(uri, state, where, digest) of every reference, and the files by digest."""
    lookup = Resolver.from_environment().beside(path)
    found: list[tuple[str, str, str, str]] = []
    files: dict[str, Path] = {}
    for uri in dict.fromkeys(_uris(read_markup(text, path).root)):
        resolution = lookup.resolve(uri)
        digest = ""
        if resolution.path is not None and resolution.path.is_file():
            digest = digest_mesh(resolution.path)
            files[digest] = resolution.path
        found.append((uri, resolution.state, str(resolution.path), digest))
    package = lookup.package
    if package is not None:
        manifest = package.root / "package.xml"
        digest = digest_mesh(manifest) if manifest.is_file() else ""
        found.append((package.name, str(package.declared), str(package.root), digest))
        if digest:
            files[digest] = manifest
    return found, files


def _uris(root: Element) -> Iterator[str]:
    for element in root.walk():
        for value in (element.attributes.get("filename", ""), element.text.strip()):
            if value and (element.attributes.get("filename") == value or "://" in value):
                yield value
