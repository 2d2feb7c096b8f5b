"""A glTF of one triangle, to be changed by tests."""

import base64
from typing import Any

import numpy as np

POINTS = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0]], dtype="<f4")


def gltf(**change: Any) -> dict[str, Any]:
    """Its tree, with top-level entries changed."""
    data = POINTS.tobytes() + np.arange(3, dtype="<u2").tobytes()
    tree: dict[str, Any] = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 36},
            {"buffer": 0, "byteOffset": 36, "byteLength": 6},
        ],
        "buffers": [
            {
                "byteLength": len(data),
                "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode(),
            }
        ],
    }
    return tree | change
