"""Remarks on bodies that float freely: water about them that has once moved may never come to rest, and moves them.

Water whose particles lie on a lattice that fits between walls and bodies stays at rest
(`warp_mps.fluid.still_water`). In all other water particles go round for ever, at about 0.03 sqrt(g l0), for the
lattice of the pair weight that suits moving water is unstable. That was measured for plates and blocks of 4 and 5
particles at l0 of 5 and 10 mm. Three spacings from a wall they drifted by up to 1.4 spacings in the first second, until
they were 4 to 6 spacings away from it, in the middle of a tank by a tenth of that.
"""

from __future__ import annotations

import math

import numpy as np

from warp_mps.particles.particles import Particles
from warp_mps.particles.selection import free_bodies
from warp_mps.run.inventory.doubts import is_wet
from warp_mps.scene import Scene
from warp_mps.scene.validation.rules import kind_of, place

# speed of water at rest beside a body, in units of sqrt(g l0)
UNREST = 0.03


def remarks_on_drift(scene: Scene, particles: Particles) -> list[str]:
    """A line for each body that floats, and that nothing holds along the level of the water."""
    gravity = float(np.linalg.norm(scene.gravity_vector))
    if not (scene.fluids and scene.bodies and gravity) or scene.analysis == "static":
        return []
    free = free_bodies(scene, particles)
    spacing, density = scene.fluids[0].spacing, scene.fluids[0].liquid.density
    speed = UNREST * math.sqrt(gravity * spacing)
    effect = f"water that has moved may move it by {speed:.2g} m ({speed / spacing:.1f} spacings) in a second"
    remedy = "a support that holds these axes (mps:axes) at its middle prevents it, smaller spacings lessen it"
    return [
        f"{place(body, kind_of(body))}: floats and is free along the level: {effect}; {remedy}"
        for body in scene.bodies
        if body.name in free and body.material.density < density and is_wet(body, particles)
    ]
