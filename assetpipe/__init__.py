"""Collision assets for robots: certified convex decomposition, written and proved."""

from __future__ import annotations

from typing import TYPE_CHECKING

from assetpipe.lazy import lazily

__version__ = "0.1.0"

if TYPE_CHECKING:
    from assetpipe.decomposition import Decomposition, Hull, Params, Tolerance, certify, decompose
    from assetpipe.geometry import Mesh
    from assetpipe.pipeline.build import build
    from assetpipe.pipeline.compare import Validation, validate
    from assetpipe.pipeline.config import Config
    from assetpipe.pipeline.result import BuildResult
    from assetpipe.validation.bracket import Bracket

_HOMES = {
    "Bracket": "assetpipe.validation.bracket",
    "BuildResult": "assetpipe.pipeline.result",
    "Config": "assetpipe.pipeline.config",
    "Decomposition": "assetpipe.decomposition",
    "Hull": "assetpipe.decomposition",
    "Mesh": "assetpipe.geometry",
    "Params": "assetpipe.decomposition",
    "Tolerance": "assetpipe.decomposition",
    "Validation": "assetpipe.pipeline.compare",
    "build": "assetpipe.pipeline.build",
    "certify": "assetpipe.decomposition",
    "decompose": "assetpipe.decomposition",
    "validate": "assetpipe.pipeline.compare",
}
"""Where each public name lives; imported when first asked for: `import assetpipe` is cheap."""

__all__ = [
    "Bracket",
    "BuildResult",
    "Config",
    "Decomposition",
    "Hull",
    "Mesh",
    "Params",
    "Tolerance",
    "Validation",
    "__version__",
    "build",
    "certify",
    "decompose",
    "validate",
]


__getattr__ = lazily(__name__, _HOMES)


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOMES})
