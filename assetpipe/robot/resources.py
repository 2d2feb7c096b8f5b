"""Where packages may be found, and what of them may be read."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal

from assetpipe.robot.lookup import Lookup

_MODEL_PATHS = ("GAZEBO_MODEL_PATH", "GZ_SIM_RESOURCE_PATH", "IGN_GAZEBO_RESOURCE_PATH")


@dataclass(frozen=True)
class Resolver:
    """Where packages may be found, and what may be read.

    Attributes:
        packages: folders by package name; they come before everything else.
        ros_package_path: folders that hold packages, searched in depth.
        ament_prefix_path: install prefixes with ``share/name``.
        model_path: folders that hold Gazebo models by name.
        allow_roots: further folders from which files may be read.
        outside: whether files outside of all roots are refused or read all the same.
    """

    packages: Mapping[str, Path] = field(default_factory=dict)
    ros_package_path: tuple[Path, ...] = ()
    ament_prefix_path: tuple[Path, ...] = ()
    model_path: tuple[Path, ...] = ()
    allow_roots: tuple[Path, ...] = ()
    outside: Literal["refuse", "read"] = "refuse"

    def __post_init__(self) -> None:
        frozen = {name: Path(os.path.abspath(path)) for name, path in self.packages.items()}
        object.__setattr__(self, "packages", MappingProxyType(frozen))
        roots = tuple(Path(os.path.abspath(root)) for root in self.allow_roots)
        object.__setattr__(self, "allow_roots", roots)

    @classmethod
    def from_environment(
        cls,
        environment: Mapping[str, str] | None = None,
        *,
        packages: Mapping[str, Path] | None = None,
        allow_roots: Sequence[Path] = (),
    ) -> Resolver:
        """With the paths that ROS and Gazebo keep in the environment.

        ``ASSETPIPE_ALLOW_ROOTS`` holds further folders from which files may be read.
        """
        environment = os.environ if environment is None else environment

        def paths(*names: str) -> tuple[Path, ...]:
            parts = [p for n in names for p in environment.get(n, "").split(os.pathsep) if p]
            return tuple(dict.fromkeys(Path(os.path.abspath(p)) for p in parts))

        return cls(
            packages=dict(packages or {}),
            ros_package_path=paths("ROS_PACKAGE_PATH"),
            ament_prefix_path=paths("AMENT_PREFIX_PATH"),
            model_path=paths(*_MODEL_PATHS),
            allow_roots=(*allow_roots, *paths("ASSETPIPE_ALLOW_ROOTS")),
        )

    def settings(self) -> dict[str, Any]:
        """JSON-ready, for :meth:`from_settings` in another process."""
        return {
            "packages": {name: str(path) for name, path in self.packages.items()},
            "ros_package_path": [str(path) for path in self.ros_package_path],
            "ament_prefix_path": [str(path) for path in self.ament_prefix_path],
            "model_path": [str(path) for path in self.model_path],
            "allow_roots": [str(path) for path in self.allow_roots],
            "outside": self.outside,
        }

    @classmethod
    def from_settings(cls, settings: Mapping[str, Any]) -> Resolver:
        """What :meth:`settings` said."""

        def paths(name: str) -> tuple[Path, ...]:
            return tuple(Path(text) for text in settings[name])

        return cls(
            packages={name: Path(text) for name, text in settings["packages"].items()},
            ros_package_path=paths("ros_package_path"),
            ament_prefix_path=paths("ament_prefix_path"),
            model_path=paths("model_path"),
            allow_roots=paths("allow_roots"),
            outside=settings["outside"],
        )

    def allowing(self, *roots: Path) -> Resolver:
        """The same with more folders from which files may be read."""
        return replace(self, packages=dict(self.packages), allow_roots=(*self.allow_roots, *roots))

    def beside(self, description: Path) -> Lookup:
        """References of one description, which count from where its file lies."""
        return Lookup(self, Path(os.path.abspath(description)))
