"""Stresses and strains of the particles, evaluated when they are read and not within a step.

Both come from the deformation gradient F of each particle: the Green-Lagrange strain E = (F^T F - I)/2 and the Cauchy
stress sigma = P F^T / J of the material's law. All are 3 x 3; in 2-D the third axis is the normal of the plane:

- plane strain: E_zz = 0, and sigma_zz is the stress that keeps the thickness;
- plane stress: sigma_zz = 0, and E_zz is the thinning. Stresses are then per metre of the reference depth, as all
  forces are in 2-D; over the present thickness they are larger by 1/sqrt(1 + 2 E_zz).

The `hamiltonian` model has F. For `springs`, F is fitted to the neighbours by least squares, and the law is linear
between E and the second Piola-Kirchhoff stress: sums of its pair forces would be wrong at a surface, where neighbours
are missing and stresses matter most. Stresses are elastic: they do not contain damping.
"""

import functools
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
import warp as wp

from warp_mps.core.rotation import rotation_funcs
from warp_mps.core.types import NumericTypes
from warp_mps.elastic import METHOD
from warp_mps.elastic.materials.laws import law_funcs
from warp_mps.elastic.materials.volume import volume_funcs


class StressFields(NamedTuple):
    """Stress and strain of the particles along the scene's axes.

    Attributes:
        stresses: Cauchy stresses [Pa], shape [n, 3, 3].
        strains: Green-Lagrange strains [-], shape [n, 3, 3].
    """

    stresses: np.ndarray
    strains: np.ndarray


