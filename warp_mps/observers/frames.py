"""Recording of the animation."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

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

    Raises:
        InputError: The path does not end in ``.usdc``, or there is no file to continue.
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
            )

    def observe(self, view: View) -> None:
        """Add a frame.

        Raises:
            RunError: The file cannot be written.
        """
        outputs = {name: getattr(view, FIELDS[name]) for name in self._outputs}
        self._writer.write(view.time, view.positions, view.velocities, pressure=view.pressures, **outputs)

    def close(self) -> None:
        """Finish the file."""
        self._writer.close()
