"""Certified convex decomposition of solids."""

from assetpipe.decomposition.baselines import ENGINES, decompose_with
from assetpipe.decomposition.certificate import Certificate, Interval
from assetpipe.decomposition.certification import certify
from assetpipe.decomposition.decomposition import Coverage, Decomposition, EngineName, Node
from assetpipe.decomposition.engine import decompose
from assetpipe.decomposition.hull import Hull
from assetpipe.decomposition.inner import InnerHull, inner_hulls
from assetpipe.decomposition.params import Cavities, Effort, Metric, Params
from assetpipe.decomposition.primitives import Primitive, with_primitives
from assetpipe.decomposition.reach import Closed, Closing, close_unreachable
from assetpipe.decomposition.seams import Seams
from assetpipe.decomposition.shaping import Shapes
from assetpipe.decomposition.tolerance import Tolerance

__all__ = [
    "ENGINES",
    "Cavities",
    "Certificate",
    "Closed",
    "Closing",
    "Coverage",
    "Decomposition",
    "Effort",
    "EngineName",
    "Hull",
    "InnerHull",
    "Interval",
    "Metric",
    "Node",
    "Params",
    "Primitive",
    "Seams",
    "Shapes",
    "Tolerance",
    "certify",
    "close_unreachable",
    "decompose",
    "decompose_with",
    "inner_hulls",
    "with_primitives",
]
