"""What a build made: values that reports read and callers keep."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from assetpipe.errors import Location, UsageError
from assetpipe.findings import Finding, Severity

if TYPE_CHECKING:
    from assetpipe.decomposition import Certificate, Primitive
    from assetpipe.geometry.mesh import FloatArray, IntArray, Mesh
    from assetpipe.pipeline.outcome import MeshOutcome
    from assetpipe.pipeline.quick import Part

Treatment = Literal["decomposed", "kept", "primitive"]


@dataclass(frozen=True, eq=False)
class WrittenHull:
    """One hull of a link, as written.

    Attributes:
        file: relative to OUT.
        mesh: metres, in the frame of the collision element (scale applied).
        link_from_shape: (4, 4), the element's ``<origin>``.
        certificate: what is proved about it.
        primitive: the simple shape that the URDF holds in its place; ``mesh`` is around it.
    """

    file: str
    mesh: Mesh
    link_from_shape: FloatArray
    certificate: Certificate
    primitive: Primitive | None = None

    @property
    def vertices(self) -> FloatArray:
        """(k, 3) metres."""
        return self.mesh.vertices

    @property
    def faces(self) -> IntArray:
        """(f, 3), outward."""
        return self.mesh.faces

    @property
    def volume(self) -> float:
        """m³."""
        return self.mesh.volume


@dataclass(frozen=True)
class CollisionResult:
    """What became of one collision element.

    Attributes:
        index: its place among the link's collision elements in the input.
        uri: the mesh reference as written; the primitive's name otherwise.
        treatment: ``kept`` and ``primitive`` elements are as they were.
        mesh: index into :attr:`RobotResult.meshes`, if there is one.
        files: hull files in OUT, in order.
        inner_files: files of inner hulls in OUT, largest first; empty if none were asked for.
        link_from_shape: rows of the (4, 4) matrix.
    """

    index: int
    uri: str
    treatment: Treatment
    mesh: int | None = None
    files: tuple[str, ...] = ()
    link_from_shape: tuple[tuple[float, ...], ...] = ()
    inner_files: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready."""
        return {
            "index": self.index,
            "uri": self.uri,
            "treatment": self.treatment,
            "mesh": self.mesh,
            "files": list(self.files),
            "inner_files": list(self.inner_files),
            "link_from_shape": [list(row) for row in self.link_from_shape],
        }

    @classmethod
    def of(cls, data: Mapping[str, Any]) -> CollisionResult:
        """From :meth:`as_dict`."""
        return cls(
            data["index"],
            data["uri"],
            data["treatment"],
            data["mesh"],
            tuple(data["files"]),
            tuple(tuple(row) for row in data["link_from_shape"]),
            tuple(data["inner_files"]),
        )


