"""What rungs are asked to do, for tests of one rung."""

from assetpipe.geometry import Mesh, RepairLimits, RepairPolicy
from assetpipe.geometry.repair.deadline import NEVER
from assetpipe.geometry.repair.frame import Frame
from assetpipe.geometry.repair.surface import Surface
from assetpipe.geometry.repair.work import Job


def job_on(mesh: Mesh, policy: RepairPolicy | None = None) -> Job:
    """A job without a deadline."""
    policy = policy or RepairPolicy()
    frame = Frame.around(mesh.vertices)
    surface = Surface(frame.inward(mesh.vertices), mesh.faces)
    budget = policy.budget_on(mesh) / frame.scale
    return Job(mesh, frame, surface, policy, RepairLimits(), budget, budget / 4.0, NEVER)
