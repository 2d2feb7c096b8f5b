"""One distinct mesh: read → examine → repair → decompose → inner hulls → contact truth.

Runs in a worker process. What goes wrong with the mesh is a finding in the answer;
the hulls are handed over before inner ones are sought and before they are validated, so
that what fails then does not cost them.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from assetpipe.decomposition.tolerance import Tolerance
from assetpipe.errors import AssetpipeError, EngineError, InputError, LimitError, MeshError
from assetpipe.findings import NEGLIGIBLE, Finding, Severity
from assetpipe.geometry.mesh import Mesh
from assetpipe.pipeline.outcome import HullOutcome, MeshOutcome
from assetpipe.pipeline.stages import Reporter

if TYPE_CHECKING:
    from assetpipe.decomposition import Decomposition
    from assetpipe.geometry import Repaired


def answer(request: Mapping[str, Any], reporter: Reporter) -> bytes:
    """See :func:`work`; the request is :meth:`assetpipe.pipeline.plan.MeshJob.request`."""
    return work(request, reporter).encode()


def work(request: Mapping[str, Any], reporter: Reporter) -> MeshOutcome:
    """Everything that is done for one mesh."""
    facts: dict[str, Any] = {}
    findings: list[Finding] = []

    def kept() -> MeshOutcome:
        return MeshOutcome("kept", (), tuple(findings), facts)

    reporter.stage("read")
    mesh = _read(request, facts, findings)
    if mesh is None:
        return kept()
    reporter.stage("repair")
    repaired = _solid(mesh, request, facts, findings)
    if repaired is None or repaired.solid is None or request["until"] == "repair":
        return kept()
    reporter.stage("decompose")
    facts["tolerance"] = Tolerance(*request["params"]["tolerance"]).on(repaired.solid)
    facts["volume"] = repaired.solid.volume
    made = _decompose(repaired, request, facts, findings, reporter)
    if made is None:
        return kept()
    given, solid, hulls = made
    inner: tuple[Mesh, ...] = ()

    def decomposed() -> MeshOutcome:
        return MeshOutcome("decomposed", hulls, tuple(findings), facts, solid, inner)

    if request["params"]["inner"] == "write":
        reporter.partial(decomposed().encode())
        reporter.stage("inner")
        inner = _inner(given, facts, findings, reporter)
    if request["contact"] is not None:
        reporter.partial(decomposed().encode())
        reporter.stage("validate")
        _contact(solid, hulls, request["contact"], facts, findings)
    return decomposed()


def _read(
    request: Mapping[str, Any], facts: dict[str, Any], findings: list[Finding]
) -> Mesh | None:
    from assetpipe.geometry.files import read_mesh
    from assetpipe.geometry.formats.raw import FileLimits

    params = request["params"]
    faces = params["faces"]
    limits = FileLimits(max_bytes=params["file_size"], max_faces=faces, max_vertices=3 * faces)
    try:
        loaded = read_mesh(Path(request["path"]), limits=limits)
        mesh = loaded.mesh.scaled(np.asarray(request["scale"]))
        mesh.check_size()
    except LimitError as error:
        findings.append(Finding("AP206", Severity.ERROR, error.message))
        return None
    except MeshError as error:
        code = "AP205" if "finite" in error.message else "AP102"
        findings.append(Finding(code, Severity.ERROR, error.message))
        return None
    except InputError as error:
        findings.append(Finding("AP102", Severity.ERROR, _relative(error)))
        return None
    facts["faces"] = len(mesh.faces)
    facts["diagonal"] = mesh.diagonal
    facts["notes"] = list(loaded.notes)
    findings += [Finding("AP106", Severity.NOTE, note) for note in loaded.notes]
    return mesh


def _relative(error: AssetpipeError) -> str:
    """The message without this machine's folders; the file is named by the reference."""
    if error.location is None or error.location.line is None:
        return error.message
    return f"line {error.location.line}: {error.message}"


def _solid(
    mesh: Mesh, request: Mapping[str, Any], facts: dict[str, Any], findings: list[Finding]
) -> Repaired | None:
    from assetpipe.geometry import RepairPolicy, examine, repair

    params = request["params"]
    value, unit = params["repair_budget"]
    facts["health"] = examine(mesh).as_dict()
    policy = RepairPolicy(
        mode=params["repair"],
        budget=value,
        budget_unit=unit,
        cavities=params["cavities"],
        openings=params["openings"],
    )
    try:
        repaired = repair(mesh, policy=policy)
    except LimitError as error:
        findings.append(Finding("AP206", Severity.ERROR, error.message))
        return None
    facts["repair"] = repaired.as_dict()
    tolerance = Tolerance(*params["tolerance"]).on(mesh)
    findings += [graded(finding, repaired.moved, tolerance) for finding in repaired.findings]
    if repaired.solid is None and not any(f.severity is Severity.ERROR for f in repaired.findings):
        findings.append(Finding("AP202", Severity.ERROR, "the mesh cannot be made a solid"))
    return repaired


def _percent(share: float) -> str:
    """Two digits, and no powers of ten."""
    return f"{100 * share:.2g}%" if share < 0.995 else f"{100 * share:.0f}%"


