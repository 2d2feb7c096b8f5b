"""A robot description as frozen values.

Frames: ``a_from_b`` is a (4, 4) homogeneous matrix that takes points of frame ``b`` into
``a``. Lengths are metres, angles radians.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Literal

from assetpipe.errors import UsageError, unknown_name
from assetpipe.geometry.mesh import FloatArray
from assetpipe.robot.packages import Package
from assetpipe.robot.resolution import Resolution

JointType = Literal["revolute", "continuous", "prismatic", "fixed", "floating", "planar"]


@dataclass(frozen=True)
class Box:
    """A box around the origin; ``size`` are its full lengths along x, y, z."""

    size: tuple[float, float, float]


@dataclass(frozen=True)
class Cylinder:
    """A cylinder around the origin along z; ``length`` from cap to cap."""

    radius: float
    length: float


@dataclass(frozen=True)
class Sphere:
    """A sphere around the origin."""

    radius: float


@dataclass(frozen=True)
class Capsule:
    """A cylinder along z with half-spheres on its caps; ``length`` of the cylinder alone."""

    radius: float
    length: float


@dataclass(frozen=True)
class MeshShape:
    """A mesh file.

    Attributes:
        uri: the reference as written.
        path: the file it names, ``None`` where it cannot be resolved.
        scale: factors along x, y, z in the shape's frame; negative ones mirror.
    """

    uri: str
    path: Path | None
    scale: tuple[float, float, float]


@dataclass(frozen=True)
class OtherShape:
    """A shape that we don't know or cannot read; it stays as it is.

    Attributes:
        tag: of the element inside ``<geometry>``, empty when there is none.
    """

    tag: str


Shape = Box | Cylinder | Sphere | Capsule | MeshShape | OtherShape


@dataclass(frozen=True, eq=False)
class _Placed:
    """A shape on a link.

    Attributes:
        link: name of its link.
        index: its place among the link's elements of its kind, in document order.
        name: the element's own name, if it has one.
        link_from_shape: (4, 4) from ``<origin>``.
        shape: what is there; a mesh's scale is not in ``link_from_shape``.
        line: of its start tag, 1-based.
    """

    link: str
    index: int
    name: str | None
    link_from_shape: FloatArray
    shape: Shape
    line: int


@dataclass(frozen=True, eq=False)
class Collision(_Placed):
    """One ``<collision>`` element of a link."""


@dataclass(frozen=True, eq=False)
class Visual(_Placed):
    """One ``<visual>`` element of a link."""


@dataclass(frozen=True)
class Link:
    """A rigid body; ``line`` of its start tag."""

    name: str
    collisions: tuple[Collision, ...]
    visuals: tuple[Visual, ...]
    line: int


@dataclass(frozen=True)
class Limit:
    """Limits of a joint: radians or metres, per second for the velocity; ``None``: unsaid."""

    lower: float | None
    upper: float | None
    effort: float | None
    velocity: float | None


@dataclass(frozen=True)
class Mimic:
    """Position = ``multiplier`` · position of ``joint`` + ``offset``."""

    joint: str
    multiplier: float
    offset: float


@dataclass(frozen=True, eq=False)
class Joint:
    """A joint.

    Attributes:
        name: unique in the robot.
        type: how it moves.
        parent: name of the parent link.
        child: name of the child link.
        parent_from_joint: (4, 4) at position zero.
        axis: (3,) unit vector in the joint's frame; (1, 0, 0) unless said.
        limit: its limits, if said.
        mimic: the joint it follows, if it follows one.
        line: of its start tag.
    """

    name: str
    type: JointType
    parent: str
    child: str
    parent_from_joint: FloatArray
    axis: FloatArray
    limit: Limit | None
    mimic: Mimic | None
    line: int

    @property
    def movable(self) -> bool:
        """Whether one number gives its position."""
        return self.type in ("revolute", "continuous", "prismatic")


@dataclass(frozen=True)
class Reference:
    """A file that the description names.

    Attributes:
        role: where it is named: in a collision or visual mesh, as a texture, or elsewhere
            (sensors, plugins, …).
        uri: as written.
        resolution: what it leads to.
        link: the link it belongs to, if any.
        index: of the collision or visual element.
        line: of its element.
    """

    role: Literal["collision", "visual", "texture", "other"]
    uri: str
    resolution: Resolution
    link: str | None
    index: int | None
    line: int


@dataclass(frozen=True, eq=False)
class Robot:
    """A robot description.

    Attributes:
        name: of the ``<robot>`` element.
        path: the file that was read, URDF or xacro.
        source: the URDF's bytes: the file's own, or what xacro expanded to.
        links: in document order, each name once.
        joints: in document order, each name once.
        package: the package that the file lies in, if any.
        home: folder that everything of its own lies in: the package's, the repository's, or
            the file's.
        references: every file that the description names, in document order.
        includes: files that xacro read besides :attr:`path`.
    """

    name: str
    path: Path
    source: bytes
    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    package: Package | None
    home: Path
    references: tuple[Reference, ...]
    includes: tuple[Path, ...] = ()

    @property
    def from_xacro(self) -> bool:
        """Whether :attr:`source` is an expansion."""
        return self.path.suffix.lower() == ".xacro"

    @property
    def urdf_name(self) -> str:
        """The name a URDF written for it carries: its own, ``robot.urdf`` for
        ``robot.urdf.xacro`` and ``robot.xacro``."""
        if not self.from_xacro:
            return self.path.name
        stem = self.path.name[: -len(".xacro")]
        return stem if stem.lower().endswith(".urdf") else f"{stem}.urdf"

    @cached_property
    def link_map(self) -> Mapping[str, Link]:
        """Links by name."""
        return MappingProxyType({link.name: link for link in self.links})

    @cached_property
    def joint_map(self) -> Mapping[str, Joint]:
        """Joints by name."""
        return MappingProxyType({joint.name: joint for joint in self.joints})

    def link(self, name: str) -> Link:
        """A link by its name.

        Raises:
            UsageError: there is none, naming its neighbours.
        """
        try:
            return self.link_map[name]
        except KeyError:
            raise UsageError(unknown_name("link", name, self.link_map)) from None

    def joint(self, name: str) -> Joint:
        """A joint by its name.

        Raises:
            UsageError: there is none, naming its neighbours.
        """
        try:
            return self.joint_map[name]
        except KeyError:
            raise UsageError(unknown_name("joint", name, self.joint_map)) from None
