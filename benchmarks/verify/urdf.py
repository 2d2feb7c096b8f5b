"""URDFs read with lxml, and files that they refer to."""

from __future__ import annotations

import re
from pathlib import Path

from lxml import etree

SIMPLE = {
    "box": ["size"],
    "cylinder": ["radius", "length"],
    "capsule": ["radius", "length"],
    "sphere": ["radius"],
}


TOKEN = re.compile(
    rb"<!--.*?-->|<!\[CDATA\[.*?\]\]>|<\?.*?\?>|<collision\b[^>]*?/>|<collision\b|</collision\s*>",
    re.DOTALL,
)


def cut_at_collisions(data: bytes) -> tuple[list[bytes], list[bytes]]:
    """Bytes between the collision elements (one more than these), and the elements."""
    between, elements, last, opened = [], [], 0, None
    for token in TOKEN.finditer(data):
        text = token.group()
        if text.startswith(b"<!--") or text.startswith(b"<!["):
            continue
        if text.startswith(b"<collision") and text.endswith(b"/>"):
            start = token.start()
        elif text.startswith(b"<collision"):
            opened = token.start() if opened is None else opened
            continue
        elif text.startswith(b"</collision") and opened is not None:
            start, opened = opened, None
        else:
            continue
        between.append(data[last:start])
        elements.append(data[start : token.end()])
        last = token.end()
    return [*between, data[last:]], elements


def parse(data: bytes):
    return etree.fromstring(data, etree.XMLParser(recover=True, huge_tree=True))


def collisions(root) -> list[tuple[str, int, object]]:
    """(link, index, element), in document order."""
    return [
        (link.get("name"), index, element)
        for link in root.findall("link")
        for index, element in enumerate(link.findall("collision"))
    ]


def origin(element) -> tuple[float, ...]:
    found = element.find("origin")
    read = (found.get("xyz"), found.get("rpy")) if found is not None else (None, None)
    return tuple(float(v) for text in read for v in (text or "0 0 0").split())


def resolve(uri: str, urdf: Path, ceiling: Path | None = None) -> Path | None:
    """The file that a reference means, from where the URDF lies; nothing above ``ceiling``."""
    folders = [urdf.parent, *urdf.parent.parents]
    if ceiling is not None:
        folders = [f for f in folders if f == ceiling or ceiling in f.parents]
    if uri.startswith("file://"):
        uri = uri[7:]
        tries = [Path(uri)] if uri.startswith("/") else [urdf.parent / uri]
    elif uri.startswith("package://") or uri.startswith("model://"):
        name, _, rest = uri.split("://", 1)[1].partition("/")
        tries = []
        for folder in folders:
            tries.append(folder / name / rest)
            if folder.name == name or package_name(folder) == name:
                tries.append(folder / rest)
        for folder in folders[:4]:
            tries += [child / rest for child in children(folder) if package_name(child) == name]
        tries += [folder / rest for folder in folders]
    else:
        tries = [urdf.parent / uri] if not uri.startswith("/") else [Path(uri)]
    return next((t for t in tries if t.is_file()), None)


def children(folder: Path) -> list[Path]:
    try:
        return sorted(p for p in folder.iterdir() if p.is_dir())
    except OSError:
        return []


def package_name(folder: Path) -> str | None:
    try:
        data = (folder / "package.xml").read_bytes()
        return (parse(data).findtext("name") or "").strip() or None
    except (OSError, etree.XMLSyntaxError, AttributeError):
        return None


def source_of(path: Path) -> bytes:
    """The URDF text; xacro is expanded by xacrodoc."""
    if path.suffix != ".xacro":
        return path.read_bytes()
    from xacrodoc import XacroDoc

    return XacroDoc.from_file(str(path), resolve_packages=False).to_urdf_string().encode()


def elements_of(link) -> list[dict]:
    if isinstance(link, list):
        return link
    return link.get("collisions", link.get("elements", []))
