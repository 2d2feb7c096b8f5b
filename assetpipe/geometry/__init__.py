"""Meshes as frozen values: files, units, health and repair."""

from assetpipe.geometry.mesh import Mesh

__all__ = ["Mesh"]
