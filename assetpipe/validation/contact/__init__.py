"""Contact truth: the original mesh against its hulls, near contact (FCL)."""

from assetpipe.validation.contact.coverage import Coverage, cover
from assetpipe.validation.contact.probes import Probe
from assetpipe.validation.contact.surface import ConvexShape, Frame, Surface
from assetpipe.validation.contact.truth import ContactTruth, ProbeTally, Witness, contact_truth

__all__ = [
    "ContactTruth",
    "ConvexShape",
    "Coverage",
    "Frame",
    "Probe",
    "ProbeTally",
    "Surface",
    "Witness",
    "contact_truth",
    "cover",
]
