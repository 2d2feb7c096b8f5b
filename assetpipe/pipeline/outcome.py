"""What became of one mesh, and its bytes for cache and transport.

The format holds numbers and JSON only, never pickles: a cache or a cluster is a
place where strangers may have written. Layout: a magic line with the version, the
SHA-256 of all that follows, a line of JSON, then the arrays, little-endian.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from assetpipe.decomposition.certificate import Certificate, Interval
from assetpipe.decomposition.primitives import Primitive
from assetpipe.errors import InputError
from assetpipe.findings import Finding, Severity
from assetpipe.geometry.mesh import Mesh

MAGIC = b"assetpipe-outcome 3\n"


@dataclass(frozen=True)
class HullOutcome:
    """One hull as it will be written.

    Attributes:
        mesh: closed and convex, in the frame of the mesh file after ``<mesh scale>``, metres.
        thickening: certified ``(lower, upper)``, metres.
        concavity: certified ``(lower, upper)`` against the hull's part, metres, if it has one.
        primitive: the simple shape that is written in its place; ``mesh`` is around it.
    """

    mesh: Mesh
    thickening: tuple[float, float]
    concavity: tuple[float, float] | None = None
    primitive: Primitive | None = None

    @property
    def certificate(self) -> Certificate:
        """The same as a value of the decomposition."""
        return Certificate(
            Interval(*self.thickening), Interval(*self.concavity) if self.concavity else None
        )


@dataclass(frozen=True)
class MeshOutcome:
    """What became of one distinct mesh.

    Attributes:
        state: ``decomposed``, or ``kept`` if its geometry must stay as it was.
        hulls: empty if kept.
        findings: about the mesh, not yet located in a robot.
        facts: JSON-ready: ``faces``, ``health``, ``repair``, ``tolerance`` (metres),
            ``certificate``, ``contact`` and what else the report tells.
        solid: what the hulls stand for, same frame; ``None`` if kept.
        inner: convex polytopes inside the repaired mesh, same frame, if they were asked for.
    """

    state: Literal["decomposed", "kept"]
    hulls: tuple[HullOutcome, ...] = ()
    findings: tuple[Finding, ...] = ()
    facts: Mapping[str, Any] = field(default_factory=dict)
    solid: Mesh | None = None
    inner: tuple[Mesh, ...] = ()

    def encode(self) -> bytes:
        """The bytes that :meth:`decode` reads; equal outcomes, equal bytes."""
        head = {
            "state": self.state,
            "findings": [_finding_dict(f) for f in self.findings],
            "facts": self.facts,
            "hulls": [
                {
                    **_size(h.mesh),
                    "thickening": h.thickening,
                    "concavity": h.concavity,
                    "primitive": h.primitive.as_dict() if h.primitive else None,
                }
                for h in self.hulls
            ],
            "solid": _size(self.solid) if self.solid is not None else None,
            "inner": [_size(mesh) for mesh in self.inner],
        }
        parts = [json.dumps(head, sort_keys=True, separators=(",", ":")).encode(), b"\n"]
        solid = () if self.solid is None else (self.solid,)
        for mesh in (*(h.mesh for h in self.hulls), *solid, *self.inner):
            parts.append(mesh.vertices.astype("<f8").tobytes())
            parts.append(mesh.faces.astype("<i4").tobytes())
        body = b"".join(parts)
        return MAGIC + hashlib.sha256(body).hexdigest().encode() + b"\n" + body

    @classmethod
    def decode(cls, data: bytes) -> MeshOutcome:
        """Read :meth:`encode`'s bytes.

        Raises:
            InputError: not such bytes, or damaged.
        """
        start = len(MAGIC) + 65
        body = data[start:]
        digest = hashlib.sha256(body).hexdigest().encode()
        if not data.startswith(MAGIC) or data[len(MAGIC) : start] != digest + b"\n":
            raise InputError("stored outcome is damaged or of another version")
        line = body.index(b"\n")
        head = json.loads(body[:line])
        at = line + 1

        def mesh(size: Mapping[str, int]) -> Mesh:
            nonlocal at
            n, m = size["vertices"], size["faces"]
            vertices = np.frombuffer(body, "<f8", 3 * n, at).reshape(n, 3)
            faces = np.frombuffer(body, "<i4", 3 * m, at + 24 * n).reshape(m, 3)
            at += 24 * n + 12 * m
            return Mesh(vertices, faces.astype(np.int64))

        hulls = []
        for record in head["hulls"]:
            lower, upper = record["thickening"]
            concavity = tuple(record["concavity"]) if record["concavity"] else None
            primitive = Primitive.of(record["primitive"]) if record["primitive"] else None
            hulls.append(HullOutcome(mesh(record), (lower, upper), concavity, primitive))
        return cls(
            head["state"],
            tuple(hulls),
            tuple(_finding_of(f) for f in head["findings"]),
            head["facts"],
            mesh(head["solid"]) if head["solid"] else None,
            tuple(mesh(size) for size in head["inner"]),
        )


def _size(mesh: Mesh) -> dict[str, int]:
    return {"vertices": len(mesh.vertices), "faces": len(mesh.faces)}


def _finding_dict(finding: Finding) -> dict[str, Any]:
    return {
        "code": finding.code,
        "severity": finding.severity.value,
        "message": finding.message,
        "hint": finding.hint,
    }


def _finding_of(data: Mapping[str, Any]) -> Finding:
    return Finding(data["code"], Severity(data["severity"]), data["message"], hint=data["hint"])
