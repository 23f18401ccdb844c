"""Cost of a run, estimated before it starts: particles, steps, memory, disk, CPU time."""

from warp_mps.run.cost.estimate import Cost, estimate
from warp_mps.run.cost.memory import available_memory, memory_of, refuse_too_large

__all__ = ["Cost", "available_memory", "estimate", "memory_of", "refuse_too_large"]
