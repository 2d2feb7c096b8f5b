"""What a reference in a robot description leads to."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from assetpipe.errors import Location
from assetpipe.findings import Finding, Severity

Means = Literal[
    "mapping",
    "package.xml",
    "ROS_PACKAGE_PATH",
    "AMENT_PREFIX_PATH",
    "model path",
    "folder name",
    "walk up",
    "relative",
    "relative, upwards",
    "file",
]
"""How a reference was resolved."""


_SHOWN = 300
"""Characters of a path that messages show."""


def shortened(text: str) -> str:
    """A path as messages show it: of an endless one, its beginning."""
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}…"


@dataclass(frozen=True)
class Resolution:
    """What a reference leads to.

    Attributes:
        uri: the reference as written.
        state: ``found``; ``missing``; ``outside``: a file that lies where it must not be
            read; ``unsupported``: a kind of reference that is not followed.
        path: the file, absolute, when found.
        package: the name in ``package://name/…``, else ``None``.
        rest: what follows the name, or the relative path as written, ``/`` between parts.
        root: the folder that ``rest`` counts from, when found.
        means: how it was found.
        tried: where it was looked for, in order.
        hint: what the user could do about it.
    """

    uri: str
    state: Literal["found", "missing", "outside", "unsupported"]
    path: Path | None = None
    package: str | None = None
    rest: str = ""
    root: Path | None = None
    means: Means | None = None
    tried: tuple[str, ...] = ()
    hint: str | None = None

    def finding(
        self, location: Location, *, link: str | None, severity: Severity
    ) -> Finding | None:
        """The finding about a reference that was not found: AP101, or AP103 when refused."""
        if self.state == "found":
            return None
        if self.state == "outside":
            return Finding(
                "AP103",
                severity,
                f"'{shortened(self.uri)}' leads out of the package: refused",
                location=location,
                link=link,
                mesh=shortened(self.uri),
                hint=self.hint,
            )
        looked = f"; looked at {', '.join(map(shortened, self.tried[:3]))}" if self.tried else ""
        more = f" and {len(self.tried) - 3} more" if len(self.tried) > 3 else ""
        reason = "is not followed" if self.state == "unsupported" else "does not exist"
        return Finding(
            "AP101",
            severity,
            f"'{shortened(self.uri)}' {reason}{looked}{more}",
            location=location,
            link=link,
            mesh=shortened(self.uri),
            hint=self.hint,
        )
