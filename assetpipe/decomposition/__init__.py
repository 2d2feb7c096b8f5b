"""Certified convex decomposition of solids."""

from assetpipe.decomposition.baselines import ENGINES, decompose_with
from assetpipe.decomposition.certificate import Certificate, Interval
from assetpipe.decomposition.certification import certify
from assetpipe.decomposition.decomposition import Coverage, Decomposition, EngineName, Node
from assetpipe.decomposition.engine import decompose
from assetpipe.decomposition.hull import Hull
from assetpipe.decomposition.inner import InnerHull, inner_hulls
from assetpipe.decomposition.params import Cavities, Effort, Metric, Params
from assetpipe.decomposition.tolerance import Tolerance

__all__ = [
    "ENGINES",
    "Cavities",
    "Certificate",
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
    "Tolerance",
    "certify",
    "decompose",
    "decompose_with",
    "inner_hulls",
]
