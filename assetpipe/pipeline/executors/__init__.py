"""Where tasks run: one interface, on this machine or on a cluster."""

from assetpipe.pipeline.executors.task import Executor, Fault, Reply, Task

__all__ = ["Executor", "Fault", "Reply", "Task"]
