"""One link, the original against what was built: certificate and contact truth.

Runs in a worker process. The answer is an outcome in the link's frame.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from assetpipe.errors import AssetpipeError, MeshError
from assetpipe.findings import Finding, Severity
from assetpipe.geometry.mesh import Mesh
from assetpipe.pipeline.outcome import HullOutcome, MeshOutcome
from assetpipe.pipeline.stages import Reporter

if TYPE_CHECKING:
    from assetpipe.geometry import RepairPolicy


def answer(request: Mapping[str, Any], reporter: Reporter) -> bytes:
    """Compare.

    Request keys: ``before`` and ``after``, lists of ``{file, scale, matrix}``, in ``after``
    also of ``{kind, size, matrix}`` for simple shapes; ``contact``
    with ``samples`` and ``seed``; ``cavities``; ``openings``; ``reach``.
    """
    from assetpipe.decomposition import close_unreachable
    from assetpipe.geometry import RepairPolicy

    findings: list[Finding] = []
    facts: dict[str, Any] = {}
    try:
        reporter.stage("repair")
        policy = RepairPolicy(cavities=request["cavities"], openings=request["openings"])
        solid = _solid(request["before"], policy)
        if request["reach"] > 0.0:
            reporter.stage("reach")
            closed = close_unreachable(solid, request["reach"])
            solid, facts["closed"] = closed.solid, closed.closing.as_dict()
        hulls = [
            _simple(item) if "kind" in item else _convex(_placed(item)) for item in request["after"]
        ]
        reporter.stage("certify")
        outcome = _certified(solid, hulls, facts, reporter)
        reporter.partial(outcome.encode())
        reporter.stage("validate")
        findings += _contact(outcome, request["contact"], facts)
    except AssetpipeError as error:
        findings.append(
            Finding("AP411", Severity.WARNING, f"could not be compared: {error.message}")
        )
        return MeshOutcome("kept", (), tuple(findings), facts).encode()
    return MeshOutcome("decomposed", outcome.hulls, tuple(findings), facts, solid).encode()


def _placed(item: Mapping[str, Any]) -> Mesh:
    from assetpipe.geometry.files import read_mesh

    mesh = read_mesh(Path(item["file"])).mesh.scaled(np.asarray(item["scale"]))
    return mesh.transformed(np.asarray(item["matrix"]))


def _simple(item: Mapping[str, Any]) -> Mesh:
    """The polytope around a simple shape: what holds for it holds for the shape."""
    from assetpipe.decomposition import Primitive

    shape = Primitive(item["kind"], np.array(item["matrix"]), tuple(item["size"]))
    return shape.polytope()


def _solid(items: Sequence[Mapping[str, Any]], policy: RepairPolicy) -> Mesh:
    """All original meshes of the link as one solid."""
    from assetpipe.geometry import repair

    solids: list[Mesh] = []
    for item in items:
        solid = repair(_placed(item), policy=policy).solid
        if solid is None:
            raise MeshError(f"'{Path(item['file']).name}' cannot be made a solid")
        solids.append(solid)
    if len(solids) == 1:
        return solids[0]
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in solids[:-1])])
    joined = Mesh(
        np.vstack([mesh.vertices for mesh in solids]),
        np.vstack([mesh.faces + start for mesh, start in zip(solids, starts, strict=True)]),
    )
    united = repair(joined, policy=policy).solid
    if united is None:
        raise MeshError(f"its {len(solids)} meshes cannot be united to one solid")
    return united


def _convex(mesh: Mesh) -> Mesh:
    """What a physics engine makes of a collision mesh: its convex hull."""
    from assetpipe import _core

    vertices, faces = _core.convex_hull(np.ascontiguousarray(mesh.vertices))
    return Mesh(vertices, faces)


def _certified(
    solid: Mesh, hulls: Sequence[Mesh], facts: dict[str, Any], reporter: Reporter
) -> MeshOutcome:
    from assetpipe.decomposition import certify

    certificates = certify(
        solid, hulls, on_progress=lambda done: reporter.stage("certify", float(done))
    )
    upper = max((c.upper for c in certificates), default=0.0)
    facts["hulls"] = len(hulls)
    facts["hull_vertices"] = sum(len(mesh.vertices) for mesh in hulls)
    facts["certificate"] = {
        "thickening": {"lower": max((c.lower for c in certificates), default=0.0), "upper": upper}
    }
    return MeshOutcome(
        "decomposed",
        tuple(
            HullOutcome(mesh, (c.lower, c.upper))
            for mesh, c in zip(hulls, certificates, strict=True)
        ),
        (),
        facts,
        solid,
    )


def _contact(
    outcome: MeshOutcome, settings: Mapping[str, Any] | None, facts: dict[str, Any]
) -> tuple[Finding, ...]:
    from assetpipe.validation import contact_truth

    if settings is None or outcome.solid is None:
        return ()
    truth = contact_truth(
        outcome.solid,
        [hull.mesh for hull in outcome.hulls],
        max(hull.thickening[1] for hull in outcome.hulls),
        samples=settings["samples"],
        seed=settings["seed"],
    )
    facts["contact"] = truth.as_dict()
    return truth.findings()
