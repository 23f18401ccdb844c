"""Why a run has probably diverged, found by looking at the scene and at its particles, with the remedy."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from warp_mps.elastic.materials.constants import pressure_wave_speed
from warp_mps.observers.base import View
from warp_mps.scene import Flow, Scene

# an incompressible liquid is good up to a tenth of the speed of sound in water [m/s]
FASTEST_LIQUID = 150.0
# scheme and negative pressures with which a fluid that fills its walls rests
FOR_CLOSED = ("corrected", "allowed")


def probable_cause(view: View, *, time_step: float, limit: float, closed: bool = False) -> str:
    """The first cause that applies, and what to do about it.

    Args:
        view: The run when it diverged.
        time_step: Time step of the run, of fluids the longest [s].
        limit: Stability limit of explicit steps at the start [s].
        closed: Whether fluids started without a free surface.
    """
    scene = view.scene
    of_method = _of_fluids(scene, closed=closed) if scene.fluids else _of_bodies(scene, time_step, limit)
    return plain_cause(view, time_step=time_step, limit=limit) or of_method


def plain_cause(view: View, *, time_step: float, limit: float) -> str | None:
    """A cause that spoils any run: something far too fast, or a time step above its limit; None if there is none."""
    long = f"the time step of {time_step:.3g} s is above the stability limit of {limit:.3g} s: take less than that"
    return next(_too_fast(view), long if time_step > limit else None)


def _too_fast(view: View) -> Iterator[str]:
    """Bodies and fluids that start, and walls that move, faster than pressure waves in them."""
    scene, particles = view.scene, view.particles
    start, now = (np.linalg.norm(v, axis=1) for v in (particles.velocities, view.velocities))
    waves = {
        body.name: min(pressure_wave_speed(material, scene.dimension, scene.plane) for material in body.materials)
        for body in scene.bodies
    }
    slowest = min([*waves.values(), *([FASTEST_LIQUID] if scene.fluids else [])])
    for name, (first, end) in zip(particles.names, particles.ranges, strict=True):
        is_wall = name not in waves and first < particles.count - particles.liquid
        speeds, verb = (now, "moves") if is_wall else (start, "starts")
        bound = waves.get(name, slowest if is_wall else FASTEST_LIQUID)
        speed = float(speeds[first:end].max(initial=0.0))
        if speed > bound:
            medium = f"pressure waves of {bound:.4g} m/s" if waves else f"the {bound:.4g} m/s that a liquid is good for"
            yield f"'{name}' {verb} at {speed:.4g} m/s, faster than {medium}: check its velocity and the units"


def _of_bodies(scene: Scene, time_step: float, limit: float) -> str:
    if scene.implicit:
        return f"steps of {time_step:.3g} s are too long for what happens in them: shorten the time step"
    return (
        f"what acts on the bodies is too violent for the time step of {time_step:.3g} s, which is stable at rest "
        f"(limit {limit:.3g} s): check loads, contacts and prescribed motions, and halve it"
    )


def _of_fluids(scene: Scene, *, closed: bool) -> str:
    flow, usual = scene.flow, Flow()
    if closed and scene.walls and (flow.scheme, flow.negative_pressure) != FOR_CLOSED:
        scheme, pressures = FOR_CLOSED
        return (
            f"the scheme '{flow.scheme}' with negative pressures '{flow.negative_pressure}' stirs a fluid that fills "
            f"its walls: take '{scheme}' and '{pressures}'"
        )
    if flow.scheme != usual.scheme and not closed:
        return (
            f"the scheme '{flow.scheme}' does not conserve momentum, and stirs water beside walls and below a free "
            f"surface: take '{usual.scheme}'"
        )
    radius, least = flow.radius(scene.dimension), usual.radius(scene.dimension)
    if radius < least:
        return f"the effective radius of {radius:g} spacings is below the default of {least:g}: leave it out"
    if flow.courant > usual.courant:
        return f"the CFL number of {flow.courant:g} is above the default of {usual.courant:g}: take that or less"
    return "the flow has become unstable; more particles, or a smaller CFL number, may help"
