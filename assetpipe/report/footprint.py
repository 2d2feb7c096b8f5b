"""A footprint as JSON, SVG, picture and Nav2 parameters."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import Any

from assetpipe.robot.footprint import Footprint

_COLOURS = ("#4477aa", "#66ccee", "#228833", "#ccbb44", "#ee6677", "#aa3377", "#bbbbbb")


def as_record(robot: str, footprint: Footprint) -> dict[str, Any]:
    """A JSON-ready mapping; rings are lists of [x, y] in metres, not closed."""
    parts = zip(footprint.decomposition.parts, footprint.decomposition.concavities, strict=True)
    return {
        "robot": robot,
        "tolerance": footprint.decomposition.tolerance,
        "area": footprint.outline.area,
        "outline": [_rings(piece) for piece in _polygons(footprint.outline)],
        "ring": footprint.ring.tolist(),
        "parts": [
            {"rings": _rings(part), "area": part.area, "concavity": concavity}
            for part, concavity in parts
        ],
        "concavity": footprint.decomposition.concavity,
        "convexity": footprint.decomposition.convexity,
        "inner": {"rings": _rings(footprint.inner), "area": footprint.inner.area},
        "links": list(footprint.links),
        "skipped": list(footprint.skipped),
    }


def nav2(footprint: Footprint) -> str:
    """Costmap parameters for Nav2; ``footprint`` is a string there, by its own convention."""
    points = ", ".join(f"[{x:.4f}, {y:.4f}]" for x, y in footprint.ring)
    text = "# around everything the robot covers, in the frame of its root link, metres\n"
    for costmap in ("local_costmap", "global_costmap"):
        text += f'{costmap}:\n  {costmap}:\n    ros__parameters:\n      footprint: "[{points}]"\n'
    return text


def svg(footprint: Footprint) -> str:
    """Parts in colours, the outline black, the inner polygon dashed; y points up."""
    x0, y0, x1, y1 = footprint.outline.bounds
    margin = 0.05 * max(x1 - x0, y1 - y0)
    width, height = x1 - x0 + 2 * margin, y1 - y0 + 2 * margin
    line = 0.004 * max(width, height)
    body = [
        f'<path d="{_path(part)}" fill="{_COLOURS[k % len(_COLOURS)]}" fill-opacity="0.6"/>'
        for k, part in enumerate(footprint.decomposition.parts)
    ]
    outlines = " ".join(_path(piece) for piece in _polygons(footprint.outline))
    body.append(f'<path d="{outlines}" fill="none" stroke="black" stroke-width="{line:.6g}"/>')
    body.append(
        f'<path d="{_path(footprint.inner)}" fill="none" stroke="black" '
        f'stroke-width="{line:.6g}" stroke-dasharray="{4 * line:.6g}"/>'
    )
    view = f"{x0 - margin:.6g} {-y1 - margin:.6g} {width:.6g} {height:.6g}"
    inner = "\n".join(body)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{view}" width="800">\n'
        f'<g transform="scale(1 -1)" fill-rule="evenodd">\n{inner}\n</g>\n</svg>\n'
    )


def can_draw() -> bool:
    """Whether matplotlib is installed."""
    return find_spec("matplotlib") is not None


def write_picture(path: Path, footprint: Footprint) -> None:
    """The same as a PNG."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6, 6), dpi=120, layout="constrained")
    axes = figure.add_subplot()
    for k, part in enumerate(footprint.decomposition.parts):
        axes.fill(*part.exterior.xy, color=_COLOURS[k % len(_COLOURS)], alpha=0.6, lw=0)
    for piece in _polygons(footprint.outline):
        for ring in (piece.exterior, *piece.interiors):
            axes.plot(*ring.xy, color="black", lw=1)
    axes.plot(*footprint.inner.exterior.xy, color="black", lw=1, ls="--")
    axes.set_aspect("equal")
    axes.set_xlabel("x (m)")
    axes.set_ylabel("y (m)")
    figure.savefig(path)


def _polygons(shape: Any) -> list[Any]:
    return list(getattr(shape, "geoms", [shape]))


def _rings(shape: Any) -> list[list[list[float]]]:
    return [
        [[float(x), float(y)] for x, y in ring.coords[:-1]]
        for ring in (shape.exterior, *shape.interiors)
    ]


def _path(shape: Any) -> str:
    return " ".join(
        "M" + " L".join(f"{x:.6g},{y:.6g}" for x, y in ring) + " Z" for ring in _rings(shape)
    )
