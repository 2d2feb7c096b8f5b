"""The footprint of a robot: what its links cover on the ground."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from assetpipe import polygon
from assetpipe.errors import InputError, UsageError
from assetpipe.geometry import Mesh, read_mesh
from assetpipe.geometry.mesh import FloatArray
from assetpipe.polygon.outline import load_shapely
from assetpipe.robot.kinematics import forward_kinematics
from assetpipe.robot.model import (
    Box,
    Capsule,
    Cylinder,
    MeshShape,
    OtherShape,
    Robot,
    Shape,
    Sphere,
)

if TYPE_CHECKING:
    import shapely

_ROUND = 64
"""Sides of the polygon around a circle: its radius is 0.12 % too large, never too small."""
_SNAP = 1e-6
"""Vertices are snapped to multiples of this share of the footprint's size before the union, so
that edges shared by triangles meet to the bit; the outline then grows by as much."""
_CONFIGURATIONS = 4096


@dataclass(frozen=True)
class Footprint:
    """What a robot covers on the ground, seen from above; metres in the root link's frame.

    Attributes:
        outline: the union of all projected shapes; a MultiPolygon where they lie apart.
        decomposition: its parts, each within the tolerance of convex.
        inner: a large convex polygon inside it.
        ring: one closed polygon around everything, shape (n, 2), counter-clockwise, at most
            the tolerance larger than the outline; around the outline's convex hull where
            that lies apart.
        links: names of the links that it covers, in the robot's order.
        skipped: why shapes are missing from it, one sentence each.
    """

    outline: shapely.Polygon | shapely.MultiPolygon
    decomposition: polygon.PolygonDecomposition
    inner: shapely.Polygon
    ring: FloatArray
    links: tuple[str, ...]
    skipped: tuple[str, ...]


def configurations(
    robot: Robot, joints: Mapping[str, tuple[float, float]], steps: int = 9
) -> list[dict[str, float]]:
    """Joint positions on a grid over ranges; a range of one value stands still.

    A grid is a sample: between its points a link may reach farther.

    Raises:
        UsageError: a joint does not exist or does not move, or the grid is too fine.
    """
    axes = []
    for name, (low, high) in joints.items():
        robot.joint(name)
        axes.append([low] if low == high else list(np.linspace(low, high, steps)))
    count = int(np.prod([len(axis) for axis in axes], dtype=float))
    if count > _CONFIGURATIONS:
        raise UsageError(
            f"{count} joint configurations are more than {_CONFIGURATIONS}: "
            "give fewer ranges or fewer steps"
        )
    return [dict(zip(joints, values, strict=True)) for values in product(*axes)]


def footprint(
    robot: Robot,
    positions: Iterable[Mapping[str, float]] = ({},),
    *,
    tolerance: float = 0.01,
    below: float | None = None,
    source: Literal["collision", "visual"] = "collision",
) -> Footprint:
    """The footprint of a robot, joined over joint configurations.

    Args:
        robot: as read.
        positions: joint positions, radians or metres; by default the home position alone.
        tolerance: τ of the decomposition and of ``ring``, metres.
        below: leave out shapes that lie wholly at or above this height, metres.
        source: which elements of the links.

    Raises:
        InputError: nothing to project.
        UsageError: a joint or the tolerance is wrong, or shapely is missing.
    """
    shapely = load_shapely()
    if not tolerance > 0.0:
        raise UsageError(f"the footprint's tolerance must be positive, got {tolerance}")
    pieces: list[Any] = []
    links: dict[str, None] = {}
    skipped: dict[str, None] = {}
    meshes: dict[Path, Mesh] = {}
    for configuration in positions:
        poses = forward_kinematics(robot, configuration)
        for link in robot.links:
            for placed in link.collisions if source == "collision" else link.visuals:
                pose = poses[link.name] @ placed.link_from_shape
                try:
                    shadow, lowest = _shadow(placed.shape, pose, meshes)
                except InputError as error:
                    skipped[f"link '{link.name}': {error}"] = None
                    continue
                if below is None or lowest < below:
                    pieces.extend(shadow)
                    links[link.name] = None
    if not pieces:
        raise InputError(f"robot '{robot.name}' has no {source} shape to project")
    outline = _union(pieces)
    return Footprint(
        outline=outline,
        decomposition=polygon.decompose(outline, tolerance),
        inner=polygon.largest_convex_subset(outline),
        ring=_ring_around(shapely, outline, tolerance),
        links=tuple(name.name for name in robot.links if name.name in links),
        skipped=tuple(skipped),
    )


def _union(pieces: Sequence[Any]) -> Any:
    shapely = load_shapely()
    shapes = np.asarray(pieces, dtype=object)
    x0, y0, x1, y1 = shapely.total_bounds(shapes)
    grid = _SNAP * max(x1 - x0, y1 - y0)
    if not grid > 0.0:
        raise InputError("the projected shapes have no area")
    snapped = shapely.transform(shapes, lambda points: np.round(points / grid) * grid)
    joined = shapely.union_all(snapped[shapely.area(snapped) > 0.0])
    # closing gaps of the snapping, and covering what it may have cut off
    grown = joined.buffer(2 * grid, join_style="mitre")
    polygons = [g for g in getattr(grown, "geoms", [grown]) if g.geom_type == "Polygon"]
    return polygons[0] if len(polygons) == 1 else shapely.MultiPolygon(polygons)


def _ring_around(shapely: Any, outline: Any, tolerance: float) -> FloatArray:
    """Grown by half the tolerance, then simplified by no more than that: nothing sticks out."""
    whole = outline if outline.geom_type == "Polygon" else outline.convex_hull
    grown = shapely.Polygon(whole.exterior).buffer(tolerance / 2, join_style="mitre")
    simple = grown.simplify(tolerance / 2)
    if simple.geom_type != "Polygon" or not simple.contains(whole):
        simple = grown
    return np.array(shapely.Polygon(simple.exterior).normalize().exterior.coords[-2::-1])


def _shadow(
    shape: Shape, world_from_shape: FloatArray, meshes: dict[Path, Mesh]
) -> tuple[list[Any], float]:
    """The polygons whose union is the shape's projection, and its lowest height."""
    shapely = load_shapely()
    rotation, origin = world_from_shape[:3, :3], world_from_shape[:3, 3]
    if isinstance(shape, Sphere):
        return [_disc(origin, shape.radius)], float(origin[2] - shape.radius)
    if isinstance(shape, Capsule):
        half = rotation[:, 2] * shape.length / 2
        discs = [_disc(origin + s * half, shape.radius) for s in (-1, 1)]
        lowest = origin[2] - abs(half[2]) - shape.radius
        return [shapely.union_all(discs).convex_hull], float(lowest)
    if isinstance(shape, OtherShape):
        raise InputError(f"shape <{shape.tag}> is not known")
    if isinstance(shape, MeshShape):
        if shape.path is None:
            raise InputError(f"mesh '{shape.uri}' cannot be resolved")
        if shape.path not in meshes:
            meshes[shape.path] = read_mesh(shape.path).mesh
        mesh = meshes[shape.path]
        points = mesh.vertices * np.asarray(shape.scale) @ rotation.T + origin
        return _triangles(points[mesh.faces]), float(points[:, 2].min())
    points = _corners(shape) @ rotation.T + origin
    return [shapely.MultiPoint(points[:, :2]).convex_hull], float(points[:, 2].min())


