"""Size of the animation of a run."""

from __future__ import annotations

from collections.abc import Mapping

from warp_mps.scene import Scene

# size of a particle in a frame: position, velocity and pressure, and the outputs [bytes]
BYTES_OF_FRAME = 28
BYTES_OF_OUTPUT = {"stress": 72, "strain": 72, "von_mises": 4, "strain_energy": 4}
# every save leaves the tables of the previous one in the file: their size, that of a sample in them, and the most that
# is left beyond the content (`warp_mps.usd.animation.points_file`) [bytes]; time samples of each body, wall and fluid
BYTES_OF_SAVE, BYTES_OF_SAMPLE, MOST_LEFT, SERIES = 1200, 10, 2**20, 4


def disk_of(scene: Scene, particles: Mapping[str, int], frames: int) -> float:
    """Size of an animation of so many frames, at most, with so many particles of each body, wall and fluid [bytes]."""
    elastic, total = sum(particles[body.name] for body in scene.bodies), sum(particles.values())
    content = frames * (total * BYTES_OF_FRAME + elastic * sum(BYTES_OF_OUTPUT[name] for name in scene.outputs))
    series = SERIES * len(particles) + len(scene.outputs) * len(scene.bodies)
    left = 0.5 * frames * (BYTES_OF_SAVE + frames * series * BYTES_OF_SAMPLE)
    return float(content + min(left, content + MOST_LEFT))
