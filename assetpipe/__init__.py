"""Collision assets for robots: certified convex decomposition, written and proved."""

__version__ = "0.1.0"
