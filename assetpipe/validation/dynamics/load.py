"""Does the engine load what was written, and does it see the same shapes?"""

from __future__ import annotations

import os
import re
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np

from assetpipe.errors import Location
from assetpipe.findings import Finding, Severity
from assetpipe.geometry.mesh import FloatArray
from assetpipe.validation.contact.probes import surface_samples
from assetpipe.validation.contact.surface import ConvexShape, Frame, Surface, outside_hulls
from assetpipe.validation.dynamics.process import (
    EngineName,
    WorkerAnswer,
    engine_for,
    run_worker,
)
from assetpipe.validation.statistics import Distribution, Rate

LoadOutcome = Literal["loaded", "refused", "crashed", "timed out", "not available"]
ROUNDING = 1e-4
"""Metres by which an engine's distance may differ beside its collision margin."""
_LINE = 8190
"""Bytes of a line that PyBullet reads; longer ones it cuts, and then finds no robot."""


@dataclass(frozen=True)
class EngineProbe:
    """A sphere near a link's hulls, and how far apart they are.

    Attributes:
        link: name.
        centre: (x, y, z) in the link's frame, metres.
        radius: metres.
        separation: metres, of sphere and hulls as FCL says; 0 in contact.
    """

    link: str
    centre: tuple[float, float, float]
    radius: float
    separation: float


