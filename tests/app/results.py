"""A small result without a run: a block on a wall, all of whose values are known."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.scenes import RUBBER
from warp_mps.particles.filling import fill_scene
from warp_mps.particles.particles import Particles
from warp_mps.scene import Body, Scene, StageFrame, Wall
from warp_mps.shapes import Box
from warp_mps.usd.animation.writer import AnimationWriter

RATE = 100.0
# a plane that is upright in a stage whose unit is the centimetre
UPRIGHT = StageFrame(axes="xz", up_axis="Z", meters_per_unit=0.01, kilograms_per_unit=0.001)
SPACE = StageFrame(axes="xyz", up_axis="Z")
STRESS = np.array([[1.0, 4.0, 0.0], [4.0, 2.0, 0.0], [0.0, 0.0, 3.0]])


def write_result(folder: Path, *, frame: StageFrame = UPRIGHT, frames: int = 3) -> Particles:
    """Write run.usdc of a block of 4 by 2 (by 2) particles, 0.1 m wide, that moves up by 0.02 m a frame at 2 m/s.

    In frame k the pressure of particle i of the block is 100 i + k, that of the wall 0, and the von Mises stress 50 i;
    the stress is `STRESS`.
    """
    more = len(frame.axes) - 2
    body = Body(name="block", shape=Box((0.4, 0.2) + (0.2,) * more), material=RUBBER, spacing=0.1)
    floor = Wall(name="floor", shape=Box((0.6, 0.2) + (0.2,) * more, center=(0.0, -0.4) + (0.0,) * more), spacing=0.1)
    scene = Scene(bodies=(body,), walls=(floor,), dimension=2 + more, duration=1.0, name="resting")
    particles = fill_scene(scene)
    count, moving = particles.count, particles.elastic
    writer = AnimationWriter(
        folder / "run.usdc",
        particles,
        frame,
        frame_rate=RATE,
        provenance={"case": "resting", "time step [s]": 1e-4},
        primvars=("pressure", "von_mises", "stress"),
    )
    for k in range(frames):
        positions, velocities = particles.positions.copy(), np.zeros_like(particles.positions)
        positions[:moving, 1] += 0.02 * k
        velocities[:moving, 1] = 2.0
        writer.write(
            k / RATE,
            positions,
            velocities,
            pressure=np.where(np.arange(count) < moving, 100.0 * np.arange(count) + k, 0.0),
            von_mises=50.0 * np.arange(count),
            stress=np.tile(STRESS, (count, 1, 1)),
        )
    writer.close()
    return particles
