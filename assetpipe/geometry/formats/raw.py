"""What a format reader hands on: arrays in the file's own unit and axes, and its limits."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from assetpipe.errors import InputError, LimitError, Location
from assetpipe.geometry.mesh import FloatArray, IntArray
from assetpipe.geometry.products import moved

Axis = Literal["X_UP", "Y_UP", "Z_UP"]


@dataclass(frozen=True)
class FileLimits:
    """How much of a stranger's mesh file is read before it is refused.

    Attributes:
        max_bytes: size of the file together with the buffers that it refers to.
        max_faces: triangles of the whole scene, instances counted each time.
        max_vertices: vertices of the whole scene, instances counted each time.
        max_nodes: nodes of the scene graph, instances counted each time.
        max_depth: how deep scene nodes may nest.
    """

    max_bytes: int = 256 * 1024 * 1024
    max_faces: int = 5_000_000
    max_vertices: int = 15_000_000
    max_nodes: int = 100_000
    max_depth: int = 200

    def check(
        self, kind: Literal["bytes", "faces", "vertices", "nodes"], n: int, file: Path
    ) -> None:
        """Refuse more than the limit of this kind.

        Raises:
            LimitError: with the file and both numbers.
        """
        limit = int(getattr(self, f"max_{kind}"))
        if n > limit:
            raise LimitError(f"{n:,} {kind} exceed the limit of {limit:,}", location=Location(file))


@dataclass(frozen=True)
class RawMesh:
    """A mesh before units and axes: all nodes of a scene in one, transforms applied.

    Attributes:
        vertices: (n, 3) in the file's unit and axes.
        faces: (m, 3) indices, counter-clockwise seen from outside.
        metres_per_unit: what one unit of the file is in metres.
        up_axis: the axis that the file declares as up; ``Z_UP`` where the format has none.
        axis_by_habit: the program that wrote the file, where it is known to declare the
            same up-axis whatever the coordinates are; else ``None``.
        notes: what a reader should know: things ignored, oddities accepted.
    """

    vertices: FloatArray
    faces: IntArray
    metres_per_unit: float = 1.0
    up_axis: Axis = "Z_UP"
    axis_by_habit: str | None = None
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Part:
    """Some vertices and the triangles between them."""

    vertices: FloatArray
    faces: IntArray

    def placed(self, matrix: FloatArray) -> Part:
        """The part under a (4, 4) affine matrix; a mirroring one turns the winding."""
        linear = matrix[:3, :3]
        faces = self.faces[:, ::-1] if np.linalg.det(linear) < 0 else self.faces
        return Part(moved(self.vertices, matrix), faces)


def joined(parts: list[Part]) -> Part:
    """All parts as one, in order."""
    if not parts:
        return Part(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64))
    starts = np.cumsum([0] + [len(part.vertices) for part in parts[:-1]])
    return Part(
        np.concatenate([part.vertices for part in parts]),
        np.concatenate([part.faces + start for part, start in zip(parts, starts, strict=True)]),
    )


def floats(text: str | bytes | None, what: str, location: Location) -> FloatArray:
    """White-space separated decimal numbers as a flat array.

    Raises:
        InputError: naming the first word that is no number.
    """
    words = (text or "").split()
    try:
        return np.array(words, dtype=np.float64)
    except (ValueError, OverflowError):
        raise _no_number(words, float, what, location) from None


def integers(text: str | bytes | None, what: str, location: Location) -> IntArray:
    """White-space separated whole numbers of 64 bits as a flat array.

    Raises:
        InputError: naming the first word that is no such number.
    """
    words = (text or "").split()
    try:
        return np.array(words, dtype=np.int64)
    except (ValueError, OverflowError):
        raise _no_number(words, lambda w: np.int64(int(w)), what, location) from None


def _no_number(
    words: Sequence[str | bytes],
    convert: Callable[[str | bytes], object],
    what: str,
    location: Location,
) -> InputError:
    for word in words:
        try:
            convert(word)
        except (ValueError, OverflowError):
            shown = word.decode("utf-8", "replace") if isinstance(word, bytes) else word
            return InputError(f"{what}: '{shown[:40]}' is not a number", location=location)
    return InputError(f"{what}: unreadable numbers", location=location)
