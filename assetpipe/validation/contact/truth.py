"""Contact truth: what a hull set answers against what the solid itself answers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from assetpipe.errors import UsageError
from assetpipe.findings import Finding, Severity
from assetpipe.geometry.mesh import FloatArray, Mesh
from assetpipe.validation.contact.coverage import Coverage, cover
from assetpipe.validation.contact.probes import Pose, Probe, near_contact, probe_set
from assetpipe.validation.contact.surface import (
    ConvexShape,
    Frame,
    Surface,
    convex_geometry,
    outside_hulls,
)
from assetpipe.validation.statistics import Distribution, Rate

Verdict = Literal["agree", "false", "missed", "undecided"]

DEAD_BAND = 1e-7
"""Share of the body's diagonal around zero in which yes and no cannot be told apart."""


@dataclass(frozen=True)
class ProbeTally:
    """What one probe shape found."""

    kind: str
    size: float
    tested: int
    false_contacts: Rate
    missed_contacts: Rate
    undecided: Rate

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready."""
        return {
            "kind": self.kind,
            "size": self.size,
            "tested": self.tested,
            "false_contacts": self.false_contacts.as_dict(),
            "missed_contacts": self.missed_contacts.as_dict(),
            "undecided": self.undecided.as_dict(),
        }


@dataclass(frozen=True)
class Witness:
    """A pose that shows a fault: probe, its size, pose and the two clearances, metres."""

    kind: str
    size: float
    position: tuple[float, float, float]
    rotation: tuple[tuple[float, float, float], ...]
    solid_clearance: float
    hull_clearance: float

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready."""
        return {
            "kind": self.kind,
            "size": self.size,
            "position": list(self.position),
            "rotation": [list(row) for row in self.rotation],
            "solid_clearance": self.solid_clearance,
            "hull_clearance": self.hull_clearance,
        }


