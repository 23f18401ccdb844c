"""Recording of the animation."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from warp_mps.observers.base import Observer, View
from warp_mps.observers.sampling import FIELDS
from warp_mps.particles.particles import Particles
from warp_mps.scene import Scene


class FrameRecorder(Observer):
    """Writes positions, velocities, pressures and the outputs of the scene as a USD animation.

    Args:
        path: The file to write, ending in ``.usdc``.
        scene: The case; its `frame_rate` sets the time codes.
        particles: Its particles.
        every: Steps between two frames.
        provenance: Where the result comes from, e.g. the case, the versions and the time step.
        resume_after: Continues an existing file after this time [s]; later frames are dropped. None starts a new one.
        resume_mark: What `mark` gave then.

    Raises:
        InputError: The path does not end in ``.usdc``, or there is no file to continue, or it has other frames.
    """

    def __init__(
        self,
        path: str | Path,
        scene: Scene,
        particles: Particles,
        *,
        every: int,
        provenance: Mapping[str, str | float | int],
        resume_after: float | None = None,
        resume_mark: Mapping[str, Any] | None = None,
    ) -> None:
        from warp_mps.usd.animation.writer import AnimationWriter

        self.every = every
        self._outputs = scene.outputs
        rate, primvars = scene.frame_rate, ("pressure", *scene.outputs)
        if resume_after is None:
            self._writer = AnimationWriter(
                path, particles, scene.frame, frame_rate=rate, provenance=provenance, primvars=primvars
            )
        else:
            self._writer = AnimationWriter.resume(
                path,
                particles,
                scene.frame,
                frame_rate=rate,
                provenance=provenance,
                primvars=primvars,
                after=resume_after,
                mark=resume_mark,
            )

    def observe(self, view: View) -> None:
        """Add a frame.

        Raises:
            RunError: The file cannot be written.
        """
        outputs = {name: getattr(view, FIELDS[name]) for name in self._outputs}
        # the last frame of a run may lie off the grid, and a run that goes on from there replaces it
        kept = view.step % self.every == 0
        self._writer.write(view.time, view.positions, view.velocities, kept=kept, pressure=view.pressures, **outputs)

    def mark(self) -> dict[str, Any]:
        """Number and digest of the frames that a continued run keeps."""
        return self._writer.mark()

    def close(self) -> None:
        """Finish the file."""
        self._writer.close()
