"""The recording of a run: its observers, and a summary that is kept up to date until the end."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from warp_mps.core.warp_turn import warp_turn
from warp_mps.errors import InputError, RunError
from warp_mps.observers import checkpoint as checkpoint_file
from warp_mps.observers.base import Observer
from warp_mps.observers.checkpoint import CheckpointWriter
from warp_mps.observers.frames import FrameRecorder
from warp_mps.observers.guard import Guard
from warp_mps.observers.momentum import MomentumMonitor
from warp_mps.observers.probes import ProbeRecorder
from warp_mps.observers.progress import Progress
from warp_mps.observers.records import numbers_of
from warp_mps.results.settings import scene_settings
from warp_mps.results.summary import RunStatus, RunSummary, energy_record, measurement_rows
from warp_mps.run.folder import ANIMATION, PROBES, SUMMARY, remove_results
from warp_mps.run.provenance import fingerprint, identity, provenance, versions
from warp_mps.run.remarks import remarks_on_end
from warp_mps.run.schedule import Trigger
from warp_mps.run.simulation import Simulation
from warp_mps.run.spilled import count_spilled

EMPTY: Mapping[str, Any] = MappingProxyType({})


class Recording:
    """A run with its observers and its summary, run.json.

    Attributes:
        observers: All observers, in the order in which they are called.
        remarks: Remarks on the run, once it has ended.

    Args:
        simulation: The simulation, at its start or restored.
        folder: Folder of the results.
        progress: Shows how far the run is.
        resumed: Whether results in the folder are continued.
        closed: Whether fluids start without a free surface.
        interval: Wall time between two checkpoints [s].
        records: Records of the checkpoint from which results are continued.
        remarks: Remarks on the case.
        observers: Observers of the user, called after those that record.

    Raises:
        InputError: A probe is in no body, an observer of the user is invalid, or results to continue do not match.
        OSError: The folder cannot be written.
    """

    observers: list[Observer]

    def __init__(
        self,
        simulation: Simulation,
        folder: Path,
        progress: Progress,
        *,
        resumed: bool,
        closed: bool,
        interval: float,
        records: Mapping[str, Any] = EMPTY,
        remarks: Sequence[str] = (),
        observers: Sequence[Observer] = (),
    ) -> None:
        scene, particles, clock = simulation.scene, simulation.particles, simulation.clock
        self._simulation, self._folder = simulation, folder
        progress.every = clock.sample_every
        for observer in observers:
            Trigger(clock, observer.every, observer.interval)  # refuses invalid ones before anything is removed

        def last_kept(every: int) -> float | None:
            """Time up to which results stay: a run that was to end off the grid has one row and frame too many."""
            return clock.time(simulation.step // every * every) if resumed else None

        self._guard, self._momentum = _make_guard(simulation, closed=closed), MomentumMonitor(every=clock.frame_every)
        # wall time of earlier runs that this one continues [s], and when this one began
        self._earlier, self._begin = 0.0, time.perf_counter()
        if resumed:
            self._take_up(records)
        # only probes can still refuse the scene, so they come before anything is removed
        self._probes = ProbeRecorder(
            folder / PROBES,
            scene,
            particles,
            every=clock.sample_every,
            resume_after=last_kept(clock.sample_every),
            resume_mark=records.get("rows"),
        )
        if not resumed:
            remove_results(folder)
        self._frames = FrameRecorder(
            folder / ANIMATION,
            scene,
            particles,
            every=clock.frame_every,
            provenance=provenance(simulation),
            resume_after=last_kept(clock.frame_every),
            resume_mark=records.get("frames"),
        )
        # what a run that continues this one compares
        self._origin = {
            "versions": versions(),
            "device": simulation.device,
            "settings": identity(scene, simulation.precision),
        }
        self.observers = [
            # first, so that no invalid state is recorded
            self._guard,
            self._momentum,
            self._probes,
            self._frames,
            CheckpointWriter(
                folder,
                fingerprint(scene, simulation.precision),
                every=clock.frame_every,
                interval=interval,
                records=self._records,
                results=(folder / PROBES, folder / ANIMATION),
            ),
            # after all that record, so that a moment at which one of them fails is kept
            *observers,
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
            remarks=list(remarks),
        )
        # remarks on the run, once it has ended
        self.remarks: list[str] = []

    def execute(self) -> RunSummary:
        """Run to the end, and say in run.json how it went, whatever happens.

        Raises:
            RunError: The run had to be stopped, or a file can no longer be written.
            KeyboardInterrupt: It was interrupted.
        """
        self._begin = time.perf_counter()
        try:
            self._summary.write(self._folder / SUMMARY)
            self._simulation.run(self.observers)
            self._finish("done", "")
        except OSError as error:
            reason = f"{error.filename}: cannot be written: {error.strerror}"
            self._give_up(reason)
            raise RunError(reason) from error
        except KeyboardInterrupt as interrupt:
            kept = (self._folder / checkpoint_file.NAME).exists()
            self._give_up(f"{str(interrupt) or 'interrupted'}{'; continue with --resume' * kept}")
            raise
        except BaseException as error:
            self._give_up(str(error) if isinstance(error, RunError) else repr(error))
            raise
        return self._summary

    def _records(self) -> dict[str, Any]:
        """Facts about the run at this moment, for a checkpoint."""
        marks = {"rows": self._probes.mark(), "frames": self._frames.mark()}
        seen = {"guard": self._guard.record(), "momentum": self._momentum.record()}
        return {**self._origin, **marks, **seen, "wall_seconds": self._wall_seconds()}

    def _take_up(self, records: Mapping[str, Any]) -> None:
        """Go on from the records of a checkpoint.

        Raises:
            InputError: They are not those of a run of this case.
        """
        try:
            self._guard.restore(records.get("guard"))
            self._momentum.restore(records.get("momentum"))
            (self._earlier,) = numbers_of(records, ["wall_seconds"])
        except ValueError as error:
            path = self._folder / checkpoint_file.NAME
            raise InputError(str(path), "", f"does not fit this case: {error}; start a new run") from error

    def _wall_seconds(self) -> float:
        """Wall time of the steps since the start [s], as far as a checkpoint knows of it."""
        return self._earlier + time.perf_counter() - self._begin

    def _give_up(self, reason: str) -> None:
        """Say why in run.json, if that can still be written: the first error counts."""
        with contextlib.suppress(OSError):
            self._finish("failed", reason)

    def _finish(self, status: RunStatus, reason: str) -> None:
        simulation, history = self._simulation, self._probes.history
        wall, particles, steps = self._wall_seconds(), simulation.particles, simulation.steps_done
        solvers: dict[str, Any] = {**simulation.record()}
        if "fluid" in solvers:
            solvers["fluid"]["outside"] = count_spilled(simulation.scene, particles, simulation.positions)
        scene, places, velocities = simulation.scene, simulation.positions, simulation.velocities
        self.remarks = [*self._guard.remarks, *remarks_on_end(scene, particles, places, velocities)]
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
            remarks=[*self._summary.remarks, *self.remarks],
            **solvers,
        )
        self._summary.write(self._folder / SUMMARY)


def _make_guard(simulation: Simulation, *, closed: bool) -> Guard:
    """The guard of a run; the weight that lets a fluid settle includes body forces."""
    forces = simulation.fluids.step.body_forces if simulation.scene.fluids else None
    with warp_turn:
        largest = forces.largest() if forces else 0.0
    longest, limit = simulation.longest_step
    return Guard(
        every=simulation.clock.sample_every,
        time_step=longest,
        limit=limit,
        closed=closed,
        energy=simulation.scene.analysis != "static",
        body_force=largest,
    )