def _disc(centre: FloatArray, radius: float) -> Any:
    circumscribed = radius / np.cos(np.pi / _ROUND)
    return load_shapely().Point(centre[:2]).buffer(circumscribed, quad_segs=_ROUND // 4)


def _corners(shape: Box | Cylinder) -> FloatArray:
    signs = np.array(list(product((-0.5, 0.5), repeat=3)))
    if isinstance(shape, Box):
        return np.asarray(signs * np.asarray(shape.size), dtype=np.float64)
    angle = np.arange(_ROUND) * 2 * np.pi / _ROUND
    rim = shape.radius / np.cos(np.pi / _ROUND) * np.column_stack([np.cos(angle), np.sin(angle)])
    return np.vstack(
        [np.column_stack([rim, np.full(_ROUND, z * shape.length)]) for z in (-0.5, 0.5)]
    )


def _triangles(corners: FloatArray) -> list[Any]:
    """Projected triangles without those that stand on edge."""
    shapely = load_shapely()
    flat = corners[:, :, :2]
    a, b = flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]
    area = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    size = np.ptp(flat.reshape(-1, 2), axis=0).max(initial=0.0)
    kept = flat[np.abs(area) > 1e-12 * size * size]
    return list(shapely.polygons(kept)) if len(kept) else []