@dataclass(frozen=True)
class EngineLoad:
    """What a physics engine says about a URDF.

    Attributes:
        engine: its name; ``None`` where none is installed.
        outcome: how the attempt ended.
        message: the engine's own words where it did not load.
        without_visuals: it loads only once the visual elements are taken away.
        shapes: collision shapes by link, as the engine counts them.
        expected: the same, as we wrote them.
        disagreements: of the probes asked, those whose contact or distance differs by
            more than the engine's collision margin and :data:`ROUNDING`.
        distance_error: metres, engine minus hulls, over probes that are apart.
        margin: metres, the engine's largest collision margin.
        urdf: the file.
    """

    engine: EngineName | None
    outcome: LoadOutcome
    message: str
    without_visuals: bool
    urdf: Path
    shapes: Mapping[str, int] = field(default_factory=dict)
    expected: Mapping[str, int] = field(default_factory=dict)
    disagreements: Rate = field(default_factory=lambda: Rate.wilson(0, 0))
    distance_error: Distribution = field(default_factory=lambda: Distribution.over([]))
    margin: float = 0.0

    @property
    def miscounted(self) -> dict[str, tuple[int, int]]:
        """Links where the engine's count differs: (expected, engine)."""
        if self.outcome != "loaded":
            return {}
        return {
            link: (count, self.shapes.get(link, 0))
            for link, count in sorted(self.expected.items())
            if self.shapes.get(link, 0) != count
        }

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready."""
        return {
            "engine": self.engine,
            "outcome": self.outcome,
            "message": self.message,
            "without_visuals": self.without_visuals,
            "shapes": dict(sorted(self.shapes.items())),
            "expected": dict(sorted(self.expected.items())),
            "disagreements": self.disagreements.as_dict(),
            "distance_error": self.distance_error.as_dict(),
            "margin": self.margin,
        }

    def findings(self) -> tuple[Finding, ...]:
        """What went wrong, as findings."""
        where = Location(self.urdf)
        if self.outcome == "not available":
            return (Finding("AP411", Severity.NOTE, self.message, where),)
        if self.outcome in ("crashed", "timed out"):
            return (
                Finding(
                    "AP409",
                    Severity.ERROR,
                    f"{self.engine} {self.outcome} while loading: {self.message}",
                    where,
                ),
            )
        if self.outcome == "refused":
            return (Finding("AP406", Severity.ERROR, f"{self.engine} says: {self.message}", where),)
        found = []
        if self.without_visuals:
            found.append(
                Finding(
                    "AP406",
                    Severity.NOTE,
                    f"{self.engine} loads it only without its visual elements: {self.message}",
                    where,
                )
            )
        for link, (count, seen) in self.miscounted.items():
            found.append(
                Finding(
                    "AP407",
                    Severity.ERROR,
                    f"{self.engine} sees {seen} collision shapes, written were {count}",
                    where,
                    link=link,
                )
            )
        if self.disagreements.count:
            found.append(
                Finding(
                    "AP408",
                    Severity.ERROR,
                    f"{self.engine} and FCL differ for {self.disagreements.count} of "
                    f"{self.disagreements.of} probes by up to "
                    f"{abs(self.distance_error.worst) * 1000:.3g} mm",
                    where,
                )
            )
        return tuple(found)


def engine_probes(
    hulls: Mapping[str, Sequence[ConvexShape]], *, each: int = 4, seed: int = 0
) -> tuple[EngineProbe, ...]:
    """Spheres near the hulls of every link, half of them apart and half in contact.

    Args:
        hulls: convex shapes by link, in the link's frame, metres.
        each: probes a link.
        seed: of the sampling.
    """
    rng = np.random.default_rng(seed)
    probes = []
    for link in sorted(hulls):
        shapes = hulls[link]
        if not shapes:
            continue
        frame = Frame.around(np.vstack([h.vertices for h in shapes]))
        joined = Surface.of_hulls(shapes, frame)
        points, normals = surface_samples(joined.vertices, joined.faces, each, rng)
        size = 1000.0 / frame.scale
        radius = round(max(0.01, 0.05 * size), 6)
        # Well apart or well in contact: what lies between is the margin's business.
        offsets = np.where(np.arange(len(points)) % 2 == 0, 0.01 + 0.05 * size, -radius / 2.0)
        centres: FloatArray = points + normals * (radius + offsets)[:, None]
        away = np.where(outside_hulls(centres, shapes) <= 0.0, 0.0, joined.distances(centres))
        for centre, apart in zip(centres, away, strict=True):
            x, y, z = (float(v) for v in centre)
            probes.append(EngineProbe(link, (x, y, z), radius, max(0.0, float(apart) - radius)))
    return tuple(probes)


def load_in_engine(
    urdf: Path,
    expected: Mapping[str, int],
    *,
    hulls: Mapping[str, Sequence[ConvexShape]] | None = None,
    resolved: Mapping[str, Path] | None = None,
    engine: EngineName | None = None,
    timeout: float = 60.0,
    seed: int = 0,
) -> EngineLoad:
    """Load a URDF in a physics engine's own process and compare what it sees.

    Args:
        urdf: the file as written.
        expected: number of collision shapes by link.
        hulls: convex shapes by link in the link's frame; their distances to probe
            spheres are compared with the engine's. ``None`` compares counts only.
        resolved: file of every mesh reference, as written in the URDF. PyBullet finds
            ``package://`` only in folders of the package's name above the URDF.
        engine: which; ``None`` takes the first that is installed.
        timeout: seconds for one attempt.
        seed: of the probes.

    Raises:
        InputError: the file does not exist, is larger than 64 MiB, or its markup is beyond
            what readers of robots tolerate.
        UsageError: an engine that does not exist or is not installed was asked for.
    """
    chosen = engine_for(urdf, engine)
    if chosen is None:
        return EngineLoad(
            None,
            "not available",
            "no physics engine is installed: pip install 'assetpipe[mujoco]'",
            without_visuals=False,
            urdf=urdf,
            expected=dict(expected),
        )
    probes = engine_probes(hulls, seed=seed) if hulls else ()
    with tempfile.TemporaryDirectory(prefix="assetpipe-urdf-") as folder:
        copy = Path(folder, urdf.name)
        first = _attempt(
            chosen,
            urdf,
            copy,
            resolved=resolved or {},
            probes=probes,
            timeout=timeout,
            visuals="kept",
        )
        answer, stripped = first, False
        if not _loaded(first):
            second = _attempt(
                chosen,
                urdf,
                copy,
                resolved=resolved or {},
                probes=probes,
                timeout=timeout,
                visuals="removed",
            )
            if _loaded(second):
                answer, stripped = second, True
    return _judge(chosen, urdf, expected, probes, first=first, answer=answer, stripped=stripped)


def _loaded(answer: WorkerAnswer) -> bool:
    return answer.outcome == "answered" and bool(answer.answer.get("loaded"))


def _attempt(
    engine: EngineName,
    urdf: Path,
    copy: Path,
    *,
    resolved: Mapping[str, Path],
    probes: Sequence[EngineProbe],
    timeout: float,
    visuals: Literal["kept", "removed"],
) -> WorkerAnswer:
    as_written = engine == "bullet" and visuals == "kept" and not resolved
    if not as_written:
        rewrite(urdf, copy, resolved, visuals)
        if engine == "mujoco":
            from assetpipe.validation.dynamics.mujoco_worker import prepare

            prepare(copy)
    request = {
        "task": "load",
        "urdf": str((urdf if as_written else copy).resolve()),
        "probes": [{"link": p.link, "centre": p.centre, "radius": p.radius} for p in probes],
    }
    return run_worker(engine, request, timeout=timeout)


def rewrite(
    urdf: Path, copy: Path, resolved: Mapping[str, Path], visuals: Literal["kept", "removed"]
) -> None:
    """Write a copy with absolute mesh references, for the engine's eyes only.

    It is read as leniently as robots are: what engines tolerate must not end here.
    """
    from assetpipe.robot.markup import read_markup
    from assetpipe.robot.splice import Edit, spliced, value_edit

    markup = read_markup(urdf.read_bytes(), urdf)
    removed: list[Edit] = []
    if visuals == "removed":
        links = markup.root.all("link")
        removed = [Edit(v.start, v.end, b"") for link in links for v in link.all("visual")]
    edits = list(removed)
    for mesh in (e for e in markup.root.walk() if e.tag == "mesh"):
        if any(r.start <= mesh.start < r.end for r in removed):
            continue
        reference = mesh.attributes.get("filename", "")
        target: Path | None = resolved.get(reference)
        if target is None and "://" not in reference and not Path(reference).is_absolute():
            target = urdf.parent / reference
        # Path.resolve fails where links lead in a circle.
        edit = target and value_edit(markup.text, mesh, "filename", os.path.realpath(target))
        if edit:
            edits.append(edit)
    if max(map(len, markup.text.splitlines()), default=0) <= _LINE:
        # Our paths are longer than the file's own, and no fault of its lines.
        inner = (e for e in markup.root.walk() if e.start > markup.root.start)
        breaks = [e for e in inner if not any(r.start <= e.start < r.end for r in removed)]
        edits += [Edit(e.start, e.start, b"\n") for e in breaks]
    # Text around the root is left out: other parsers fail on what stands there.
    start, end = markup.root.start, markup.root.end
    copy.write_bytes(
        spliced(
            markup.text[start:end], [Edit(e.start - start, e.end - start, e.text) for e in edits]
        )
    )


def _words(answer: WorkerAnswer, urdf: Path) -> str:
    """What the engine said, on one line, without its source positions and our folders."""
    folder = f"{urdf.parent.resolve()}/"
    lines = [str(answer.answer.get("message") or ""), answer.signal or ""]
    for line in answer.log.splitlines():
        told = re.sub(r"b3(Warning|Error|Printf)\[[^\]]*\]:?", " ", line)
        lines.append(re.sub(r"\S*assetpipe-urdf-\w+/", "", told).strip())
    told_once = dict.fromkeys(line.replace(folder, "").rstrip(".:") for line in lines if line)
    return "; ".join(told_once)[:500]


def _judge(
    engine: EngineName,
    urdf: Path,
    expected: Mapping[str, int],
    probes: Sequence[EngineProbe],
    *,
    first: WorkerAnswer,
    answer: WorkerAnswer,
    stripped: bool,
) -> EngineLoad:
    message = "" if _loaded(first) else _words(first, urdf)
    if not _loaded(answer):
        outcome: LoadOutcome = "refused"
        if answer.outcome == "crashed":
            outcome = "crashed"
        elif answer.outcome == "timed out":
            outcome = "timed out"
        return EngineLoad(
            engine, outcome, message, without_visuals=False, urdf=urdf, expected=dict(expected)
        )
    result = answer.answer
    errors, wrong = [], 0
    for probe, distance, margin in zip(probes, result["distances"], result["margins"], strict=True):
        if distance is None:
            wrong += 1
            continue
        slack = margin + ROUNDING
        if probe.separation > 0.0:
            errors.append(distance - probe.separation)
            wrong += abs(distance - probe.separation) > slack
        else:
            wrong += distance > slack
    return EngineLoad(
        engine=engine,
        outcome="loaded",
        message=message,
        without_visuals=stripped,
        urdf=urdf,
        shapes={str(k): int(v) for k, v in result["shapes"].items()},
        expected=dict(expected),
        disagreements=Rate.wilson(wrong, len(probes)),
        distance_error=Distribution.over(errors),
        margin=max((float(m) for m in result["margins"]), default=0.0),
    )
