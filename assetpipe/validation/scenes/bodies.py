"""Bodies of a stated shape: boxes, balls, extrusions, made as meshes."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from assetpipe.errors import ConfigError
from assetpipe.geometry.mesh import FloatArray, Mesh
from assetpipe.validation.contact.probes import Probe
from assetpipe.validation.scenes.asset_spec import AssetSpec

SIDES = 64
"""Sides of a round shape; its polygon is as large outside as inside the circle."""


def body_mesh(spec: AssetSpec) -> Mesh:
    """The mesh of a body whose shape is stated in numbers; centred on its frame.

    Round shapes are polyhedra. Their radius is widened so that their cross-section has
    the true area: they are neither always too thin nor always too thick.

    Raises:
        ConfigError: the outline of an extrusion crosses or touches itself, or runs clockwise.
    """
    if spec.body == "box" and spec.size is not None:
        unit = Probe.box(1.0)
        return Mesh(unit.vertices * np.asarray(spec.size), unit.faces)
    if spec.body == "sphere" and spec.radius is not None:
        return _turned(spec.radius, 0.0)
    if spec.body == "capsule" and spec.radius is not None and spec.length is not None:
        return _turned(spec.radius, spec.length)
    if spec.body == "cylinder" and spec.radius is not None and spec.length is not None:
        angles = np.arange(SIDES) * (2.0 * math.pi / SIDES)
        ring = np.column_stack([np.cos(angles), np.sin(angles)]) * _widened(spec.radius)
        return convex_hull(
            np.vstack(
                [np.column_stack([ring, np.full(SIDES, h * spec.length)]) for h in (-0.5, 0.5)]
            )
        )
    if spec.body == "extrusion" and spec.outline is not None and spec.length is not None:
        return _extruded(np.asarray(spec.outline, dtype=np.float64), spec.length)
    raise ConfigError(f"a '{spec.body}' is not made of numbers")


def is_convex(spec: AssetSpec) -> bool:
    """Whether a body's shape is convex by its kind."""
    return spec.body in ("box", "sphere", "cylinder", "capsule")


def _widened(radius: float) -> float:
    step = 2.0 * math.pi / SIDES
    return radius * math.sqrt(step / math.sin(step))


def _turned(radius: float, length: float) -> Mesh:
    """A ball, or a capsule along z."""
    rows = SIDES // 4
    points = []
    for row in range(2 * rows + 1):
        polar = math.pi * row / (2 * rows)
        shift = 0.5 * length if polar <= math.pi / 2 + 1e-12 else -0.5 * length
        count = SIDES if 0 < row < 2 * rows else 1
        angles = np.arange(count) * (2.0 * math.pi / count)
        ring = np.column_stack(
            [
                math.sin(polar) * np.cos(angles),
                math.sin(polar) * np.sin(angles),
                np.full(count, math.cos(polar)),
            ]
        )
        placed = ring * radius + (0.0, 0.0, shift)
        points.append(placed)
        if length > 0.0 and row == rows:
            points.append(ring * radius - (0.0, 0.0, 0.5 * length))
    return convex_hull(np.vstack(points))


def convex_hull(points: FloatArray) -> Mesh:
    """The convex hull of points (n, 3) with outward faces; inner points stay unused."""
    from scipy.spatial import ConvexHull

    hull = ConvexHull(points)
    faces = np.asarray(hull.simplices, dtype=np.int64)
    centre = points.mean(axis=0)
    a, b, c = (points[faces[:, k]] for k in range(3))
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), a - centre) < 0.0
    faces[inward] = faces[inward][:, ::-1]
    return Mesh(points, faces)


def _extruded(outline: FloatArray, length: float) -> Mesh:
    from manifold3d import CrossSection, FillRule

    x, y = outline.T
    area = 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))
    section = CrossSection([outline], FillRule.NonZero)
    if abs(float(section.area()) - abs(area)) > 1e-6 * abs(area) or section.num_contour() != 1:
        raise ConfigError("the outline of an extrusion crosses or touches itself")
    if area < 0.0:
        raise ConfigError("the outline of an extrusion must run counter-clockwise")
    solid = section.extrude(length).translate([0.0, 0.0, -length / 2.0]).to_mesh64()
    return Mesh(
        np.asarray(solid.vert_properties, dtype=np.float64)[:, :3],
        np.asarray(solid.tri_verts, dtype=np.int64),
    )


def mesh_path(spec: AssetSpec, scene_file: Path | None) -> Path:
    """Where a mesh body's file is: relative to the scene's."""
    return ((scene_file.parent if scene_file else Path()) / str(spec.mesh)).resolve()
