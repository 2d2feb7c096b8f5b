"""Boxes, cylinders, spheres and capsules of a URDF."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation
from verify.urdf import SIMPLE, origin


def matrix_of(element) -> np.ndarray:
    """(4, 4) from an element's origin: rotations about fixed x, y, z."""
    x, y, z, roll, pitch, yaw = origin(element)
    result = np.eye(4)
    result[:3, :3] = Rotation.from_euler("xyz", [roll, pitch, yaw]).as_matrix()
    result[:3, 3] = x, y, z
    return result


def simple_shape(child, element) -> tuple[str, np.ndarray, list[float]] | None:
    """Kind, frame relative to the old element, and sizes of a box, cylinder, capsule, sphere."""
    for kind, names in SIMPLE.items():
        found = child.find(f"geometry/{kind}")
        if found is not None:
            sizes = [float(v) for name in names for v in (found.get(name) or "").split()]
            return kind, np.linalg.inv(matrix_of(element)) @ matrix_of(child), sizes
    return None


def beyond_shape(points: np.ndarray, shape) -> np.ndarray:
    """How far points lie outside of a simple shape; at most 0 inside."""
    kind, frame, sizes = shape
    local = (points - frame[:3, 3]) @ frame[:3, :3]
    if kind == "box":
        return (np.abs(local) - 0.5 * np.array(sizes)).max(axis=1)
    if kind == "sphere":
        return np.linalg.norm(local, axis=1) - sizes[0]
    radius, half = sizes[0], 0.5 * sizes[1]
    across, along = np.linalg.norm(local[:, :2], axis=1), np.abs(local[:, 2])
    if kind == "cylinder":
        return np.maximum(across - radius, along - half)
    return np.hypot(across, np.maximum(along - half, 0.0)) - radius


def on_shape(shape, rng, count: int = 2000) -> np.ndarray:
    """Points on the surface of a simple shape, and corners of a box."""
    kind, frame, sizes = shape
    unit = rng.normal(size=(count, 3))
    unit /= np.linalg.norm(unit, axis=1, keepdims=True)
    if kind == "box":
        local = np.vstack([np.sign(unit), unit / np.abs(unit).max(axis=1, keepdims=True)])
        local *= 0.5 * np.array(sizes)
    elif kind == "sphere":
        local = unit * sizes[0]
    elif kind == "cylinder":
        ring = unit[:, :2] / np.linalg.norm(unit[:, :2], axis=1, keepdims=True) * sizes[0]
        local = np.column_stack([ring, np.sign(unit[:, 2]) * 0.5 * sizes[1]])
    else:
        local = unit * sizes[0] + np.sign(unit[:, 2:]) * [0.0, 0.0, 0.5 * sizes[1]]
    return local @ frame[:3, :3].T + frame[:3, 3]
