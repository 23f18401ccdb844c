"""The stable time step of explicit integration of elastic bodies."""

from __future__ import annotations

import math
from dataclasses import replace

from warp_mps.elastic.materials.constants import lame_constants
from warp_mps.scene import Body, Material, Scene
from warp_mps.scene.bonds import bonded_bodies

# largest density with which a material counts in the time step, over the smallest density of bonded materials
DENSITY_RATIO = 2.5
# largest time step over the stable one
SAFETY = 0.9


def stable_time_step(body: Body, scene: Scene) -> float:
    """Largest time step that is stable for small deformations of a body, among the bodies that it is bonded to [s].

    A material that is bonded to a lighter one moves the particles of the lighter one: it counts with at most
    `DENSITY_RATIO` times the smallest density among all bonded materials. This bound held for every pattern of two
    materials that was tried; a checkerboard of a stiff and a light material nearly reaches it.
    """
    lightest = min(material.density for other in bonded_bodies(body, scene.bodies) for material in other.materials)
    return min(
        _stable_time_step(
            replace(material, density=min(material.density, DENSITY_RATIO * lightest)), body.spacing, scene
        )
        for material in body.materials
    )


def stable_limit(scene: Scene) -> float:
    """Largest time step that is stable for small deformations of all bodies [s].

    A contact as stiff as the material adds to the stiffness of the particles that touch.
    """
    return min(stable_time_step(body, scene) for body in scene.bodies) / contact_slowing(scene)


def contact_slowing(scene: Scene) -> float:
    """Factor by which a stiff contact shortens the time step [-]."""
    return math.sqrt(max(1.0, scene.contact.stiffness))


def _stable_time_step(material: Material, spacing: float, scene: Scene) -> float:
    """Largest stable step of particles of one material [s].

    2 / omega_max without viscosity; with the damping ratio s = tau omega_max / 2 of the fastest mode sqrt(1 + s^2) - s
    of it, since a viscous stress that lags by half a step can feed what it should damp (Belytschko, Liu and Moran,
    Nonlinear Finite Elements, chapter 6).

    omega_max^2 = (a mu + b lambda)/(rho l0^2) bounds every lattice, Poisson's ratio and effective radius that was
    tried.

    - ``springs`` with n0: a = 24 is the rotation of single particles against their neighbours, with an inertia of
      m l0^2/6, and the bound is within 1 % where nu = 0. With n_i, particles at a surface are held more stiffly.
    - ``hamiltonian``: b = 4 d is the breathing of a block of two particles a side; a bounds what shears and controls.
      Below r_e = 1.5 a particle hangs on ever fewer of its diagonal neighbours, of which there are none below 1.41.
    """
    lame, mu = lame_constants(material, scene.dimension, scene.plane)
    d, elasticity = scene.dimension, scene.elasticity
    if elasticity.model == "hamiltonian":
        a, b = _shear_bound(d, elasticity.control), 4.0 * d
        a *= 1.26 if elasticity.effective_radius < 1.5 else 1.0
    elif elasticity.normalization == "lattice":
        a, b = 24.0, 1.0 * d
    else:
        a, b = 20.0 * d, 4.0 * d**2
    elastic = 2.0 * spacing * math.sqrt(material.density / (a * mu + b * max(lame, 0.0)))
    ratio = material.retardation_time / elastic
    return elastic / (math.sqrt(1.0 + ratio * ratio) + ratio)


def _shear_bound(dimension: int, control: float) -> float:
    """Factor a of the hamiltonian model: of few particles where the control is weak, of the control where strong."""
    if dimension == 2:
        return max(10.0, 8.0 + 9.0 * control, 15.5 * control)
    return max(14.0 + 8.0 * control, 21.5 * control)
