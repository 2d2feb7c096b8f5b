"""Robot descriptions: read, resolve, move, and write with nothing changed but collisions."""

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
