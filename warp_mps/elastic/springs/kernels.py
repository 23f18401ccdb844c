"""The paper's elastic model: springs along and across every pair of particles, and a pressure for the volume change.

The forces are the exact gradient of one energy,

    V = sum_pairs 1/2 k_ij |u_ij|^2 + sum_i 1/2 V0 lambda (div u)_i^2,   u_ij = x_ij - R(theta_ij) X_ij   (eq. 9)

with k_ij = V0 (2 d / n) 2 mu w_ij / |X_ij|^2 (eqs. 10-13: the normal and the tangential spring are equally stiff, so
their sum acts along u_ij) and (div u)_i = (d / n) sum_j w_ij (u_ij . x_ij/|x_ij|) / |X_ij| (eq. 14). Momentum, angular
momentum (eq. 4) and energy are therefore kept. n is the lattice's n0 or the particle's own n_i; with n_i a pair takes
the mean of 1/n_i and 1/n_j.

References:
    Robortella, M. S., Nishimoto, K. and Cheng, L.-Y., Dynamic analyses of elastic structures by using the moving
    particle semi-implicit method (MPS), equations 2 to 14.
    Song, M., Koshizuka, S. and Oka, Y., Dynamic analysis of elastic solids by MPS method, GENES4/ANP2003, 2003.
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.rotation import rotation_funcs
from warp_mps.core.types import NumericTypes, numeric_types
from warp_mps.core.weights import weight_function
from warp_mps.elastic import METHOD


@functools.cache
def spring_funcs(types: NumericTypes) -> SimpleNamespace:
    """Device functions of one pair: each a formula, without indices."""
    real, vec, axial, rotor = types.real, types.vec, types.axial, types.rotor
    turns = rotation_funcs(types, METHOD)
    turn, cross = turns.turn, turns.cross

    @types.func(METHOD)
    def stretch(m: rotor, bond: vec, du: vec) -> real:
        """u_ij . x_ij/|x_ij|, the part of the relative displacement along the pair (eq. 10 without 1/|X_ij|)."""
        x = bond + du
        return wp.dot(du - turn(m, bond), x) / wp.length(x)

    @types.func(METHOD)
    def pair_force(m: rotor, bond: vec, du: vec, k: real, pressure: real) -> vec:
        """Force on i: the springs, and the gradient of the stretch times the pressure sum of the pair."""
        x = bond + du
        turned = turn(m, bond)
        b = bond + turned
        inverse = real(1.0) / wp.length(x)
        direction = inverse * x
        across = inverse * (b - wp.dot(b, direction) * direction)
        return k * (du - turned) + pressure * (direction - across)

    @types.func(METHOD)
    def pair_torque(m: rotor, bond: vec, du: vec, k: real, pressure: real) -> axial:
        """Torque on the mean rotation of the pair (eq. 4): minus the energy's change as R(theta_ij) X_ij turns."""
        x = bond + du
        turned = turn(m, bond)
        return cross(bond + turned, k * (du - turned) + (pressure / wp.length(x)) * x)

    return SimpleNamespace(stretch=stretch, pair_force=pair_force, pair_torque=pair_torque)


