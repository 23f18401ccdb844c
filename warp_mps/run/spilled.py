"""Water that is no longer in its tank at the end of a run: where it went, and over or through which wall.

A particle that has left the domain, or has no wall and no body below it any more, is outside. One that still falls is
traced back to where its fall began, v^2/2g higher: above the top of the nearest wall it went over that wall, else
through or under it.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from warp_mps.fluid.domain import domain
from warp_mps.particles.particles import Particles
from warp_mps.particles.unheld_fluid import distance_to_solid, gravity_axis
from warp_mps.scene import Scene


def remarks_on_spilled_fluid(
    scene: Scene, particles: Particles, positions: np.ndarray, velocities: np.ndarray
) -> list[str]:
    """A line for each wall that water fell over or went through, and for each face of the domain that it left by.

    Args:
        scene: The case.
        particles: Its particles.
        positions: Their positions [m], shape [n, d].
        velocities: Their velocities [m/s], shape [n, d].
    """
    if not particles.liquid or not (np.isfinite(positions).all() and np.isfinite(velocities).all()):
        return []
    falling = particles.count - particles.liquid + np.flatnonzero(_falling(scene, particles, positions))
    return [
        *_crossed_walls(scene, particles, positions, velocities, falling),
        *_left_faces(scene, particles, positions),
    ]


def count_spilled(scene: Scene, particles: Particles, positions: np.ndarray) -> int:
    """Number of fluid particles in the domain that have no wall and no body below them.

    Args:
        scene: The case.
        particles: Its particles.
        positions: Their positions [m], shape [n, d].
    """
    if not np.isfinite(positions).all():
        return 0
    return int(_falling(scene, particles, positions).sum())


def _falling(scene: Scene, particles: Particles, positions: np.ndarray) -> np.ndarray:
    """Which fluid particles in the domain have nothing below them, shape [m]."""
    first = particles.count - particles.liquid
    direction, x = gravity_axis(scene), positions[first:]
    if direction is None or not scene.walls or not particles.liquid or direction[0] in scene.flow.periodic:
        return np.zeros(particles.liquid, bool)
    low, high = domain(scene, particles)
    inside, solids = np.all((x >= low) & (x <= high), axis=1), positions[:first]
    # what an unstable body has thrown out of the domain holds nothing
    solids, falling = solids[np.all((solids >= low) & (solids <= high), axis=1)], np.zeros(len(x), bool)
    distances = distance_to_solid(solids, x[inside], *direction, float(scene.fluids[0].spacing))
    falling[inside] = np.isinf(distances)
    return falling


def _crossed_walls(
    scene: Scene, particles: Particles, positions: np.ndarray, velocities: np.ndarray, falling: np.ndarray
) -> Iterator[str]:
    direction = gravity_axis(scene)
    if direction is None or not len(falling):
        return
    vertical, downwards = direction
    speed = np.maximum(downwards * velocities[falling, vertical], 0.0)
    duration = speed / float(np.linalg.norm(scene.gravity_vector))
    begin = positions[falling] - duration[:, None] * velocities[falling]
    begin[:, vertical] = positions[falling, vertical] - 0.5 * downwards * speed * duration
    solids = positions[: particles.count - particles.liquid]
    nearest = np.array([int(np.argmin(np.sum((solids - point) ** 2, axis=1))) for point in begin])
    owners, heights = particles.bodies[nearest], -downwards * begin[:, vertical]
    for body in np.unique(owners):
        of_body = particles.ranges[body]
        edge = 0.5 * particles.spacings[of_body[0]]
        top = float((-downwards * positions[of_body[0] : of_body[1], vertical]).max()) + edge
        over = heights[owners == body] > top - edge
        for went, word in ((over, "over the top of"), (~over, "through or under")):
            if went.any():
                count, at = int(went.sum()), _point(begin[owners == body][went][0])
                name = particles.names[int(body)]
                where = f"{word} '{name}', as at {at} m{_remedy(word)}"
                yield f"{_fluid(count, 'is', 'are')} outside the tank at the end: {where}"


def _left_faces(scene: Scene, particles: Particles, positions: np.ndarray) -> Iterator[str]:
    x = positions[particles.count - particles.liquid :]
    low, high = domain(scene, particles)
    for axis in (axis for axis in range(scene.dimension) if axis not in scene.flow.periodic):
        for name, beyond in (("low", x[:, axis] < low[axis]), ("high", x[:, axis] > high[axis])):
            if beyond.any():
                where = f"the domain at its {name} {scene.frame.axes[axis]} end, as at {_point(x[beyond][0])} m"
                yield f"{_fluid(int(beyond.sum()), 'has', 'have')} left {where}"


def _fluid(count: int, one: str, many: str) -> str:
    return f"{count} fluid particles {many}" if count > 1 else f"1 fluid particle {one}"


def _remedy(word: str) -> str:
    if word.startswith("over"):
        return ""
    return "; if no opening is drawn there, make the wall at least two spacings thick, or the CFL number smaller"


def _point(position: np.ndarray) -> str:
    return "(" + ", ".join(f"{c:.4g}" for c in position) + ")"
