"""Robot descriptions: read, resolve, move, and write with nothing changed but collisions."""

from __future__ import annotations

from typing import TYPE_CHECKING

from assetpipe.lazy import lazily

if TYPE_CHECKING:
    from assetpipe.robot.kinematics import forward_kinematics, home
    from assetpipe.robot.model import (
        Box,
        Capsule,
        Collision,
        Cylinder,
        Joint,
        Limit,
        Link,
        MeshShape,
        Mimic,
        OtherShape,
        Reference,
        Robot,
        Shape,
        Sphere,
        Visual,
    )
    from assetpipe.robot.packages import Package
    from assetpipe.robot.packaging import Copy, HullPlace, Layout, lay_out
    from assetpipe.robot.reader import ReadRobot, finding_of, read_robot
    from assetpipe.robot.resolution import Resolution
    from assetpipe.robot.resources import Resolver
    from assetpipe.robot.search import find_robots
    from assetpipe.robot.writer import HullMesh, NewCollision, NewShape, write_urdf
    from assetpipe.robot.xacro import XacroError
else:
    # An unchanged build needs the markup and the resolver only, neither numpy nor a parser.
    __getattr__ = lazily(
        __name__,
        {
            "Box": "assetpipe.robot.model",
            "Capsule": "assetpipe.robot.model",
            "Collision": "assetpipe.robot.model",
            "Copy": "assetpipe.robot.packaging",
            "Cylinder": "assetpipe.robot.model",
            "HullMesh": "assetpipe.robot.writer",
            "HullPlace": "assetpipe.robot.packaging",
            "Joint": "assetpipe.robot.model",
            "Layout": "assetpipe.robot.packaging",
            "Limit": "assetpipe.robot.model",
            "Link": "assetpipe.robot.model",
            "MeshShape": "assetpipe.robot.model",
            "Mimic": "assetpipe.robot.model",
            "NewCollision": "assetpipe.robot.writer",
            "NewShape": "assetpipe.robot.writer",
            "OtherShape": "assetpipe.robot.model",
            "Package": "assetpipe.robot.packages",
            "ReadRobot": "assetpipe.robot.reader",
            "Reference": "assetpipe.robot.model",
            "Resolution": "assetpipe.robot.resolution",
            "Resolver": "assetpipe.robot.resources",
            "Robot": "assetpipe.robot.model",
            "Shape": "assetpipe.robot.model",
            "Sphere": "assetpipe.robot.model",
            "Visual": "assetpipe.robot.model",
            "XacroError": "assetpipe.robot.xacro",
            "find_robots": "assetpipe.robot.search",
            "finding_of": "assetpipe.robot.reader",
            "forward_kinematics": "assetpipe.robot.kinematics",
            "home": "assetpipe.robot.kinematics",
            "lay_out": "assetpipe.robot.packaging",
            "read_robot": "assetpipe.robot.reader",
            "write_urdf": "assetpipe.robot.writer",
        },
    )

__all__ = [
    "Box",
    "Capsule",
    "Collision",
    "Copy",
    "Cylinder",
    "HullMesh",
    "HullPlace",
    "Joint",
    "Layout",
    "Limit",
    "Link",
    "MeshShape",
    "Mimic",
    "NewCollision",
    "NewShape",
    "OtherShape",
    "Package",
    "ReadRobot",
    "Reference",
    "Resolution",
    "Resolver",
    "Robot",
    "Shape",
    "Sphere",
    "Visual",
    "XacroError",
    "find_robots",
    "finding_of",
    "forward_kinematics",
    "home",
    "lay_out",
    "read_robot",
    "write_urdf",
]
