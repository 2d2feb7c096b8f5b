"""``validate``: a built robot against its original, whoever built it; and scenes."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from assetpipe.errors import CancelledError, Location, UsageError
from assetpipe.findings import Finding, Severity
from assetpipe.pipeline.config import Config, LinkSettings
from assetpipe.pipeline.executors import Task
from assetpipe.pipeline.executors.choose import cores
from assetpipe.pipeline.executors.local import LocalExecutor
from assetpipe.pipeline.executors.task import Cancelled
from assetpipe.pipeline.faults import outcome_of
from assetpipe.pipeline.outcome import MeshOutcome
from assetpipe.pipeline.planner_pairs import planner_pairs
from assetpipe.pipeline.progress import Listener, Progress, Token, cancelled_by, silent
from assetpipe.pipeline.proof import said
from assetpipe.pipeline.result import exit_code
from assetpipe.robot import (
    Box,
    Capsule,
    Collision,
    Cylinder,
    Link,
    MeshShape,
    Robot,
    Sphere,
    read_robot,
)

if TYPE_CHECKING:
    from assetpipe.validation.effects import Plan
    from assetpipe.validation.runners import SceneResult
    from assetpipe.validation.srdf import DisabledPair


@dataclass(frozen=True)
class Validation:
    """What was proved.

    Attributes:
        original, built: the files.
        links: JSON-ready facts by name of every link whose collision geometry differs.
        checks: JSON-ready; ``self_collision`` and ``engine`` as far as run.
        scenes: results in the order that was asked.
        findings: of everything.
        seconds: the whole took.
        disabled: pairs that a planner need not ask; empty if self-collision was not told.
    """

    original: Path | None
    built: Path | None
    links: Mapping[str, Mapping[str, Any]]
    checks: Mapping[str, Any]
    scenes: tuple[SceneResult, ...]
    findings: tuple[Finding, ...]
    seconds: float = 0.0
    disabled: tuple[DisabledPair, ...] = ()

    @property
    def exit_code(self) -> int:
        """0 fine, 1 findings, 3 a fault of ours."""
        return exit_code(self.findings)

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready."""
        return {
            "original": str(self.original) if self.original else None,
            "built": str(self.built) if self.built else None,
            "links": {name: dict(facts) for name, facts in self.links.items()},
            **self.checks,
            "scenes": [scene.as_dict() for scene in self.scenes],
            "findings": [finding.as_dict() for finding in self.findings],
        }


def validate(
    original: str | os.PathLike[str] | None = None,
    built: str | os.PathLike[str] | None = None,
    *,
    scenes: Sequence[str | os.PathLike[str]] = (),
    depth: Literal["answer", "sensitivity"] = "answer",
    config: Config | None = None,
    on_progress: Listener | None = None,
    cancel: Token | Cancelled | None = None,
) -> Validation:
    """Compare a built robot with its original, and answer scenes.

    Args:
        original: URDF or xacro file.
        built: the URDF that was made of it, or the folder that holds it alone.
        scenes: files, or names of shipped scenes.
        depth: ``sensitivity`` answers scenes again with every effect toggled.
        config: its ``validation``, ``limits``, ``cavities``, ``reach``, ``jobs``, and what it
            says of openings matter.
        on_progress: hears of it.
        cancel: stops it.

    Raises:
        UsageError: only one of the two robots, or nothing to do.
        InputError: a file cannot be read.
        CancelledError: ``cancel`` said so.
    """
    if (original is None) != (built is None):
        raise UsageError("a comparison needs both the original and what was built of it")
    if original is None and not scenes:
        raise UsageError("nothing to validate: name ORIGINAL and BUILT, or a scene")
    began = time.monotonic()
    chosen, hear = config or Config(), on_progress or silent
    cancelled = cancelled_by(cancel)
    compared = Validation(None, None, {}, {}, (), ())
    if original is not None and built is not None:
        compared = _compare(Path(original), the_urdf(Path(built)), chosen, hear, cancelled)
    answered = _answer(scenes, depth, hear, cancelled) if scenes else ()
    return replace(
        compared,
        scenes=answered,
        findings=(*compared.findings, *(f for scene in answered for f in scene.findings())),
        seconds=time.monotonic() - began,
    )


