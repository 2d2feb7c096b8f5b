"""Findings: located, coded statements about an asset.

A finding is data. It is the unit of ``check``, of reports, of SARIF and JUnit.
Codes are stable: AP1xx reading, AP2xx meshes and repair, AP3xx decomposition,
AP4xx validation, AP5xx engine profiles, AP6xx built packages, AP9xx our own faults.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any

from assetpipe.errors import Location, printable

NEGLIGIBLE = 0.01
"""Share of the tolerance up to which a change is worth a note, not a warning."""


class Severity(Enum):
    """How much a finding matters. Errors and warnings make the exit code 1; notes don't."""

    ERROR = "error"
    WARNING = "warning"
    NOTE = "note"


@dataclass(frozen=True)
class Finding:
    """One statement: ``AP203 link 'hand': 12 open edges …``.

    Attributes:
        code: stable code, ``AP`` and three digits, in :data:`CODES`.
        severity: how much it matters.
        message: one sentence; names the neighbours where a name is wrong.
        location: file and line it points at, where there is one.
        link: the link it concerns, where there is one.
        mesh: the mesh reference it concerns, as written in the input.
        hint: what the user could do about it.
    """

    code: str
    severity: Severity
    message: str
    location: Location | None = None
    link: str | None = None
    mesh: str | None = None
    hint: str | None = None

    def __post_init__(self) -> None:
        if self.code not in CODES:
            raise ValueError(f"finding code '{self.code}' is not registered in CODES")
        object.__setattr__(self, "message", printable(self.message))
        if self.hint is not None:
            object.__setattr__(self, "hint", printable(self.hint))

    def __str__(self) -> str:
        where = f"{self.location}: " if self.location else ""
        who = f" link '{self.link}'" if self.link else ""
        hint = f" ({self.hint})" if self.hint else ""
        return f"{where}{self.code}{who}: {self.message}{hint}"

    def as_dict(self) -> dict[str, Any]:
        """A JSON-ready mapping; keys are always all there."""
        return {
            "code": self.code,
            "title": CODES[self.code],
            "severity": self.severity.value,
            "message": self.message,
            "file": str(self.location.file) if self.location else None,
            "line": self.location.line if self.location else None,
            "link": self.link,
            "mesh": self.mesh,
            "hint": self.hint,
        }


CODES: dict[str, str] = {
    # reading
    "AP101": "mesh reference cannot be resolved",
    "AP102": "mesh file cannot be read",
    "AP103": "mesh reference leaves the package",
    "AP104": "URDF is not well formed",
    "AP105": "URDF element is invalid",
    "AP106": "unit or axis of a mesh was converted",
    "AP107": "robot has no collision geometry",
    "AP108": "xacro could not be expanded",
    "AP109": "several elements share a name",
    # meshes and repair
    "AP201": "mesh is not a solid and was repaired",
    "AP202": "mesh cannot be made a solid",
    "AP203": "repair moved the surface further than allowed",
    "AP204": "mesh has no volume",
    "AP205": "mesh has values that are not finite",
    "AP206": "mesh exceeds a limit",
    "AP207": "enclosed cavity",
    "AP208": "ambiguous opening",
    "AP209": "solid overlaps itself",
    # decomposition
    "AP301": "decomposition exceeded a limit",
    "AP302": "tolerance not met under the budget",
    "AP303": "decomposition failed",
    "AP304": "tolerance is finer than the mesh resolves",
    "AP305": "no inner hulls",
    # validation
    "AP401": "clearance error exceeds the certificate",
    "AP402": "new self-collision pair",
    "AP403": "self-collision pair vanished",
    "AP404": "solid is not covered by its hulls",
    "AP405": "missed contact",
    "AP406": "physics engine does not load the result",
    "AP407": "physics engine sees another number of shapes",
    "AP408": "physics engine disagrees about a contact",
    "AP409": "physics engine crashed",
    "AP410": "scene answer differs from what it expects",
    "AP411": "validation could not run",
    # engine profiles
    "AP501": "hull has more vertices than the engine allows",
    "AP502": "hull has more faces than the engine allows",
    "AP503": "hull is too thin for the engine",
    "AP504": "hull has more faces around a vertex than the engine allows",
    # built packages
    "AP601": "built package is out of date",
    "AP602": "generated file was changed or is missing",
    # our own faults
    "AP901": "internal fault",
}
"""Every finding code and its title."""