@functools.cache
def stress_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `fields`, `density` and `fit`."""
    real, vec, mat, rotor = types.real, types.vec, types.mat, types.rotor
    tensor = wp.types.matrix(shape=(3, 3), dtype=real)
    vec64 = wp.types.vector(length=types.dimension, dtype=wp.float64)
    mat64 = wp.types.matrix(shape=(types.dimension, types.dimension), dtype=wp.float64)
    laws = law_funcs(types)
    law_stress, energy_density = laws.stress, laws.energy_density
    stress_across, strain_across = laws.stress_across, laws.strain_across
    dilatation_slope = volume_funcs(types).dilatation_slope
    turns = rotation_funcs(types, METHOD)
    mean_rotor, turn = turns.mean_rotor, turns.turn

    @types.func(METHOD)
    def widen(a: mat, across: real) -> tensor:
        """The 3 x 3 tensor of `a`; in 2-D with the component across the plane."""
        wide = tensor()
        for row in range(wp.static(types.dimension)):
            for column in range(wp.static(types.dimension)):
                wide[row, column] = real(0.5) * (a[row, column] + a[column, row])
        if wp.static(types.dimension == 2):
            wide[2, 2] = across
        return wide

    @types.kernel(METHOD)
    def fields(
        # Model:
        law: wp.array(dtype=wp.int32),  # 0 for St. Venant-Kirchhoff, 1 for neo-Hookean, [n]
        lame: wp.array(dtype=real),  # Lame's constant lambda [Pa], [n]
        mu: wp.array(dtype=real),  # Lame's constant mu [Pa], [n]
        plane_stress: wp.int32,  # 1 for plane stress, else 0
        # State in:
        gradient: wp.array(dtype=mat),  # displacement gradients H_i [-], [n]
        mean_stress: wp.array(dtype=real),  # Kirchhoff stress of the mean dilatations [Pa], [n]
        # State out:
        stress_out: wp.array(dtype=tensor),  # Cauchy stresses [Pa], [n]
        strain_out: wp.array(dtype=tensor),  # Green-Lagrange strains [-], [n]
    ):
        """Cauchy stress sigma = P F^T / J and Green-Lagrange strain E = (F^T F - I)/2."""
        i = wp.tid()
        h = gradient[i]
        f = h + wp.identity(n=wp.static(types.dimension), dtype=real)
        inverse_j = real(1.0) / wp.determinant(f)
        p = law_stress(law[i], h, lame[i], mu[i], plane_stress)
        p += mean_stress[i] * dilatation_slope(law[i], h)
        across = stress_across(law[i], h, lame[i], mu[i], plane_stress) + mean_stress[i]
        stress_out[i] = widen(inverse_j * (p * wp.transpose(f)), inverse_j * across)
        e = real(0.5) * (h + wp.transpose(h) + wp.transpose(h) * h)
        strain_out[i] = widen(e, strain_across(law[i], h, lame[i], mu[i], plane_stress))

    @types.kernel(METHOD)
    def density(
        # Model:
        law: wp.array(dtype=wp.int32),  # 0 for St. Venant-Kirchhoff, 1 for neo-Hookean, [n]
        lame: wp.array(dtype=real),  # Lame's constant lambda [Pa], [n]
        mu: wp.array(dtype=real),  # Lame's constant mu [Pa], [n]
        plane_stress: wp.int32,  # 1 for plane stress, else 0
        mean_lame: wp.array(dtype=real),  # part of lambda on the mean dilatation [Pa], [n]
        # State in:
        gradient: wp.array(dtype=mat),  # displacement gradients H_i [-], [n]
        mean: wp.array(dtype=real),  # mean dilatations [-], [n]
        # State out:
        density_out: wp.array(dtype=real),  # energy densities [J/m^3], [n]
    ):
        """Strain energy psi(F), with that of the mean dilatation, per reference volume [J/m^3]."""
        i = wp.tid()
        density = energy_density(law[i], gradient[i], lame[i], mu[i], plane_stress)
        density_out[i] = density + real(0.5) * mean_lame[i] * mean[i] * mean[i]

    @types.kernel(METHOD)
    def fit(
        # Model:
        start: wp.array(dtype=wp.int32),  # first pair of each particle, [n + 1]
        index: wp.array(dtype=wp.int32),  # neighbour j of each pair, [pairs]
        bond: wp.array(dtype=vec),  # reference vectors X_ij [m], [pairs]
        area: wp.array(dtype=real),  # d w_ij/|X_ij| [1/m], [pairs]
        # State in:
        u: wp.array(dtype=vec),  # displacements u [m], [n]
        q: wp.array(dtype=rotor),  # rotors of the particles' own rotation [-], [n]
        # State out:
        gradient_out: wp.array(dtype=mat),  # displacement gradients H_i [-], [n]
    ):
        """H = F - I by least squares, with the weights w/|X|^2; directions without neighbours rotate with the particle.

        The fit is to the displacements relative to the particle's own rotation. A row or a layer of particles, which
        `springs` allows, therefore has no strain across itself.
        """
        i = wp.tid()
        m = mean_rotor(q[i], q[i])
        d = wp.float64(wp.static(float(types.dimension)))
        n = wp.float64(0.0)
        shape = mat64()
        moved = mat64()
        for k in range(start[i], start[i + 1]):
            x = vec64(bond[k])
            r = wp.length(x)
            n += wp.float64(area[k]) * r / d
            omega = wp.float64(area[k]) / (d * r)
            shape += omega * wp.outer(x, x)
            e = vec64(u[index[k]] - u[i] - turn(m, bond[k]))
            moved += omega * wp.outer(e, x)
        one = wp.identity(n=wp.static(types.dimension), dtype=wp.float64)
        if wp.determinant(shape) <= wp.float64(1.0e-6) * wp.pow(n / d, d):
            shape += (wp.float64(1.0e-9) * wp.trace(shape)) * one
        h = mat(moved * wp.inverse(shape))
        for axis in range(wp.static(types.dimension)):
            along = vec()
            along[axis] = real(1.0)
            h += wp.outer(turn(m, along), along)
        gradient_out[i] = h

    return SimpleNamespace(fields=fields, density=density, fit=fit)


def stress_fields(
    gradients: wp.array, constants: list[Any], mean_stresses: wp.array, *, types: NumericTypes, device: Any
) -> StressFields:
    """Stress and strain of displacement gradients.

    Args:
        gradients: H = F - I [-], shape [n, d, d].
        constants: Laws and Lame's constants of the particles, and whether it is plane stress.
        mean_stresses: Kirchhoff stresses of the mean dilatations [Pa], shape [n].
        types: Number types.
        device: Warp device.
    """
    tensor = wp.types.matrix(shape=(3, 3), dtype=types.real)
    outputs = [wp.empty(len(gradients), dtype=tensor, device=device) for _ in range(2)]
    wp.launch(
        stress_kernels(types).fields, len(gradients), [*constants, gradients, mean_stresses], outputs, device=device
    )
    return StressFields(*(values.numpy().astype(float) for values in outputs))


def von_mises(stresses: np.ndarray) -> np.ndarray:
    """Von Mises stresses sqrt(3/2 s:s), s the deviator [Pa], shape [n], of stresses [n, 3, 3]."""
    deviators = stresses - np.trace(stresses, axis1=1, axis2=2)[:, None, None] / 3.0 * np.eye(3)
    return np.sqrt(1.5 * np.einsum("nij,nij->n", deviators, deviators))