def the_urdf(path: Path) -> Path:
    """The file itself, or the only URDF in a folder."""
    if not path.is_dir():
        return path
    found = sorted(path.rglob("*.urdf"))
    if len(found) != 1:
        names = ", ".join(str(item.relative_to(path)) for item in found[:8])
        raise UsageError(f"'{path}' holds {len(found)} URDFs; name one: {names or 'none'}")
    return found[0]


def explain(scenes: Sequence[str | os.PathLike[str]]) -> dict[str, Plan]:
    """What scenes would simulate and why, by name; nothing is run.

    Raises:
        ConfigError: a scene does not fit its schema or its assets.
    """
    from assetpipe.validation.runners import explain_scene
    from assetpipe.validation.scenes import DirectProvider

    provider = DirectProvider()  # scenes share assets: each mesh is decomposed once
    return {
        Path(scene).stem: explain_scene(os.fspath(scene), provider=provider) for scene in scenes
    }


def _answer(
    scenes: Sequence[str | os.PathLike[str]],
    depth: Literal["answer", "sensitivity"],
    on_progress: Listener,
    cancelled: Cancelled,
) -> tuple[SceneResult, ...]:
    from assetpipe.validation.runners import SceneOptions, run_scene
    from assetpipe.validation.scenes import DirectProvider

    provider = DirectProvider()  # scenes share assets: each mesh is decomposed once
    results = []
    for number, scene in enumerate(scenes):
        if cancelled():
            raise CancelledError("cancelled")
        on_progress(Progress("scene", Path(scene).stem, number, len(scenes)))
        options = SceneOptions(depth=depth)
        results.append(run_scene(os.fspath(scene), options=options, provider=provider))
    return tuple(results)


def _compare(
    original: Path, built: Path, config: Config, on_progress: Listener, cancelled: Cancelled
) -> Validation:
    before, after = read_robot(original), read_robot(built)
    pairs, findings = _pairs(before.robot, after.robot)
    settings = config.validation
    contact = {"samples": settings.samples, "seed": settings.seed}
    requests = [
        {
            "kind": "compare",
            "before": [_request(c) for c in old],
            "after": [_request(c) for c in new],
            "contact": contact if "contact" in settings.checks else None,
            "cavities": config.cavities,
            "openings": config.links.get(link.name, LinkSettings()).openings
            or config.repair.openings,
            "reach": config.reach,
        }
        for link, old, new in pairs
    ]
    limits = config.limits
    tasks = [
        Task(link.name, request, limits.seconds, limits.memory)
        for (link, _, _), request in zip(pairs, requests, strict=True)
    ]
    executor = LocalExecutor(config.jobs or cores())
    outcomes: dict[int, MeshOutcome] = {}

    def listen(place: int, stage: str, fraction: float) -> None:
        on_progress(Progress(stage, tasks[place].name, len(outcomes), len(tasks), fraction))

    for place, reply in executor.run(tasks, listener=listen, cancelled=cancelled):
        outcomes[place] = outcome_of(reply)
    for place, (link, _, _) in enumerate(pairs):
        where = Location(original, link.line)
        findings += [
            replace(finding, location=where, link=link.name) for finding in outcomes[place].findings
        ]
    by_link = {link.name: outcomes[place] for place, (link, _, _) in enumerate(pairs)}
    validation: Mapping[str, Any] = {}
    if set(settings.checks) - {"contact"}:
        on_progress(Progress("self_collision", before.robot.name, len(tasks), len(tasks)))
        kept = {
            link.name: _unchanged(link, after.robot.link_map.get(link.name))
            for link in before.robot.links
        }
        validation, more = _whole(
            before.robot, built, by_link, kept, config=config, cancelled=cancelled
        )
        findings += more
    disabled: tuple[DisabledPair, ...] = ()
    if "self_collision" in validation:
        shaped = {link.name for link in after.robot.links if link.collisions}
        whole = {
            link.name
            for link, old, new in pairs
            if len(old) == len(link.collisions)
            and len(new) == len(after.robot.link_map[link.name].collisions)
        }
        disabled = planner_pairs(validation["self_collision"], shaped, whole)
    return Validation(
        original,
        built,
        {name: outcome.facts for name, outcome in by_link.items()},
        validation,
        (),
        (*before.findings, *after.findings, *findings),
        disabled=disabled,
    )


