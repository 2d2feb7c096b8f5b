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

from assetpipe.errors import InputError
from assetpipe.findings import Finding, Severity
from assetpipe.geometry.mesh import Mesh

MAGIC = b"assetpipe-outcome 1\n"


@dataclass(frozen=True)
class HullOutcome:
    """One hull as it will be written.

    Attributes:
        mesh: closed and convex, in the frame of the mesh file after ``<mesh scale>``, metres.
        thickening: certified ``(lower, upper)``, metres.
        concavity: certified ``(lower, upper)`` against the hull's part, metres, if it has one.
    """

    mesh: Mesh
    thickening: tuple[float, float]
    concavity: tuple[float, float] | None = None


@dataclass(frozen=True)
class MeshOutcome:
    """What became of one distinct mesh.

    Attributes:
        state: ``decomposed``, or ``kept`` if its geometry must stay as it was.
        hulls: empty if kept.
        findings: about the mesh, not yet located in a robot.
        facts: JSON-ready: ``faces``, ``health``, ``repair``, ``tolerance`` (metres),
            ``certificate``, ``coverage``, ``contact`` and what else the report tells.
    """

    state: Literal["decomposed", "kept"]
    hulls: tuple[HullOutcome, ...] = ()
    findings: tuple[Finding, ...] = ()
    facts: Mapping[str, Any] = field(default_factory=dict)

    def encode(self) -> bytes:
        """The bytes that :meth:`decode` reads; equal outcomes, equal bytes."""
        head = {
            "state": self.state,
            "findings": [_finding_dict(f) for f in self.findings],
            "facts": self.facts,
            "hulls": [
                {
                    "vertices": len(h.mesh.vertices),
                    "faces": len(h.mesh.faces),
                    "thickening": h.thickening,
                    "concavity": h.concavity,
                }
                for h in self.hulls
            ],
        }
        parts = [json.dumps(head, sort_keys=True, separators=(",", ":")).encode(), b"\n"]
        for hull in self.hulls:
            parts.append(hull.mesh.vertices.astype("<f8").tobytes())
            parts.append(hull.mesh.faces.astype("<i4").tobytes())
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
        hulls = []
        at = line + 1
        for record in head["hulls"]:
            n, m = int(record["vertices"]), int(record["faces"])
            vertices = np.frombuffer(body, "<f8", 3 * n, at).reshape(n, 3)
            at += 24 * n
            faces = np.frombuffer(body, "<i4", 3 * m, at).reshape(m, 3)
            at += 12 * m
            concavity = record["concavity"]
            hulls.append(
                HullOutcome(
                    Mesh(vertices, faces.astype(np.int64)),
                    (record["thickening"][0], record["thickening"][1]),
                    (concavity[0], concavity[1]) if concavity else None,
                )
            )
        return cls(
            head["state"],
            tuple(hulls),
            tuple(_finding_of(f) for f in head["findings"]),
            head["facts"],
        )


def _finding_dict(finding: Finding) -> dict[str, Any]:
    return {
        "code": finding.code,
        "severity": finding.severity.value,
        "message": finding.message,
        "hint": finding.hint,
    }


def _finding_of(data: Mapping[str, Any]) -> Finding:
    return Finding(data["code"], Severity(data["severity"]), data["message"], hint=data["hint"])
