"""What ``assetpipe decompose`` does with a polygon file."""

from __future__ import annotations

from pathlib import Path
from typing import Any


def decompose_outlines(path: Path, out: Path, given: dict[str, Any]) -> int:
    """Decompose every outline of a file; write parts.geojson into ``out``.

    The file's unit is the metre of ``--tolerance``; a percentage is of an
    outline's bounding-box diagonal. Options that concern meshes are ignored.
    """
    import click
    import numpy as np

    from assetpipe.cli.options import STDOUT, deliver_json
    from assetpipe.decomposition.tolerance import Tolerance
    from assetpipe.polygon.decomposition import decompose
    from assetpipe.polygon.files import read_outlines
    from assetpipe.report.json import write_json

    tolerance = Tolerance.parse(given.get("tolerance") or "1%")
    records: list[dict[str, Any]] = []
    features: list[dict[str, Any]] = []
    for outline in read_outlines(path):
        corners = np.vstack(outline.rings)
        scale = float(np.linalg.norm(np.ptp(corners, axis=0))) if tolerance.unit != "metres" else 1
        found = decompose(list(outline.rings), tolerance.value * scale)
        records.append(
            {
                "outline": outline.name,
                "tolerance": found.tolerance,
                "parts": len(found.parts),
                "concavity": found.concavity,
                "convexity": found.convexity,
            }
        )
        for part, concavity in zip(found.parts, found.concavities, strict=True):
            rings = [
                [list(point) for point in ring.coords] for ring in (part.exterior, *part.interiors)
            ]
            features.append(
                {
                    "type": "Feature",
                    "properties": {"outline": outline.name, "concavity": concavity},
                    "geometry": {"type": "Polygon", "coordinates": rings},
                }
            )
    out.mkdir(parents=True, exist_ok=True)
    write_json(out / "parts.geojson", {"type": "FeatureCollection", "features": features})
    deliver_json(given.get("json_file"), {"outlines": records})
    if given.get("json_file") != STDOUT:
        for record in records:
            click.echo(
                f"{record['outline']}: {record['parts']} parts, "
                f"concavity {record['concavity']:.4g}, "
                f"convexity {record['convexity']:.4f}"
            )
    return 0