Pair = tuple[Link, tuple[Collision, ...], tuple[Collision, ...]]


def _pairs(before: Robot, after: Robot) -> tuple[list[Pair], list[Finding]]:
    """Links whose meshes differ, with what differs; findings about what is missing."""
    pairs: list[Pair] = []
    findings: list[Finding] = []
    for link in before.links:
        other = after.link_map.get(link.name)
        if link.collisions and (other is None or not other.collisions):
            findings.append(
                Finding(
                    "AP404",
                    Severity.ERROR,
                    "has collision geometry in the original and none in what was built",
                    Location(before.path, link.line),
                    link.name,
                )
            )
            continue
        if other is None:
            continue
        same, same_there = _unchanged(link, other), _unchanged(other, link)
        old = tuple(c for c in link.collisions if _readable(c) and c.index not in same)
        new = tuple(c for c in other.collisions if _comparable(c) and c.index not in same_there)
        if old and new:
            pairs.append((link, old, new))
    return pairs, findings


def _unchanged(link: Link, other: Link | None) -> list[int]:
    """Indices of collision elements that the other link has as well."""
    if other is None:
        return []
    there = {_identity(c) for c in other.collisions}
    return [c.index for c in link.collisions if _identity(c) in there]


def _readable(collision: Collision) -> bool:
    return isinstance(collision.shape, MeshShape) and collision.shape.path is not None


def _comparable(collision: Collision) -> bool:
    """Meshes, and the simple shapes that may stand in their place."""
    return _readable(collision) or isinstance(collision.shape, Box | Cylinder | Sphere | Capsule)


def _identity(collision: Collision) -> tuple[Any, ...]:
    """Equal for elements that say the same."""
    shape = collision.shape
    said = (shape.uri, shape.scale) if isinstance(shape, MeshShape) else (repr(shape),)
    return (*said, collision.link_from_shape.round(12).tobytes())


def _request(collision: Collision) -> dict[str, Any]:
    shape = collision.shape
    if isinstance(shape, Box | Cylinder | Sphere | Capsule):
        sizes = shape.size if isinstance(shape, Box) else tuple(vars(shape).values())
        return {
            "kind": type(shape).__name__.lower(),
            "size": list(sizes),
            "matrix": collision.link_from_shape.tolist(),
        }
    assert isinstance(shape, MeshShape)  # noqa: S101 - nothing else gets here
    return {
        "file": str(shape.path),
        "scale": list(shape.scale),
        "matrix": collision.link_from_shape.tolist(),
    }


def _whole(
    robot: Robot,
    built: Path,
    outcomes: Mapping[str, MeshOutcome],
    kept: Mapping[str, list[int]],
    *,
    config: Config,
    cancelled: Cancelled,
) -> tuple[Mapping[str, Any], tuple[Finding, ...]]:
    """Self-collision and physics engine, on the links as compared and what is unchanged."""
    with tempfile.TemporaryDirectory(prefix="assetpipe-proof-") as folder:
        files: dict[str, str] = {}
        for number, (name, outcome) in enumerate(outcomes.items()):
            if outcome.solid is not None:
                path = Path(folder, f"{number}.outcome")
                path.write_bytes(outcome.encode())
                files[name] = str(path)
        request = {
            "kind": "robot",
            "robot": str(robot.path),
            "built": str(built),
            "links": files,
            "kept": kept,
            "checks": [check for check in config.validation.checks if check != "contact"],
            "poses": config.validation.poses,
            "seed": config.validation.seed,
        }
        task = Task(robot.name, request, config.limits.seconds, config.limits.memory)
        for _, reply in LocalExecutor(1).run([task], listener=lambda *_: None, cancelled=cancelled):
            proof = said(reply, robot)
            return proof.validation, proof.findings
    return {}, ()
