"""A run in a folder: a scene is simulated and recorded, from its start or from a checkpoint."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from warp_mps.core.interrupts import first_interrupt_only, raise_when_killed
from warp_mps.core.streams import reserve_descriptors, say
from warp_mps.core.warp_turn import warp_turn
from warp_mps.errors import InputError
from warp_mps.observers.base import Observer
from warp_mps.observers.causes import FOR_CLOSED
from warp_mps.observers.guest import guests
from warp_mps.observers.progress import Progress
from warp_mps.results.summary import RunSummary
from warp_mps.run.far_scenes import remarks_on_far_scene
from warp_mps.run.folder import claim_folder, require_folder
from warp_mps.run.locks import lock_folder
from warp_mps.run.provenance import differences, fingerprint, identity, versions
from warp_mps.run.recording import Recording
from warp_mps.run.remarks import remarks_on_case
from warp_mps.run.restart import restart
from warp_mps.run.simulation import Simulation, require_scene
from warp_mps.scene import Scene
from warp_mps.scene.choices import PrecisionName


@raise_when_killed(again=True)
def run_scene(
    scene: Scene,
    folder: str | Path,
    *,
    device: str = "cpu",
    precision: PrecisionName = "float64",
    threads: int = 1,
    overwrite: bool = False,
    resume: bool = False,
    checkpoint_interval: float = 60.0,
    quiet: bool = False,
    observers: Sequence[Observer] = (),
) -> RunSummary:
    """Simulate a scene and leave run.usdc, probes.csv, run.json and checkpoint.npz in a folder.

    Args:
        scene: The case.
        folder: The folder; it is made if need be.
        device: ``cpu``, or a CUDA device such as ``cuda:0``.
        precision: ``float64`` or ``float32``.
        threads: CPU threads that share the particles.
        overwrite: Replaces the results that the folder holds.
        resume: Continues from the folder's checkpoint.
        checkpoint_interval: Wall seconds between two checkpoints; they are taken at frames.
        quiet: Shows no progress.
        observers: Observers of one's own, called after the results of a moment are recorded. If one raises an
            exception, the run ends as failed with its checkpoint kept, and a `RunError` is chained to the exception.

    Returns:
        What run.json holds.

    Raises:
        InputError: The scene cannot be run, or the folder cannot be used, e.g. since another run is using it.
        RunError: The run had to be stopped; its results so far are kept, and run.json says why.
        KeyboardInterrupt: It was interrupted; likewise. SIGTERM and SIGHUP, unless the program handles or ignores them,
            end the run in the same way and then the process, as they would have done at once. In another thread than
            the main one no signal arrives: the process ends, and run.json goes on saying ``running``.
    """
    require_scene(scene)
    reserve_descriptors()
    folder = require_folder(folder)
    if not checkpoint_interval >= 0.0:
        raise InputError("", "checkpoint_interval", f"is {checkpoint_interval:g}, must be 0 or more seconds")
    given = guests(observers)
    with lock_folder(folder):
        options: dict[str, Any] = {"overwrite": overwrite, "resume": resume, "settings": identity(scene, precision)}
        checkpoint = claim_folder(folder, fingerprint(scene, precision), announce=say, **options)
        progress = Progress(every=1, quiet=quiet)
        announce = None if quiet else say
        simulation = Simulation(scene, device=device, precision=precision, threads=threads, announce=announce)
        longest, limit = simulation.longest_step
        if longest > limit:
            say(f"the time step of {longest:.4g} s is above the limit of {limit:.4g} s: expect an unstable run")
        closed = _is_closed(simulation)
        found = remarks_on_case(scene, simulation.particles)
        found += remarks_on_far_scene(scene, simulation.particles, precision)
        if closed:
            found += _remarks_on_closed_fluid(scene)
        for line in [] if quiet else found:
            say(line)
        if checkpoint is not None:
            restart(simulation, checkpoint, folder)
            for line in differences(checkpoint.records, versions(), simulation.device):
                say(line)
        try:
            recording = Recording(
                simulation,
                folder,
                progress,
                resumed=checkpoint is not None,
                closed=closed,
                records=checkpoint.records if checkpoint else {},
                interval=checkpoint_interval,
                remarks=found,
                observers=given,
            )
        except OSError as error:
            raise InputError(str(folder), "", f"cannot be written: {error.strerror}") from error
        with first_interrupt_only():
            try:
                return recording.execute()
            finally:
                for line in [] if quiet else recording.remarks:
                    say(line)


def _is_closed(simulation: Simulation) -> bool:
    """Whether the fluids of a scene without bodies start without a free surface."""
    if not simulation.scene.fluids or simulation.scene.bodies:
        return False
    with warp_turn:
        return simulation.fluids.step.is_closed()


def _remarks_on_closed_fluid(scene: Scene) -> list[str]:
    """Lines about a fluid without a free surface, which neither clipped pressures nor every scheme let rest."""
    scheme, pressures = FOR_CLOSED
    flow, lines = scene.flow, []
    if flow.negative_pressure != pressures:
        needed = f"needs negative pressures, and they are '{flow.negative_pressure}'"
        lines.append(f"no free surface: a fluid that fills its walls {needed}")
    if flow.scheme != scheme and scene.walls and any(scene.gravity):
        lines.append(f"no free surface: the scheme '{flow.scheme}' stirs a fluid that fills its walls; take '{scheme}'")
    return lines
