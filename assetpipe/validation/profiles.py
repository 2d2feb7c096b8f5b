"""What an engine accepts of a hull: measured, and held against a profile's rules."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator

from assetpipe.findings import Finding, Severity
from assetpipe.geometry.mesh import FloatArray
from assetpipe.schema import load_yaml
from assetpipe.shipped import find_config
from assetpipe.validation.contact.surface import ConvexShape, facet_planes

Measure = Literal[
    "vertices", "triangles", "polygons", "faces_at_vertex", "insphere_radius", "insphere_ratio"
]

CODES: Mapping[Measure, str] = {
    "vertices": "AP501",
    "triangles": "AP502",
    "polygons": "AP502",
    "faces_at_vertex": "AP504",
    "insphere_radius": "AP503",
    "insphere_ratio": "AP503",
}
"""The finding that breaking a rule about a measure makes."""

_LENGTH = re.compile(r"\s*([0-9.]+(?:[eE][+-]?[0-9]+)?)\s*(mm|cm|m)\s*")


def _number(value: Any) -> Any:
    """A number, or a length such as ``1mm`` in metres."""
    match = _LENGTH.fullmatch(value) if isinstance(value, str) else None
    if match is None:
        return value
    return float(match[1]) * {"m": 1.0, "cm": 1e-2, "mm": 1e-3}[match[2]]


Limit = Annotated[float, BeforeValidator(_number), Field(ge=0.0, allow_inf_nan=False)]


class Rule(BaseModel):
    """One limit on one measure.

    Attributes:
        measure: what is counted or measured; lengths in metres, ratios without a unit.
        at_most: the largest value that passes, or
        at_least: the smallest one; exactly one of the two.
        severity: how much breaking it matters.
        reason: what happens to a hull that breaks it.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    measure: Measure
    at_most: Limit | None = None
    at_least: Limit | None = None
    severity: Severity = Severity.ERROR
    reason: str

    @model_validator(mode="after")
    def _one_limit(self) -> Rule:
        if (self.at_most is None) == (self.at_least is None):
            raise ValueError(f"rule on '{self.measure}' needs either at_most or at_least")
        return self

    def broken_by(self, value: float) -> bool:
        """Whether a value does not pass."""
        if self.at_most is not None:
            return value > self.at_most
        return self.at_least is not None and value < self.at_least

    @property
    def limit(self) -> str:
        """The limit in words."""
        return (
            f"at most {self.at_most:g}"
            if self.at_most is not None
            else (f"at least {self.at_least:g}")
        )


