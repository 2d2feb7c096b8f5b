"""What a source's bytes and references lead to, without parsing it as a robot.

Reading a robot costs more than all the rest of an unchanged build; the description's
markup and where its references lead are enough to know that nothing has changed.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from assetpipe.errors import AssetpipeError
from assetpipe.pipeline.identity import digest_mesh, digest_of
from assetpipe.pipeline.inputs import Source
from assetpipe.robot.markup import Element, read_markup
from assetpipe.robot.resources import Resolver


def references(source: Source, expanded: bytes | None = None) -> str | None:
    """A digest; ``None`` if the source cannot be judged (a xacro file before expansion).

    Args:
        source: a robot or a mesh.
        expanded: the URDF, where it is known already.
    """
    text = expanded or b""
    try:
        if source.kind == "mesh":
            found = [(source.path.name, "found", "", digest_mesh(source.path))]
        elif expanded is None and source.path.suffix.lower() == ".xacro":
            return None
        else:
            text = source.path.read_bytes() if expanded is None else expanded
            found = list(_references(source.path, text))
    except (AssetpipeError, OSError):
        return None
    said = {"path": str(source.path), "text": text.decode("latin-1"), "references": found}
    return digest_of(said)


def _references(path: Path, text: bytes) -> Iterator[tuple[str, str, str, str]]:
    """What every reference leads to, with its digest; then the package that it lies in."""
    lookup = Resolver.from_environment().beside(path)
    for uri in dict.fromkeys(_uris(read_markup(text, path).root)):
        resolution = lookup.resolve(uri)
        digest = ""
        if resolution.path is not None and resolution.path.is_file():
            digest = digest_mesh(resolution.path)
        yield uri, resolution.state, str(resolution.path), digest
    package = lookup.package
    if package is not None:
        manifest = package.root / "package.xml"
        digest = digest_mesh(manifest) if manifest.is_file() else ""
        yield package.name, str(package.declared), str(package.root), digest


def _uris(root: Element) -> Iterator[str]:
    for element in root.walk():
        named = element.attributes.get("filename", "")
        if named:
            yield named
        if "://" in element.text:
            yield element.text.strip()
