"""Remarks on what the inventory of a case shows: bodies that do not float as drawn, and rows that shorten the steps."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from warp_mps.particles.particles import Particles
from warp_mps.particles.selection import free_bodies
from warp_mps.run.cost.time_step import ROWS, time_step
from warp_mps.run.inventory.flotation import Flotation
from warp_mps.run.inventory.surfaces import nearest_offsets
from warp_mps.scene import Body, Scene
from warp_mps.scene.validation.rules import kind_of, place

# in spacings: a draught that is drawn further from that in equilibrium is remarked
DRAUGHT = 0.5
# in spacings: a fluid as near as this is in touch
BESIDE = 1.5
# how many times as long the steps could be that rows shorten
SHORTENED = 1.5


def remarks_on_flotation(scene: Scene, particles: Particles, floating: Mapping[str, Flotation]) -> list[str]:
    """A line for each free body that capsizes, or that is drawn higher or lower than it floats.

    Args:
        scene: The scene.
        particles: Its particles.
        floating: How its free bodies float, by name.
    """
    lines = []
    for body in scene.bodies:
        found = floating.get(body.name)
        if found is None or found.draught is None or found.metacentric_height is None or not is_wet(body, particles):
            continue
        where, off = place(body, kind_of(body)), found.draught - found.drawn
        if abs(off) > DRAUGHT * body.spacing:
            moves = f"{'sinks' if off > 0.0 else 'rises'} by {abs(off):.4g} m ({abs(off) / body.spacing:.1f} spacings)"
            draughts = f"floats at a draught of {found.draught:.4g} m, {found.drawn:.4g} m are drawn"
            lines.append(f"{where}: {draughts}: it {moves}")
        if found.metacentric_height < 0.0:
            reason = f"capsizes: its metacentric height is {found.metacentric_height:.4g} m"
            lines.append(f"{where}: {reason}; a lower centre of gravity or a greater breadth rights it")
    return lines


def remarks_on_missing_contact(scene: Scene, particles: Particles, floating: Mapping[str, Flotation]) -> list[str]:
    """A line for each free body that falls or sinks onto walls or bodies, which do not stop it, for contact is off.

    Args:
        scene: The scene.
        particles: Its particles.
        floating: How its free bodies float, by name.
    """
    alone = not scene.walls and len(scene.bodies) == 1
    if scene.contact.between != "none" or alone or not scene.gravity_vector.any():
        return []
    lines = []
    for body in scene.bodies:
        found = floating.get(body.name)
        if body.name in free_bodies(scene, particles) and (found is None or found.draught is None):
            word = "falls" if found is None else "sinks"
            reason = f"{word}, and contact is 'none' (mps:contact): it goes through walls and other bodies"
            lines.append(f"{place(body, kind_of(body))}: {reason}; use contact 'bodies'")
    return lines


def is_wet(body: Body, particles: Particles) -> bool:
    """Whether a body is in touch with a fluid."""
    own = slice(*particles.ranges[particles.names.index(body.name)])
    water = particles.positions[particles.count - particles.liquid :]
    near = BESIDE * max(body.spacing, float(particles.spacings[-1]))
    return bool(np.isfinite(nearest_offsets(particles.positions[own], water, near)).any())


def remarks_on_rows(scene: Scene, particles: Particles) -> list[str]:
    """A line where steps are as short as they are only since they end at the rows of probes.csv."""
    if scene.analysis == "static" or scene.time_step is not None:
        return []
    step = time_step(scene, particles)
    longest = min(limit for cause, limit in step.limits.items() if cause != ROWS)
    if step.limited_by != ROWS or longest < SHORTENED * step.length:
        return []
    effect = f"the rows of probes.csv make steps of {step.length:.4g} s, without them {longest:.4g} s"
    remedy = f"time_step (mps:timeStep) {step.length:.4g} keeps the result where the rate of the rows changes"
    return [f"{effect}: {remedy}"]
