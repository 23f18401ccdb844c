"""A run in a folder: a scene is simulated, recorded, summed up, and can be continued."""

from __future__ import annotations

import contextlib
import hashlib
import os
import sys
import time
from dataclasses import replace
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from warp_mps import __version__
from warp_mps.core.interrupts import single_interrupt
from warp_mps.errors import InputError, RunError
from warp_mps.observers import checkpoint as checkpoint_file
from warp_mps.observers.base import Observer
from warp_mps.observers.checkpoint import Checkpoint, CheckpointWriter, load_checkpoint
from warp_mps.observers.frames import FrameRecorder
from warp_mps.observers.guard import Guard
from warp_mps.observers.momentum import MomentumMonitor
from warp_mps.observers.probes import ProbeRecorder
from warp_mps.observers.progress import Progress
from warp_mps.results.settings import scene_settings
from warp_mps.results.summary import RunSummary, energy_record, measurement_rows
from warp_mps.run.cost import refuse_too_large
from warp_mps.run.locks import lock_folder
from warp_mps.run.simulation import Simulation
from warp_mps.scene import Scene
from warp_mps.scene.validation.fluids import remarks

ANIMATION, PROBES, SUMMARY = "run.usdc", "probes.csv", "run.json"


def run_scene(
    scene: Scene,
    folder: str | Path,
    *,
    device: str = "cpu",
    precision: str = "float64",
    threads: int = 1,
    overwrite: bool = False,
    resume: bool = False,
    checkpoint_interval: float = 60.0,
    quiet: bool = False,
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

    Returns:
        What run.json holds.

    Raises:
        InputError: The scene cannot be run, or the folder not be used, e.g. as another run is at work in it.
        RunError: The run had to be stopped; what was computed is kept, and run.json says why.
        KeyboardInterrupt: It was interrupted; likewise.
    """
    folder = Path(folder)
    if not checkpoint_interval >= 0.0:
        raise InputError("", "checkpoint_interval", f"is {checkpoint_interval:g}, must be 0 or more seconds")
    if device == "cpu":
        refuse_too_large(scene)
    with lock_folder(folder):
        checkpoint = _claim(folder, scene, precision, overwrite=overwrite, resume=resume)
        progress = Progress(every=1, quiet=quiet)
        announce = None if quiet else _say
        simulation = Simulation(scene, device=device, precision=precision, threads=threads, announce=announce)
        longest, limit = simulation.longest_step
        if longest > limit:
            _say(f"the time step of {longest:.4g} s is above the limit of {limit:.4g} s: expect an unstable run")
        for line in [] if quiet else [*remarks(scene), *_closed(simulation)]:
            _say(line)
        if checkpoint is not None:
            simulation.restore(checkpoint.arrays)
            if simulation.step > simulation.total_steps:
                reason = f"its checkpoint is at {checkpoint.time:.6g} s, past the end of {scene.duration:.6g} s"
                raise InputError(str(folder), "", f"cannot be resumed: {reason}")
        try:
            run = _Run(simulation, folder, progress, resumed=checkpoint is not None, interval=checkpoint_interval)
        except OSError as error:
            raise InputError(str(folder), "", f"cannot be written: {error.strerror}") from error
        with single_interrupt():
            return run.execute()


class _Run:
    """The observers of a run and its summary, kept up to date until the end."""

    def __init__(
        self, simulation: Simulation, folder: Path, progress: Progress, *, resumed: bool, interval: float
    ) -> None:
        scene, particles, clock = simulation.scene, simulation.particles, simulation.clock
        self._simulation, self._folder = simulation, folder
        self._first_step = simulation.steps_done
        progress.every = clock.sample_every

        def last_kept(every: int) -> float | None:
            """Time up to which results stay: a run that was to end off the grid has one row and frame too many."""
            return clock.time(simulation.step // every * every) if resumed else None

        # probes are the only ones that can still refuse the scene: they come before anything is removed
        self._probes = ProbeRecorder(
            folder / PROBES,
            scene,
            particles,
            every=clock.sample_every,
            resume_after=last_kept(clock.sample_every),
        )
        if not resumed:
            _remove_results(folder)
        self._momentum = MomentumMonitor(every=clock.frame_every)
        self._observers: list[Observer] = [
            # first, so that nothing is recorded of a state that is not one
            Guard(every=clock.sample_every, time_step=clock.dt, energy=scene.analysis != "static"),
            self._momentum,
            self._probes,
            FrameRecorder(
                folder / ANIMATION,
                scene,
                particles,
                every=clock.frame_every,
                provenance=_provenance(simulation),
                resume_after=last_kept(clock.frame_every),
            ),
            CheckpointWriter(
                folder,
                fingerprint(scene, simulation.precision),
                every=clock.frame_every,
                interval=interval,
                results=(folder / PROBES, folder / ANIMATION),
            ),
            progress,
        ]
        counts = np.diff(particles.ranges, axis=1).ravel()
        self._summary = RunSummary(
            case=scene.name,
            device=simulation.device,
            precision=simulation.precision,
            versions=versions(),
            dimension=scene.dimension,
            particles={name: int(count) for name, count in zip(particles.names, counts, strict=True)},
            settings=scene_settings(scene),
        )

    def execute(self) -> RunSummary:
        """Run to the end, and say in run.json how it went, whatever happens.

        Raises:
            RunError: The run had to be stopped, or a file can no longer be written.
            KeyboardInterrupt: It was interrupted.
        """
        begin = time.perf_counter()
        try:
            self._summary.write(self._folder / SUMMARY)
            self._simulation.run(self._observers)
            self._finish("done", "", begin)
        except OSError as error:
            reason = f"{error.filename}: cannot be written: {error.strerror}"
            self._give_up(reason, begin)
            raise RunError(reason) from error
        except KeyboardInterrupt:
            kept = (self._folder / checkpoint_file.NAME).exists()
            self._give_up("interrupted" + "; continue with --resume" * kept, begin)
            raise
        except BaseException as error:
            self._give_up(str(error) if isinstance(error, RunError) else repr(error), begin)
            raise
        return self._summary

    def _give_up(self, reason: str, begin: float) -> None:
        """Say why in run.json, if that can still be written: the first error counts."""
        with contextlib.suppress(OSError):
            self._finish("failed", reason, begin)

    def _finish(self, status: str, reason: str, begin: float) -> None:
        simulation, history = self._simulation, self._probes.history
        wall = time.perf_counter() - begin
        particles, steps = simulation.particles, simulation.steps_done - self._first_step
        solvers: dict[str, Any] = {**simulation.record()}
        done = {"solid": steps * particles.elastic, "fluid": steps * particles.liquid}
        self._summary = replace(
            self._summary,
            status=status,
            reason=reason,
            steps=simulation.steps_done,
            time=simulation.time,
            wall_seconds=wall,
            particle_steps_per_second={
                kind: count / wall if wall > 0.0 and count else None for kind, count in done.items()
            },
            energy=energy_record(history, fluids=bool(simulation.scene.fluids)),
            momentum_error=self._momentum.error,
            measurements=measurement_rows(simulation.scene, history),
            **solvers,
        )
        self._summary.write(self._folder / SUMMARY)


def fingerprint(scene: Scene, precision: str) -> str:
    """A hash of everything that decides a run's numbers; how long it runs is not among it."""
    with np.printoptions(threshold=10**9, precision=17):
        text = repr((replace(scene, duration=1.0, measurements=(), description="", path="scene"), precision))
    return hashlib.sha256(text.encode()).hexdigest()


def versions() -> dict[str, str]:
    """Versions of this program and of what it stands on."""
    found = {"warp_mps": __version__}
    for name in ("warp-lang", "numpy", "usd-core"):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "unknown"
    return found


def _provenance(simulation: Simulation) -> dict[str, str | float | int]:
    scene = simulation.scene
    return {
        "case": scene.name,
        "program": f"warp_mps {__version__}",
        "model": scene.flow.scheme if scene.fluids else scene.elasticity.model,
        "analysis": scene.analysis,
        "device": simulation.device,
        "precision": simulation.precision,
        "time step [s]": simulation.dt,
    }


def _closed(simulation: Simulation) -> list[str]:
    """A line about a fluid that walls extend_view, and that pulls at them where it has its place."""
    scene = simulation.scene
    if not scene.fluids or scene.bodies or scene.flow.negative_pressure != "clipped":
        return []
    reason = "no free surface: a fluid that fills its walls needs negative pressures, and they are 'clipped'"
    return [reason] * simulation.fluids.step.is_closed()


def _say(message: str) -> None:
    print(f"warp-mps: {message}", file=sys.stderr, flush=True)


def _claim(folder: Path, scene: Scene, precision: str, *, overwrite: bool, resume: bool) -> Checkpoint | None:
    """Make sure that the folder can be written and that nothing in it is lost; the checkpoint to go on from, if any."""
    if overwrite and resume:
        raise InputError(str(folder), "", "give either --overwrite or --resume, not both")
    if folder.exists() and not folder.is_dir():
        raise InputError(str(folder), "", "is a file; the output must be a folder")
    if resume:
        return load_checkpoint(folder, fingerprint(scene, precision), announce=_say)
    if (folder / SUMMARY).exists() and not overwrite:
        raise InputError(
            str(folder), "", "already has results; use --overwrite to replace or --resume to continue them"
        )
    _refuse_unwritable(folder)
    return None


def _remove_results(folder: Path) -> None:
    """Remove what an earlier run left, so that nothing of it can be taken for a part of this one."""
    for name in (ANIMATION, SUMMARY, checkpoint_file.NAME, checkpoint_file.PREVIOUS):
        (folder / name).unlink(missing_ok=True)


def _refuse_unwritable(folder: Path) -> None:
    parent = folder
    while not parent.exists():
        parent = parent.parent
    if not parent.is_dir():
        raise InputError(str(folder), "", f"cannot be made: {parent} is a file")
    if not os.access(parent, os.W_OK | os.X_OK):
        raise InputError(str(folder), "", f"cannot be written: no permission in {parent}")