@functools.cache
def spring_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `number_density`, `bonds`, `pressure`, `force` and `energy` of the model.

    `first` shifts the particle index, so that several threads can share the particles.
    """
    real, vec, axial, rotor = types.real, types.vec, types.axial, types.rotor
    turns, pair = rotation_funcs(types, METHOD), spring_funcs(types)
    mean_rotor, torque_share, turn = turns.mean_rotor, turns.torque_share, turns.turn
    stretch, pair_force, pair_torque = pair.stretch, pair.pair_force, pair.pair_torque

    # the constants of a pair are formed in double precision whatever the run's: X_ij is a small difference
    vec64 = wp.types.vector(length=types.dimension, dtype=wp.float64)
    weight = weight_function(numeric_types(types.dimension, "float64"))

    @types.kernel(METHOD)
    def number_density(
        # Model:
        start: wp.array(dtype=wp.int32),  # first pair of each particle, [n + 1]
        index: wp.array(dtype=wp.int32),  # neighbour j of each pair, [pairs]
        reference: wp.array(dtype=vec64),  # reference positions X_i [m], [n]
        radius: wp.array(dtype=wp.float64),  # effective radii r_e [m], [n]
        # Model out:
        density_out: wp.array(dtype=wp.float64),  # number densities n_i [-], [n]
    ):
        """n_i = sum_j w_ij (eq. 8)."""
        i = wp.tid()
        n = wp.float64(0.0)
        for k in range(start[i], start[i + 1]):
            n += weight(wp.length(reference[index[k]] - reference[i]), radius[i])
        density_out[i] = n

    @types.kernel(METHOD)
    def bonds(
        # Model:
        start: wp.array(dtype=wp.int32),  # first pair of each particle, [n + 1]
        index: wp.array(dtype=wp.int32),  # neighbour j of each pair, [pairs]
        reference: wp.array(dtype=vec64),  # reference positions X_i [m], [n]
        radius: wp.array(dtype=wp.float64),  # effective radii r_e [m], [n]
        volume: wp.array(dtype=wp.float64),  # reference volumes V_i [m^d], [n]
        mu: wp.array(dtype=wp.float64),  # Lame's constant mu [Pa], [n]
        inverse_density: wp.array(dtype=wp.float64),  # 1/n0 or 1/n_i [-], [n]
        # Model out:
        bond_out: wp.array(dtype=vec),  # reference vectors X_ij [m], [pairs]
        area_out: wp.array(dtype=real),  # d w_ij/|X_ij| [1/m], [pairs]
        stiffness_out: wp.array(dtype=real),  # k_ij [N/m], [pairs]
    ):
        """X_ij, d w_ij/|X_ij| and k_ij of every pair; springs of two materials in series have their harmonic mean."""
        i = wp.tid()
        d = wp.float64(wp.static(float(types.dimension)))
        for k in range(start[i], start[i + 1]):
            j = index[k]
            x = reference[j] - reference[i]
            r = wp.length(x)
            w = weight(r, radius[i])
            mean_mu = wp.float64(2.0) / (wp.float64(1.0) / mu[i] + wp.float64(1.0) / mu[j])
            mean_inverse = wp.float64(0.5) * (inverse_density[i] + inverse_density[j])
            bond_out[k] = vec(x)
            area_out[k] = real(d * w / r)
            stiffness_out[k] = real(volume[i] * wp.float64(4.0) * d * mean_mu * w / (r * r) * mean_inverse)

    @types.kernel(METHOD)
    def pressure(
        # Model:
        first: wp.int32,  # first particle of this launch
        start: wp.array(dtype=wp.int32),  # first pair of each particle, [n + 1]
        index: wp.array(dtype=wp.int32),  # neighbour j of each pair, [pairs]
        bond: wp.array(dtype=vec),  # reference vectors X_ij [m], [pairs]
        area: wp.array(dtype=real),  # d w_ij/|X_ij| [1/m], [pairs]
        bulk: wp.array(dtype=real),  # V0 lambda / n_i^2 [J], [n]
        # State in:
        u: wp.array(dtype=vec),  # displacements u [m], [n]
        q: wp.array(dtype=rotor),  # rotors of the particles' own rotation [-], [n]
        # State out:
        pressures_out: wp.array(dtype=real),  # V0 lambda (div u)_i / n_i [J], [n]
    ):
        """V0 lambda (div u)_i / n_i, minus the pressure of eq. 14 in the units that the pair sum needs."""
        i = first + wp.tid()
        u_i = u[i]
        q_i = q[i]
        div = real(0.0)
        for k in range(start[i], start[i + 1]):
            j = index[k]
            div += area[k] * stretch(mean_rotor(q_i, q[j]), bond[k], u[j] - u_i)
        pressures_out[i] = bulk[i] * div

    @types.kernel(METHOD)
    def force(
        # Model:
        first: wp.int32,  # first particle of this launch
        start: wp.array(dtype=wp.int32),  # first pair of each particle, [n + 1]
        index: wp.array(dtype=wp.int32),  # neighbour j of each pair, [pairs]
        bond: wp.array(dtype=vec),  # reference vectors X_ij [m], [pairs]
        area: wp.array(dtype=real),  # d w_ij/|X_ij| [1/m], [pairs]
        stiffness: wp.array(dtype=real),  # k_ij [N/m], [pairs]
        # State in:
        u: wp.array(dtype=vec),  # displacements u [m], [n]
        q: wp.array(dtype=rotor),  # rotors of the particles' own rotation [-], [n]
        pressures: wp.array(dtype=real),  # V0 lambda (div u)_i / n_i [J], [n]
        # State out:
        force_out: wp.array(dtype=vec),  # forces [N], [n]
        torque_out: wp.array(dtype=axial),  # torques [N m], [n]
    ):
        """Force -dV/du_i and torque of a particle: sums over its pairs of eqs. 4 and 9 to 14."""
        i = first + wp.tid()
        u_i = u[i]
        q_i = q[i]
        p_i = pressures[i]
        total = vec()
        torque = axial()
        for k in range(start[i], start[i + 1]):
            j = index[k]
            m = mean_rotor(q_i, q[j])
            du = u[j] - u_i
            p = (p_i + pressures[j]) * area[k]
            total += pair_force(m, bond[k], du, stiffness[k], p)
            torque += torque_share(q_i, m, pair_torque(m, bond[k], du, stiffness[k], p))
        force_out[i] = total
        torque_out[i] = torque

    @types.kernel(METHOD)
    def energy(
        # Model:
        start: wp.array(dtype=wp.int32),  # first pair of each particle, [n + 1]
        index: wp.array(dtype=wp.int32),  # neighbour j of each pair, [pairs]
        bond: wp.array(dtype=vec),  # reference vectors X_ij [m], [pairs]
        area: wp.array(dtype=real),  # d w_ij/|X_ij| [1/m], [pairs]
        stiffness: wp.array(dtype=real),  # k_ij [N/m], [pairs]
        bulk: wp.array(dtype=real),  # V0 lambda / n_i^2 [J], [n]
        # State in:
        u: wp.array(dtype=vec),  # displacements u [m], [n]
        q: wp.array(dtype=rotor),  # rotors of the particles' own rotation [-], [n]
        # State out:
        energy_out: wp.array(dtype=real),  # energies [J], [n]
    ):
        """Elastic energy of each particle: half of that of its springs, and 1/2 V0 lambda (div u)_i^2."""
        i = wp.tid()
        springs = real(0.0)
        div = real(0.0)
        for k in range(start[i], start[i + 1]):
            j = index[k]
            m = mean_rotor(q[i], q[j])
            du = u[j] - u[i]
            e = du - turn(m, bond[k])
            springs += real(0.25) * stiffness[k] * wp.dot(e, e)
            div += area[k] * stretch(m, bond[k], du)
        energy_out[i] = springs + real(0.5) * bulk[i] * div * div

    return SimpleNamespace(number_density=number_density, bonds=bonds, pressure=pressure, force=force, energy=energy)
