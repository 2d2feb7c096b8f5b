"""Units and up-axes of mesh files, handled once: afterwards every length is metres, Z up.

What reads a mesh that a URDF names does not agree about axes:

* ``<unit>`` of COLLADA is honoured by RViz, Gazebo and PyBullet; trimesh and yourdfpy
  ignore it. We honour it.
* ``<up_axis>`` of COLLADA is ignored by RViz, MoveIt, Gazebo and, for collision shapes, by
  PyBullet (it turns visuals only). At the same time MeshLab and pycollada (and with it
  trimesh) write ``Y_UP`` into every file without turning a single coordinate: in public robot
  packages nearly all ``Y_UP`` files are of that kind.
* glTF is Y-up by its specification (§3.4). RViz (since Jazzy) and Drake turn it; Gazebo and
  trimesh don't, and trimesh writes it unturned.

The default ``"trusted"`` therefore turns the mesh to Z-up as the file declares, except where
the file was written by a program that declares its up-axis out of habit.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from assetpipe.geometry.formats.raw import RawMesh
from assetpipe.geometry.mesh import Mesh
from assetpipe.geometry.products import turned
from assetpipe.geometry.strays import referenced

AxisPolicy = Literal["trusted", "declared", "ignored"]
"""Whether a declared up-axis is believed: unless written by habit, always, or never."""

_Z_UP_FROM = {
    # COLLADA 1.4.1 §5 up_axis: right, up and in axes of X_UP are -Y, +X, +Z; of Y_UP +X, +Y,
    # +Z; of Z_UP +X, +Z, -Y.
    "X_UP": np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]]),
    "Y_UP": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
}


@dataclass(frozen=True)
class Converted:
    """A mesh in metres, Z-up, and what was done to bring it there."""

    mesh: Mesh
    notes: tuple[str, ...]


def to_metres_z_up(raw: RawMesh, *, axes: AxisPolicy = "trusted") -> Converted:
    """Bring a file's mesh into metres with Z up.

    Args:
        raw: the mesh as in its file.
        axes: whether the declared up-axis is believed.

    Raises:
        MeshError: values that are not finite, or become so by the unit.
    """
    notes = []
    vertices = raw.vertices
    if raw.metres_per_unit != 1.0:
        notes.append(f"unit converted: 1 unit of the file is {raw.metres_per_unit:g} m")
        vertices = vertices * raw.metres_per_unit
    if raw.up_axis != "Z_UP":
        if axes == "ignored":
            notes.append(f"declared up-axis {raw.up_axis} ignored as asked")
        elif axes == "trusted" and raw.axis_by_habit is not None:
            notes.append(
                f"declared up-axis {raw.up_axis} not applied: {raw.axis_by_habit} writes it "
                "whatever the coordinates are"
            )
        else:
            notes.append(f"turned from {raw.up_axis} to Z_UP")
            vertices = turned(vertices, _Z_UP_FROM[raw.up_axis])
    faces = raw.faces
    if len(faces) and faces.min() >= 0 and faces.max() < len(vertices):
        # Nothing is drawn with the others: they may be anywhere, and need not be numbers.
        vertices, faces = referenced(vertices, faces)
    return Converted(Mesh(vertices, faces), (*raw.notes, *notes))
