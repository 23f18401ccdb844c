"""Convergence of the spring model's eigenfrequencies to those of 2-D elasticity.

References are eigenfrequencies of quadratic finite elements, converged to the digits given, for the beam of the paper's
section 3.3 (0.16 x 0.02 m, E 10 MPa, nu 0.3, plane stress) with density 1000 kg/m^3. The linearised model is solved;
tests/elastic/test_linear.py holds runs against it.
"""

from __future__ import annotations

import numpy as np
import pytest

from tests.elastic.springs.linear import linear_system
from tests.scenes import LENGTH, beam
from warp_mps.particles.filling import fill_scene
from warp_mps.scene import Elasticity

LAYERS = (4, 8, 16)
FREE = (479.0, 1216.6, 1962.3)  # rad/s: two bending modes, and the first axial one
ROLLERS = (217.1, 813.2)  # rad/s: vertical rollers on the two whole end sections
# errors of the first bending mode at 4, 8 and 16 particles through the thickness, in percent
KNOWN = {
    (1.5, "lattice"): (-4.8, -1.7, -0.7),
    (2.1, "lattice"): (-11.9, -5.6, -2.7),
    (1.5, "particle"): (13.5, 10.7, 6.6),
    (2.1, "particle"): (8.1, 8.1, 5.4),
}


def free_errors(layers: int, elasticity: Elasticity) -> np.ndarray:
    """Relative errors of the free beam's first three modes."""
    scene = beam(layers, elasticity=elasticity)
    found, _ = linear_system(scene, fill_scene(scene)).modes(3, rigid=3)
    return found / FREE - 1.0


def roller_errors(layers: int, elasticity: Elasticity) -> np.ndarray:
    """Relative errors of the first two modes of the beam on rollers, a column of particles on each of them."""
    scene = beam(layers, nodes=True, elasticity=elasticity)
    particles = fill_scene(scene)
    held = np.zeros((particles.count, 3), bool)
    held[np.isin(particles.positions[:, 0].round(9), (0.0, LENGTH)), 1] = True
    found, _ = linear_system(scene, particles, held).modes(2, rigid=1)
    return found / ROLLERS - 1.0


@pytest.mark.parametrize("radius", [1.5, 2.1])
@pytest.mark.parametrize("errors_of", [free_errors, roller_errors])
def test_frequencies_converge_in_first_order(errors_of, radius: float) -> None:
    errors = np.array([errors_of(layers, Elasticity(model="springs", effective_radius=radius)) for layers in LAYERS])
    orders = np.log2(np.abs(errors[:-1] / errors[1:]))
    print(f"r_e = {radius} l0, errors in percent:\n{np.round(100 * errors, 2)}\norders:\n{np.round(orders, 2)}")
    assert (orders > 0.9).all()
    assert (np.abs(errors[-1]) < 0.03).all()


@pytest.mark.parametrize(("radius", "normalization"), KNOWN)
def test_errors_of_the_first_bending_mode(radius: float, normalization: str) -> None:
    """The paper's choice of n_i (eq. 6) is stiff at surfaces, and its error falls later than that of n0."""
    elasticity = Elasticity(model="springs", effective_radius=radius, normalization=normalization)
    errors = [100 * free_errors(layers, elasticity)[0] for layers in LAYERS]
    assert errors == pytest.approx(KNOWN[radius, normalization], abs=0.06)
