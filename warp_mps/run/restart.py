"""The restart of a simulation from a checkpoint, whose arrays must be those of the simulation."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from warp_mps.errors import InputError
from warp_mps.observers import checkpoint as checkpoint_file
from warp_mps.observers.checkpoint import Checkpoint
from warp_mps.run.simulation import Simulation


def restart(simulation: Simulation, checkpoint: Checkpoint, folder: Path) -> None:
    """Continue a simulation from a checkpoint in a folder.

    Raises:
        InputError: The checkpoint is beyond the end of the run, or its arrays do not fit the simulation.
    """
    wrong = misfit(simulation.state_arrays(), checkpoint.arrays)
    if not wrong and int(checkpoint.arrays["step"]) != checkpoint.step:
        wrong = f"step is {checkpoint.arrays['step']}, must be {checkpoint.step}"
    # explicit steps of bodies alone are those of the run; they are counted where something moves
    scene = simulation.scene
    if not wrong and not scene.fluids and not scene.implicit:
        counted = int(checkpoint.arrays["steps"][0])
        if counted not in (0, checkpoint.step):
            wrong = f"steps is {counted}, must be {checkpoint.step}"
    if not wrong:
        try:
            simulation.restore(checkpoint.arrays)
        # arrays that fit by themselves, but not one another
        except (ValueError, TypeError, IndexError, RuntimeError) as error:
            wrong = " ".join(str(error).split())
    if wrong:
        path = folder / checkpoint_file.NAME
        raise InputError(str(path), "", f"does not fit this case: {wrong}; start a new run")
    if simulation.step > simulation.total_steps:
        reason = f"its checkpoint is at {checkpoint.time:.6g} s, past the end of {simulation.scene.duration:.6g} s"
        raise InputError(str(folder), "", f"cannot be resumed: {reason}")


def misfit(fresh: Mapping[str, np.ndarray], saved: Mapping[str, np.ndarray]) -> str:
    """The first array of a checkpoint that cannot be one of a simulation; empty if there is none.

    Args:
        fresh: Arrays of the simulation at its start; a length of 0 stands for any, as of what a solver has learnt.
        saved: Arrays of the checkpoint, which may have others besides.
    """
    for name, expected in fresh.items():
        found = saved.get(name)
        if found is None:
            return f"{name} is missing"
        fits = len(found.shape) == len(expected.shape) and all(
            wanted in (0, length) for wanted, length in zip(expected.shape, found.shape, strict=True)
        )
        if found.dtype != expected.dtype or not fits:
            kinds = f"{found.dtype} of shape {found.shape}, must be {expected.dtype} of shape {expected.shape}"
            return f"{name} is {kinds}"
        # the largest residual of a run may be NaN; its counters are checked by those that count
        if name.endswith("_statistics"):
            continue
        # an interval that is not known yet is infinite at the start
        known = found if found.dtype.kind != "f" or np.isfinite(expected).all() else found[~np.isinf(found)]
        if not np.isfinite(known).all():
            return f"{name} is not finite"
    return ""
