"""What is wrong or odd about single elements of a URDF, each as the end of a sentence."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from typing import Any, get_args

import numpy as np

from assetpipe.robot.markup import Element
from assetpipe.robot.model import JointType
from assetpipe.robot.values import COUNTS, KNOWN_SHAPES, Unreadable, shape_of


def wrong_shape(element: Element, parsed: Any) -> str | None:
    """Why a collision or visual element cannot be used, or ``None``.

    Args:
        element: the element.
        parsed: what :func:`assetpipe.robot.values.parse_shapes` made of it.
    """
    shape = shape_of(element)
    if element.first("geometry") is None:
        return "has no <geometry>"
    if shape is None:
        return "has no shape in its <geometry>"
    if shape.tag not in KNOWN_SHAPES:
        return f"has an unknown shape <{shape.tag}>"
    if isinstance(parsed, Unreadable):
        return f"cannot be read: {parsed.reason}"
    if shape.tag == "mesh" and not shape.attributes.get("filename", "").strip():
        return "names no mesh file"
    count = len(shape.attributes.get("scale", "1").replace(",", " ").split())
    if shape.tag == "mesh" and count == 2:
        return f"has a scale of 2 numbers: '{shape.attributes['scale'][:60]}'"
    sizes = [
        np.asarray(value, dtype=np.float64)
        for kind in vars(parsed.geometry).values()
        if kind is not None
        for value in vars(kind).values()
        if value is not None and not isinstance(value, str)
    ]
    if not _finite([*sizes, parsed.origin]):
        return "has a number that is not finite"
    if shape.tag == "box" and sizes[0].shape != (3,):
        return f"has a box with {sizes[0].size} lengths instead of 3"
    if shape.tag == "mesh":
        return "has a scale of zero" if any((size == 0.0).any() for size in sizes) else None
    return "has a negative size" if any((size < 0.0).any() for size in sizes) else None


def wrong_joint(parsed: Any, links: Collection[str]) -> str | None:
    """Why a joint cannot be used, or ``None``.

    Args:
        parsed: what :func:`assetpipe.robot.values.parse_joints` made of it.
        links: names of the links.
    """
    if isinstance(parsed, Unreadable):
        return f"cannot be read: {parsed.reason}"
    if parsed.type not in get_args(JointType):
        return f"has type '{parsed.type}', none of {', '.join(get_args(JointType))}"
    for role, link in (("parent", parsed.parent), ("child", parsed.child)):
        if link not in links:
            return f"has {role} '{link}', which is no link"
    if np.shape(parsed.axis) != (3,):
        return f"has an axis of {np.size(parsed.axis)} numbers instead of 3"
    if not _finite([parsed.axis, parsed.origin]):
        return "has a number that is not finite"
    if parsed.type not in ("fixed", "floating") and not np.linalg.norm(parsed.axis) > 0.0:
        return "has an axis of length zero"
    return None


def odd_shape(element: Element) -> Iterable[str]:
    """What other programs may read differently in a collision or visual element."""
    geometry = element.first("geometry")
    if geometry is not None and len(geometry.children) > 1:
        yield f"has {len(geometry.children)} shapes in its <geometry>; the first one counts"
    shape = shape_of(element)
    yield from odd_numbers([*([shape] if shape is not None else []), *element.all("origin")])


def odd_numbers(elements: Sequence[Element]) -> Iterable[str]:
    """Attributes with more numbers than they should have, or with commas."""
    for element in elements:
        for name, count in COUNTS.items():
            text = element.attributes.get(name, "")
            given = len(text.replace(",", " ").split())
            if given > count:
                yield f"has {given} numbers in {name}='{text[:60]}'; the first {count} count"
            elif "," in text:
                yield f"has commas in {name}='{text[:60]}'"


def _finite(values: Iterable[Any]) -> bool:
    return all(np.isfinite(np.asarray(v, dtype=np.float64)).all() for v in values if v is not None)
