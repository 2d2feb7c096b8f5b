"""Sources to robots; what cannot be read is an error if named, a finding if found."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from assetpipe.errors import InputError, LimitError
from assetpipe.findings import Finding, Severity
from assetpipe.geometry.mesh import locked
from assetpipe.pipeline.inputs import Source
from assetpipe.robot import Collision, Link, MeshShape, Robot, read_robot


@dataclass(frozen=True)
class Read:
    """One source as read.

    Attributes:
        source: where from.
        robot: a bare mesh is a robot of one link with one collision element.
        findings: about reading it.
    """

    source: Source
    robot: Robot
    findings: tuple[Finding, ...]


def read_sources(sources: Sequence[Source]) -> tuple[tuple[Read, ...], tuple[Finding, ...]]:
    """All robots that can be read, and findings about those that cannot.

    Raises:
        InputError: a source that the user named cannot be read.
    """
    read: list[Read] = []
    findings: list[Finding] = []
    for source in sources:
        if source.kind == "mesh":
            read.append(Read(source, bare_mesh(source), ()))
            continue
        try:
            found = read_robot(source.path)
        except (InputError, LimitError) as error:
            if source.origin == "named":
                raise
            code = "AP108" if source.path.suffix.lower() == ".xacro" else "AP104"
            findings.append(Finding(code, Severity.ERROR, error.message, error.location))
            continue
        read.append(Read(source, found.robot, tuple(found.findings)))
    return tuple(read), tuple(findings)


def bare_mesh(source: Source) -> Robot:
    """A mesh file as a robot of one link."""
    name = source.path.stem
    shape = MeshShape(source.path.name, source.path, (1.0, 1.0, 1.0))
    element = Collision(name, 0, None, locked(np.eye(4)), shape, 0)
    return Robot(
        name=name,
        path=source.path,
        source=b"",
        links=(Link(name, (element,), (), 0),),
        joints=(),
        package=None,
        home=source.path.parent,
        references=(),
    )
