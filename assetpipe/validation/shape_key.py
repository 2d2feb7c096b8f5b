"""Meshes as keys: equal content, equal key."""

from __future__ import annotations

from dataclasses import dataclass

from assetpipe.geometry.mesh import Mesh


@dataclass(frozen=True, eq=False)
class ByContent:
    """A mesh that hashes by its content, so that pure functions of it can be memoised."""

    mesh: Mesh

    def __hash__(self) -> int:
        return hash(self.mesh.digest)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ByContent) and other.mesh.digest == self.mesh.digest