@dataclass(frozen=True)
class MeshResult:
    """One distinct mesh of a robot.

    Attributes:
        name: the reference as first written.
        digest: SHA-256 of the file.
        scale: ``<mesh scale>``.
        links: that use it.
        treatment: what became of it.
        facts: JSON-ready; see :class:`assetpipe.pipeline.outcome.MeshOutcome`.
        key: content address of the outcome; says nothing to others.
        seconds: it took in this run; ``None`` if it came from the cache.
    """

    name: str
    digest: str
    scale: tuple[float, float, float]
    links: tuple[str, ...]
    treatment: Treatment
    facts: Mapping[str, Any]
    key: str = ""
    seconds: float | None = None

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready and reproducible: without times."""
        return {
            "name": self.name,
            "digest": self.digest,
            "scale": list(self.scale),
            "links": list(self.links),
            "treatment": self.treatment,
            **{key: self.facts[key] for key in sorted(self.facts)},
        }

    @classmethod
    def of(cls, data: Mapping[str, Any], key: str) -> MeshResult:
        """From :meth:`as_dict`."""
        own = ("name", "digest", "scale", "links", "treatment")
        x, y, z = data["scale"]
        return cls(
            data["name"],
            data["digest"],
            (x, y, z),
            tuple(data["links"]),
            data["treatment"],
            {name: value for name, value in data.items() if name not in own},
            key,
        )


@dataclass(frozen=True)
class LinkResult:
    """One link and its collision elements."""

    name: str
    collisions: tuple[CollisionResult, ...]
    load: Callable[[int], MeshOutcome] = field(repr=False, compare=False)

    @cached_property
    def hulls(self) -> tuple[WrittenHull, ...]:
        """Every hull of the link, element by element."""
        import numpy as np

        from assetpipe.geometry.mesh import locked

        found: list[WrittenHull] = []
        for element in self.collisions:
            if element.treatment != "decomposed" or element.mesh is None:
                continue
            outcome = self.load(element.mesh)
            matrix = locked(np.array(element.link_from_shape, dtype=np.float64))
            for file, hull in zip(element.files, outcome.hulls, strict=True):
                written = WrittenHull(file, hull.mesh, matrix, hull.certificate, hull.primitive)
                found.append(written)
        return tuple(found)


@dataclass(frozen=True)
class RobotResult:
    """One robot, or one bare mesh.

    Attributes:
        name: of the robot.
        source: the input file.
        urdf: the written file, relative to the folder of the package, or to OUT in a
            build's result; ``None`` for a bare mesh.
        links: by name.
        meshes: distinct meshes, in order of first use.
        findings: about this robot.
        validation: JSON-ready; keys ``contact``, ``self_collision``, ``engine`` as far as run.
    """

    name: str
    source: Path
    urdf: str | None
    links: Mapping[str, LinkResult]
    meshes: tuple[MeshResult, ...]
    findings: tuple[Finding, ...]
    validation: Mapping[str, Any]

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready and reproducible: without times."""
        return {
            "name": self.name,
            "source": str(self.source),
            "urdf": self.urdf,
            "links": {
                name: [element.as_dict() for element in link.collisions]
                for name, link in self.links.items()
            },
            "meshes": [mesh.as_dict() for mesh in self.meshes],
            "validation": dict(self.validation),
            "findings": [finding.as_dict() for finding in self.findings],
        }

    @classmethod
    def of(
        cls, data: Mapping[str, Any], keys: Sequence[str], load: Callable[[int], MeshOutcome]
    ) -> RobotResult:
        """From :meth:`as_dict`, the meshes' keys, and what loads their outcomes."""
        return cls(
            data["name"],
            Path(data["source"]),
            data["urdf"],
            {
                name: LinkResult(name, tuple(CollisionResult.of(e) for e in elements), load)
                for name, elements in data["links"].items()
            },
            tuple(MeshResult.of(m, k) for m, k in zip(data["meshes"], keys, strict=True)),
            tuple(finding_of(finding) for finding in data["findings"]),
            data["validation"],
        )

    def below(self, prefix: str) -> RobotResult:
        """The same with all files told relative to a folder further up.

        Args:
            prefix: the way from there; empty, or ending in ``/``.
        """
        if not prefix:
            return self
        links = {
            name: replace(
                link,
                collisions=tuple(
                    replace(
                        e,
                        files=tuple(prefix + file for file in e.files),
                        inner_files=tuple(prefix + file for file in e.inner_files),
                    )
                    for e in link.collisions
                ),
            )
            for name, link in self.links.items()
        }
        urdf = None if self.urdf is None else prefix + self.urdf
        return replace(self, urdf=urdf, links=links)


@dataclass(frozen=True)
class BuildResult:
    """What a build made.

    Attributes:
        out: the folder that was written; where it would have been, for a check.
        robots: in the order of the input.
        findings: all of them, in order.
        changed: files that differ from what OUT held before, relative to it.
        seconds: the whole took.
        parts: what the ledger remembers of it; ``None`` if it does not remember all.
    """

    out: Path
    robots: tuple[RobotResult, ...]
    findings: tuple[Finding, ...]
    changed: tuple[str, ...] = ()
    seconds: float = 0.0
    parts: tuple[Part, ...] | None = field(default=None, repr=False, compare=False)

    @property
    def robot(self) -> RobotResult:
        """The only robot.

        Raises:
            UsageError: there are none or several; see :attr:`robots`.
        """
        if len(self.robots) != 1:
            raise UsageError(
                f"the build has {len(self.robots)} robots; choose one of result.robots: "
                f"{', '.join(robot.name for robot in self.robots) or 'none'}"
            )
        return self.robots[0]

    @property
    def urdf(self) -> Path:
        """Absolute path of the only robot's URDF."""
        if self.robot.urdf is None:
            raise UsageError(f"'{self.robot.name}' is a bare mesh: there is no URDF")
        return self.out / self.robot.urdf

    @property
    def links(self) -> Mapping[str, LinkResult]:
        """The only robot's links by name."""
        return self.robot.links

    @property
    def validation(self) -> Mapping[str, Any]:
        """The only robot's validation."""
        return self.robot.validation

    @property
    def exit_code(self) -> int:
        """0 fine, 1 findings (errors or warnings), 3 a fault of ours."""
        return exit_code(self.findings)

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready and reproducible: without times."""
        return {
            "robots": [robot.as_dict() for robot in self.robots],
            "findings": [finding.as_dict() for finding in self.findings],
        }


def exit_code(findings: tuple[Finding, ...]) -> int:
    """0 fine, 1 errors or warnings among the findings, 3 a fault of ours among them."""
    if any(finding.code.startswith("AP9") for finding in findings):
        return 3
    return 1 if any(finding.severity is not Severity.NOTE for finding in findings) else 0


def finding_of(data: Mapping[str, Any]) -> Finding:
    """From :meth:`assetpipe.findings.Finding.as_dict`."""
    location = Location(Path(data["file"]), data["line"]) if data["file"] else None
    return Finding(
        data["code"],
        Severity(data["severity"]),
        data["message"],
        location,
        data["link"],
        data["mesh"],
        data["hint"],
    )