class EngineProfile(BaseModel):
    """The rules of one physics engine."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    name: str
    title: str
    rules: tuple[Rule, ...] = Field(min_length=1)

    @property
    def max_vertices(self) -> int | None:
        """The vertex budget that hulls must meet, for ``max_hull_vertices``."""
        limits = [r.at_most for r in self.rules if r.measure == "vertices" and r.at_most]
        return int(min(limits)) if limits else None


def load_profile(name: str | Path) -> EngineProfile:
    """A profile by its shipped name (``physx_gpu``) or from a YAML file.

    Raises:
        ConfigError: not found, or does not fit; names what is allowed.
    """
    return load_yaml(find_config(name, kind="engines"), EngineProfile)


@dataclass(frozen=True)
class HullMeasures:
    """What a profile's rules ask about a hull.

    Attributes:
        vertices, triangles: as written.
        polygons: facets with coplanar neighbouring triangles taken together.
        faces_at_vertex: the largest number of polygons that meet in a vertex.
        insphere_radius: metres, of the largest ball inside.
        insphere_ratio: that radius over the longest side of the bounding box.
    """

    vertices: int
    triangles: int
    polygons: int
    faces_at_vertex: int
    insphere_radius: float
    insphere_ratio: float


def measure_hull(hull: ConvexShape) -> HullMeasures:
    """Measure a convex hull; vertices that no face uses do not count."""
    faces = np.asarray(hull.faces)
    used = np.unique(faces)
    points = np.asarray(hull.vertices, dtype=np.float64)[used]
    labels = _polygons(hull)
    at_vertex: dict[int, set[int]] = {}
    for face, label in zip(faces.tolist(), labels, strict=True):
        for vertex in face:
            at_vertex.setdefault(vertex, set()).add(label)
    extent = float(np.ptp(points, axis=0).max())
    radius = insphere_radius(hull)
    return HullMeasures(
        vertices=len(used),
        triangles=len(faces),
        polygons=len(set(labels)),
        faces_at_vertex=max(len(found) for found in at_vertex.values()),
        insphere_radius=radius,
        insphere_ratio=radius / extent if extent > 0.0 else 0.0,
    )


def _polygons(hull: ConvexShape) -> list[int]:
    """A label for every triangle; coplanar neighbours share one."""
    vertices = np.asarray(hull.vertices, dtype=np.float64)
    faces = np.asarray(hull.faces)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    area = np.linalg.norm(normals, axis=1)
    normals = normals / np.where(area > 0.0, area, 1.0)[:, None]
    owner: dict[tuple[int, int], int] = {}
    label = list(range(len(faces)))

    def root(face: int) -> int:
        while label[face] != face:
            face = label[face]
        return face

    for index, face in enumerate(faces.tolist()):
        for k in range(3):
            edge = (min(face[k], face[k - 1]), max(face[k], face[k - 1]))
            other = owner.setdefault(edge, index)
            flat = area[index] == 0.0 or area[other] == 0.0
            if other != index and (flat or float(normals[index] @ normals[other]) > 1.0 - 1e-9):
                first, second = sorted((root(index), root(other)))
                label[second] = first
    return [root(face) for face in range(len(faces))]


def insphere_radius(hull: ConvexShape) -> float:
    """Radius of the largest ball inside a hull, metres; 0 for a flat one."""
    return insphere(hull)[1]


def insphere(hull: ConvexShape) -> tuple[FloatArray, float]:
    """Centre (3,) and radius of the largest ball inside a hull, metres.

    The Chebyshev centre as a linear program (Boyd & Vandenberghe 2004, §4.3.1):
    maximise r subject to n·x + r ≤ d for every facet.
    """
    from scipy.optimize import linprog

    vertices: FloatArray = np.asarray(hull.vertices, dtype=np.float64)
    centre: FloatArray = vertices.mean(axis=0)
    size = float(np.ptp(vertices, axis=0).max())
    if not size > 0.0:
        return centre, 0.0
    normals, offsets = facet_planes(hull)
    if len(normals) < 4:
        return centre, 0.0
    # Solved in a centred copy of unit size, for the solver's tolerances are absolute.
    right = (offsets - normals @ centre) / size
    answer = linprog(
        [0.0, 0.0, 0.0, -1.0],
        A_ub=np.hstack([normals, np.ones((len(normals), 1))]),
        b_ub=right,
        bounds=[(None, None)] * 3 + [(0.0, None)],
        method="highs",
    )
    if answer.status != 0:
        return centre, 0.0
    return centre + answer.x[:3] * size, float(answer.x[3]) * size


def check_hulls(
    hulls: Sequence[ConvexShape], profile: EngineProfile, *, link: str | None = None
) -> tuple[Finding, ...]:
    """Hold hulls against a profile; one finding a rule and link, naming the worst hull.

    Args:
        hulls: of one link, in order of their parts.
        profile: see :func:`load_profile`.
        link: for the findings.
    """
    measures = [measure_hull(h) for h in hulls]
    found = []
    for rule in profile.rules:
        values = [float(getattr(m, rule.measure)) for m in measures]
        broken = [i for i, value in enumerate(values) if rule.broken_by(value)]
        if not broken:
            continue
        sign = 1.0 if rule.at_most is not None else -1.0
        worst = max(broken, key=lambda i: sign * values[i])
        found.append(
            Finding(
                CODES[rule.measure],
                rule.severity,
                f"{len(broken)} of {len(hulls)} hulls break {profile.title}'s limit on "
                f"{rule.measure.replace('_', ' ')}: hull {worst} has {values[worst]:.4g}, "
                f"{rule.limit} is allowed",
                link=link,
                hint=rule.reason,
            )
        )
    return tuple(found)
