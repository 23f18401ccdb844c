"""Recording of the probes and energies as probes.csv, a row flushed as soon as it is made."""

from __future__ import annotations

import hashlib
import math
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from warp_mps.errors import InputError, RunError
from warp_mps.observers.base import Observer, View
from warp_mps.observers.sampling import make_sampler
from warp_mps.particles.particles import Particles
from warp_mps.results.energy import ENERGY_NAMES
from warp_mps.results.history import TIME_LABEL, History, energy_labels, format_row, read_history, write_history
from warp_mps.results.regular_file import open_regular
from warp_mps.scene import Scene


class ProbeRecorder(Observer):
    """Records every probe of a scene and the energies, in probes.csv and in memory.

    Args:
        path: The file to write.
        scene: The case.
        particles: Its particles.
        every: Steps between two rows.
        resume_after: Continues an existing file after this time [s]; later rows are dropped. None starts a new one.
        resume_mark: What `mark` gave then.

    Raises:
        InputError: A probe is in no body, or the file to continue is missing, ends too early, or has other columns or
            rows.
    """

    def __init__(
        self,
        path: str | Path,
        scene: Scene,
        particles: Particles,
        *,
        every: int,
        resume_after: float | None = None,
        resume_mark: Mapping[str, Any] | None = None,
    ) -> None:
        self.every = every
        self._samplers = [make_sampler(probe, scene, particles) for probe in scene.probes]
        labels = [label for sampler in self._samplers for label in sampler.labels]
        self.history = History([TIME_LABEL, *labels, *energy_labels(scene.dimension)])
        if resume_after is not None:
            self.history = self._continued(Path(path), resume_after)
        self._digest, self._kept = hashlib.sha256(), 0
        for earlier in [self.history.labels, *map(format_row, self.history.rows)]:
            self._keep(earlier)
        if resume_mark is not None and self.mark() != resume_mark:
            reason = "has other rows than those that the run wrote before its checkpoint; start a new run"
            raise InputError(str(path), "", reason)
        self._path = Path(path)
        self._path.parent.mkdir(parents=True, exist_ok=True)
        write_history(path, self.history)

    def observe(self, view: View) -> None:
        """Add a row, unless there is one of this moment already: the last before the run was interrupted.

        Raises:
            RunError: A value of a probe is not finite, or the file cannot be written.
        """
        if view.time <= self.history.last_time:
            return
        row = [view.time]
        for sampler in self._samplers:
            values = [float(value) for value in sampler.sample(view)]
            for label, value in zip(sampler.labels, values, strict=True):
                if not math.isfinite(value):
                    raise RunError(f"the probe {label} is {value} at {view.time:.6g} s (step {view.step})")
            row.extend(values)
        row.extend(getattr(view.energy, name) for name in ENERGY_NAMES)
        self.history.append(row)
        self._write(row)
        # the last row of a run may lie off the grid, and a run that goes on from there replaces it
        if view.step % self.every == 0:
            self._keep(format_row(row))

    def mark(self) -> dict[str, Any]:
        """Number and digest of the rows that a continued run keeps, the labels included."""
        return {"count": self._kept, "sha256": self._digest.hexdigest()}

    def _keep(self, cells: Sequence[str]) -> None:
        self._digest.update(f"{','.join(cells)}\n".encode())
        self._kept += 1

    def _write(self, row: list[float]) -> None:
        try:
            # a link in its place would lead elsewhere
            flags = os.O_WRONLY | os.O_APPEND | getattr(os, "O_NOFOLLOW", 0)
            with open_regular(self._path, flags) as file:
                file.write(f"{','.join(format_row(row))}\n".encode())
        except OSError as error:
            raise RunError(f"{self._path}: cannot be written: {error.strerror}") from error

    def _continued(self, path: Path, after: float) -> History:
        history = read_history(path)
        if history.labels != self.history.labels:
            raise InputError(str(path), "", "has other columns than this case records; start a new run")
        kept = history.until(after)
        # the power may have failed before the last rows were on the disk
        if not math.isclose(kept.last_time, after, rel_tol=1e-9, abs_tol=1e-300):
            raise InputError(str(path), "", f"lacks the row at {after:.6g} s to continue from; start a new run")
        return kept