def graded(finding: Finding, moved: float, tolerance: float) -> Finding:
    """A repair's finding, weighed by what the user asked for.

    AP201 is a warning where the surface moved by more than ``NEGLIGIBLE`` of the tolerance:
    below that, what repair did is lost in what decomposition may do.

    Args:
        finding: of the repair.
        moved: upper bound on how far the surface moved, metres.
        tolerance: metres.
    """
    if finding.code != "AP201" or moved == 0.0:
        return finding
    severity = Severity.WARNING if moved > NEGLIGIBLE * tolerance else Severity.NOTE
    message = (
        f"{finding.message}; the surface moved by at most {moved * 1000:.3g} mm, "
        f"{_percent(moved / tolerance)} of the tolerance"
    )
    return replace(finding, severity=severity, message=message)


def _decompose(
    repaired: Repaired,
    request: Mapping[str, Any],
    facts: dict[str, Any],
    findings: list[Finding],
    reporter: Reporter,
) -> tuple[Mesh, Mesh, tuple[HullOutcome, ...]] | None:
    """The solid, the same with what was closed, and the hulls that stand for the latter."""
    from assetpipe.decomposition import decompose_with

    params = request["params"]
    try:
        result: Decomposition = decompose_with(
            params["engine"],
            repaired,
            Tolerance(*params["tolerance"]),
            metric=params["metric"],
            effort=params["effort"],
            seed=params["seed"],
            threads=int(os.environ.get("ASSETPIPE_THREADS", "1")),
            max_hulls=params["max_hulls"],
            max_hull_vertices=params["max_hull_vertices"],
            cavities="keep",  # repair has filled them, if that was asked
            shapes=params["shapes"],
            overlap=params["overlap"],
            reach=params["reach"],
            on_progress=lambda done: reporter.stage("decompose", float(done)),
        )
    except LimitError as error:
        findings.append(Finding("AP301", Severity.ERROR, error.message))
        return None
    except EngineError as error:
        findings.append(Finding("AP901", Severity.ERROR, error.message))
        return None
    except MeshError as error:
        findings.append(Finding("AP303", Severity.ERROR, error.message))
        return None
    hulls = tuple(
        HullOutcome(
            Mesh(hull.vertices, hull.faces),
            (hull.certificate.thickening.lower, hull.certificate.thickening.upper),
            (hull.certificate.concavity.lower, hull.certificate.concavity.upper)
            if hull.certificate.concavity
            else None,
            hull.primitive,
        )
        for hull in result.hulls
    )
    if not hulls:
        findings.append(Finding("AP303", Severity.ERROR, "the engine returned no hull"))
        return None
    facts["certificate"] = result.certificate.as_dict()
    facts["coverage"] = result.coverage.as_dict()
    facts["hulls"] = len(hulls)
    if params["shapes"] != "hulls":
        facts["primitives"] = [h.primitive.as_dict() if h.primitive else None for h in hulls]
    if result.closed is not None:
        facts["closed"] = result.closed.as_dict()
    if result.seams is not None:
        facts["seams"] = result.seams.as_dict()
    facts["hull_vertices"] = sum(len(h.mesh.vertices) for h in hulls)
    allowed = facts["tolerance"]
    bound = result.certificate.upper
    if params["engine"] == "assetpipe" and params["metric"] == "concavity":
        bound = result.certificate.concavity.upper if result.certificate.concavity else bound
    if bound > allowed * (1 + 1e-9):
        findings.append(
            Finding(
                "AP302",
                Severity.WARNING,
                f"certified {params['metric']} {bound * 1000:.3g} mm exceeds the tolerance "
                f"{allowed * 1000:.3g} mm with {len(hulls)} hulls",
                hint=_budget_hint(params),
            )
        )
    assert result.solid is not None  # noqa: S101 - only stored results lack it
    return result.solid, result.closed_solid or result.solid, hulls


def _inner(
    solid: Mesh, facts: dict[str, Any], findings: list[Finding], reporter: Reporter
) -> tuple[Mesh, ...]:
    """What :attr:`assetpipe.Decomposition.inner` holds: about the mesh after repair, without
    what nothing can reach."""
    from assetpipe.decomposition.inner import inner_hulls, united_volume

    try:
        found = inner_hulls(
            solid,
            0.5 * facts["tolerance"],
            on_progress=lambda done: reporter.stage("inner", float(done)),
        )
    except (EngineError, LimitError, MeshError) as error:
        told = f"inner hulls could not be computed: {error.message}"
        findings.append(Finding("AP305", Severity.WARNING, told))
        return ()
    if not found:
        findings.append(Finding("AP305", Severity.NOTE, "no convex polytope was found inside"))
    volume = united_volume(found)
    facts["inner"] = {
        "hulls": len(found),
        "vertices": sum(len(hull.vertices) for hull in found),
        "volume": volume,
        "share": volume / solid.volume,
    }
    return tuple(hull.mesh for hull in found)


def _budget_hint(params: Mapping[str, Any]) -> str:
    if params["engine"] != "assetpipe":
        return f"engine {params['engine']} does not bound what it does"
    if params["max_hulls"] is not None or params["max_hull_vertices"] is not None:
        return "allow more hulls or vertices, or a larger tolerance"
    return "allow a larger tolerance"


def _contact(
    solid: Mesh,
    hulls: tuple[HullOutcome, ...],
    settings: Mapping[str, Any],
    facts: dict[str, Any],
    findings: list[Finding],
) -> None:
    from assetpipe.validation.contact import contact_truth

    try:
        truth = contact_truth(
            solid,
            [hull.mesh for hull in hulls],
            max(hull.thickening[1] for hull in hulls),
            samples=settings["samples"],
            seed=settings["seed"],
        )
    except AssetpipeError as error:
        findings.append(
            Finding("AP411", Severity.WARNING, f"contact truth could not be told: {error.message}")
        )
        return
    facts["contact"] = truth.as_dict()
    findings += truth.findings()