@dataclass(frozen=True)
class ContactTruth:
    """The hulls' answers against the solid's, over poses near contact.

    Attributes:
        samples: poses tested; seed: of the sampling.
        allowed: metres, the certificate's upper bound plus what repair may have moved.
        certificate: metres, upper bound of the hulls' thickening.
        dead_band: metres around zero in which an answer reads "undecided".
        false_contacts: of the poses that are free of the solid, those that touch a hull.
        missed_contacts: of the poses that touch the solid, those free of all hulls.
        undecided: of all poses.
        clearance_error: metres, the solid's clearance minus the hulls': positive where
            the hulls are nearer, which is safe, negative where they are farther.
        false_depth: metres by which false contacts penetrate the hulls (convex–convex);
            not bounded by the certificate: a long narrow gap filled up is deep.
        beyond: poses whose clearance error exceeds ``allowed``: must be 0.
        worst: the pose with the largest clearance error.
        coverage: points of the solid outside the hulls.
        probes: the same counts by probe shape.
    """

    samples: int
    seed: int
    allowed: float
    certificate: float
    dead_band: float
    false_contacts: Rate
    missed_contacts: Rate
    undecided: Rate
    clearance_error: Distribution
    false_depth: Distribution
    beyond: Rate
    worst: Witness | None
    missed: Witness | None
    coverage: Coverage
    probes: tuple[ProbeTally, ...]

    @property
    def holds(self) -> bool:
        """Whether certificate and coverage held in every sample."""
        return not (self.beyond.count or self.missed_contacts.count) and self.coverage.complete

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready."""
        return {
            "samples": self.samples,
            "seed": self.seed,
            "allowed": self.allowed,
            "certificate": self.certificate,
            "dead_band": self.dead_band,
            "false_contacts": self.false_contacts.as_dict(),
            "missed_contacts": self.missed_contacts.as_dict(),
            "undecided": self.undecided.as_dict(),
            "clearance_error": self.clearance_error.as_dict(),
            "false_depth": self.false_depth.as_dict(),
            "beyond_certificate": self.beyond.as_dict(),
            "worst": self.worst.as_dict() if self.worst else None,
            "missed": self.missed.as_dict() if self.missed else None,
            "coverage": self.coverage.as_dict(),
            "probes": [p.as_dict() for p in self.probes],
            "holds": self.holds,
        }

    def findings(self, link: str | None = None) -> tuple[Finding, ...]:
        """What went wrong, as findings about ``link``; empty where all held."""
        found = []
        if self.beyond.count:
            found.append(
                Finding(
                    "AP401",
                    Severity.ERROR,
                    f"clearance differs by {_mm(self.clearance_error.greatest)}, allowed is "
                    f"{_mm(self.allowed)} ({self.beyond.count} of {self.beyond.of} poses)",
                    link=link,
                    hint="this breaks the certificate: please report it with the mesh",
                )
            )
        if not self.coverage.complete:
            found.append(
                Finding(
                    "AP404",
                    Severity.ERROR,
                    f"{self.coverage.surface.count} of {self.coverage.surface.of} surface and "
                    f"{self.coverage.interior.count} of {self.coverage.interior.of} interior "
                    f"points lie outside every hull, the farthest by {_mm(self.coverage.gap)}",
                    link=link,
                )
            )
        if self.missed_contacts.count:
            found.append(
                Finding(
                    "AP405",
                    Severity.ERROR,
                    f"{self.missed_contacts.count} of {self.missed_contacts.of} contacts with "
                    "the original are no contacts with the hulls",
                    link=link,
                )
            )
        return tuple(found)


def _mm(metres: float) -> str:
    return f"{metres * 1000:.4g} mm"


@dataclass(frozen=True)
class _Answers:
    """Clearances of every pose, (n,) metres; 0 means contact."""

    solid: FloatArray
    hulls: FloatArray
    depth: FloatArray


def contact_truth(
    solid: Mesh,
    hulls: Sequence[ConvexShape],
    certificate_upper: float,
    *,
    samples: int = 600,
    seed: int = 0,
    moved: float = 0.0,
) -> ContactTruth:
    """Compare hulls with the solid that they stand for, near contact.

    For every pose of a probe P, d(P, hulls) ≤ d(P, solid) because the hulls cover the
    solid, and d(P, solid) ≤ d(P, hulls) + thickening because every hull point is that
    near to the solid. Both are tested; a breach is a fault of ours and a finding.

    Args:
        solid: the original, a closed mesh in metres (for an open one the generalized
            winding number decides what is inside).
        hulls: convex shapes with ``vertices`` and outward ``faces``, same frame.
        certificate_upper: certified upper bound of the hulls' thickening, metres.
        samples: number of poses.
        seed: of the sampling; equal seeds, equal results.
        moved: metres by which repair moved the surface, if ``solid`` is the raw mesh.

    Raises:
        UsageError: a negative or non-finite bound, no samples.
        MeshError: ``solid`` is empty or one point; there are no hulls.
    """
    if not (0.0 <= certificate_upper < np.inf and 0.0 <= moved < np.inf):
        raise UsageError("certificate_upper and moved must be finite and not negative")
    if samples < 1:
        raise UsageError(f"samples must be at least 1, not {samples}")
    rng = np.random.default_rng(seed)
    everything = np.vstack([solid.vertices, *(h.vertices for h in hulls)])
    frame = Frame.around(everything)
    surface = Surface(solid.vertices, solid.faces, frame)
    dead = DEAD_BAND * solid.diagonal
    # A certificate of the body's own size must not push the probes out of its openings.
    band = min(max(certificate_upper, 1e-3 * solid.diagonal), 0.02 * solid.diagonal)
    probes = probe_set(solid.diagonal, band)
    poses = near_contact(
        surface, hulls, probes, samples=samples, band=band, away=4.0 * dead, rng=rng
    )
    answers = _ask(surface, hulls, probes, poses)
    coverage = cover(surface, hulls, samples=max(samples, 200), band=dead + moved, rng=rng)
    return _tally(
        answers,
        probes,
        poses,
        coverage,
        seed=seed,
        certificate=certificate_upper,
        moved=moved,
        dead=dead,
    )


def _ask(
    solid: Surface, hulls: Sequence[ConvexShape], probes: Sequence[Probe], poses: Sequence[Pose]
) -> _Answers:
    import fcl

    frame = solid.frame
    joined = Surface.of_hulls(hulls, frame)
    movers = [fcl.CollisionObject(p.geometry(frame)) for p in probes]
    centres = np.array([pose.position for pose in poses]).reshape(-1, 3)
    # A probe that meets no surface is wholly inside or wholly outside, so its centre tells.
    inside_solid = solid.winding(centres) > 0.5
    inside_hulls = outside_hulls(centres, hulls) < 0.0
    depths = _Depths(hulls, probes, frame)
    solid_clear, hull_clear, depth = (np.zeros(len(poses)) for _ in range(3))
    for i, pose in enumerate(poses):
        mover = movers[pose.probe]
        placed = fcl.Transform(pose.rotation, frame.points(pose.position))
        mover.setTransform(placed)
        if not (inside_solid[i] or solid.crosses(mover)):
            solid_clear[i] = solid.gap(mover)
        if not (inside_hulls[i] or joined.crosses(mover)):
            hull_clear[i] = joined.gap(mover)
        elif solid_clear[i] > 0.0:
            depth[i] = depths.of(pose, placed)
    return _Answers(solid_clear, hull_clear, depth)


class _Depths:
    """Penetration depth of a probe in the hulls: convex–convex, as FCL alone can give it.

    An upper estimate (minkowski portal refinement), told but never judged by.
    """

    def __init__(self, hulls: Sequence[ConvexShape], probes: Sequence[Probe], frame: Frame) -> None:
        import fcl

        self._frame = frame
        self._hulls = [
            fcl.CollisionObject(convex_geometry(frame.points(h.vertices), h.faces)) for h in hulls
        ]
        self._boxes = [
            (frame.points(h.vertices).min(axis=0), frame.points(h.vertices).max(axis=0))
            for h in hulls
        ]
        self._probes = [fcl.CollisionObject(p.solid_geometry(frame)) for p in probes]
        self._radius = [
            frame.scale
            * (p.size if p.kind == "sphere" else np.linalg.norm(p.vertices, axis=1).max())
            for p in probes
        ]

    def of(self, pose: Pose, placed: Any) -> float:
        import fcl

        probe, radius = self._probes[pose.probe], self._radius[pose.probe]
        probe.setTransform(placed)
        at, deepest = self._frame.points(pose.position), 0.0
        for hull, (low, high) in zip(self._hulls, self._boxes, strict=True):
            if (at < low - radius).any() or (at > high + radius).any():
                continue
            result = fcl.CollisionResult()
            request = fcl.CollisionRequest(num_max_contacts=1, enable_contact=True)
            fcl.collide(hull, probe, request, result)
            for contact in result.contacts:
                # The sign of the depth depends on the solver.
                deepest = max(deepest, abs(float(contact.penetration_depth)))
        return self._frame.metres(deepest)


def _verdicts(answers: _Answers, dead: float, moved: float) -> list[Verdict]:
    verdicts: list[Verdict] = []
    for s, h, depth in zip(answers.solid, answers.hulls, answers.depth, strict=True):
        if s > 0.0 and h == 0.0:
            verdicts.append("false" if s > dead and depth > dead else "undecided")
        elif s == 0.0 and h > 0.0:
            verdicts.append("missed" if h > dead + moved else "undecided")
        elif s > 0.0 and min(s, h) <= dead:
            verdicts.append("undecided")
        else:
            verdicts.append("agree")
    return verdicts


def _tally(
    answers: _Answers,
    probes: Sequence[Probe],
    poses: Sequence[Pose],
    coverage: Coverage,
    *,
    seed: int,
    certificate: float,
    moved: float,
    dead: float,
) -> ContactTruth:
    allowed = certificate + moved
    verdict = np.array(_verdicts(answers, dead, moved), dtype=object)
    free = answers.solid > 0.0
    error = (answers.solid - answers.hulls)[free]
    which = np.array([p.probe for p in poses])

    def rates(mask: Any) -> tuple[Rate, Rate, Rate]:
        counted = [int(np.count_nonzero(mask & (verdict == v))) for v in ("false", "missed")]
        undecided = int(np.count_nonzero(mask & (verdict == "undecided")))
        return (
            Rate.wilson(counted[0], int(np.count_nonzero(mask & free))),
            Rate.wilson(counted[1], int(np.count_nonzero(mask & ~free))),
            Rate.wilson(undecided, int(np.count_nonzero(mask))),
        )

    tallies = tuple(
        ProbeTally(p.kind, p.size, int(np.count_nonzero(which == k)), *rates(which == k))
        for k, p in enumerate(probes)
    )
    everything = rates(np.ones(len(poses), dtype=bool))
    beyond = Rate.wilson(int(np.count_nonzero(error > allowed + dead)), len(error))
    widest = int(np.flatnonzero(free)[int(np.argmax(error))]) if error.size else None
    lost = np.flatnonzero(verdict == "missed")
    return ContactTruth(
        samples=len(poses),
        seed=seed,
        allowed=allowed,
        certificate=certificate,
        dead_band=dead,
        false_contacts=everything[0],
        missed_contacts=everything[1],
        undecided=everything[2],
        clearance_error=Distribution.over(error),
        false_depth=Distribution.over(answers.depth[verdict == "false"]),
        beyond=beyond,
        worst=None if widest is None else _witness(probes, poses[widest], answers, widest),
        missed=_witness(probes, poses[lost[0]], answers, int(lost[0])) if lost.size else None,
        coverage=coverage,
        probes=tallies,
    )


def _witness(probes: Sequence[Probe], pose: Pose, answers: _Answers, index: int) -> Witness:
    x, y, z = (float(value) for value in pose.position)
    rows = [[float(value) for value in row] for row in pose.rotation]
    return Witness(
        kind=probes[pose.probe].kind,
        size=probes[pose.probe].size,
        position=(x, y, z),
        rotation=tuple((r[0], r[1], r[2]) for r in rows),
        solid_clearance=float(answers.solid[index]),
        hull_clearance=float(answers.hulls[index]),
    )
