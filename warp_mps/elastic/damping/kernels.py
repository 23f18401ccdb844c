"""Kelvin-Voigt damping: forces of the rate of deformation beside those of the deformation, tau times as large.

They come from one dissipation function, which is to the rates what the energy of the model is to the strains
(`warp_mps.elastic.hamiltonian.kernels`, whose notation this is; a dash is a rate in time):

    D = sum_i V_i tau (mu E'_i : E'_i + lambda/2 tr(E'_i)^2) + sum_i sum_j 1/2 tau kappa_i omega_ij |c'_ij|^2

and V_i tau lambda'_i / 2 times the square of the mean of tr(E') where a part lambda' of lambda acts on means.
tau is the material's retardation time and E' the rate of the Green-Lagrange strain. c_ij = F_i^T e_ij is the deviation
that the hourglass control resists, in the frame of the body. F' is fitted to the neighbours' velocities as F is to
their displacements. Small motion about rest then has a damping matrix of tau times its stiffness matrix: a mode of
angular frequency omega has the damping ratio tau omega / 2. Rotations change neither E nor c: they are not damped, and
momentum and angular momentum are kept. The forces f = -dD/dv are

    f_i = sum_j omega_ij [(D_i + D_j) X_ij + tau kappa_i F_i c'_ij - tau kappa_j F_j c'_ji]
    D_i = [V_i F_i S_i + tau kappa_i sum_j omega_ij e_ij (x) c'_ij] A_i^-1,   S = tau (2 mu E' + lambda tr(E') I)

The velocities that a step has when it evaluates forces are those in the middle of its move, while F and e are those of
its end. E and c have grown by exactly dt E' and dt c' if the factors beside F' and e' are those of the middle of the
move, F - dt/2 F' and e - dt/2 e': so a step of a rigid rotation gives no force, however large. The rates lag by half a
step, which those of an explicit step have to; a mode's frequency is off by a part of the order of tau omega^2 dt.

The control's part is F c' = G e + N e' with G = F F'^T, N = F (F - dt/2 F')^T - dt/2 G, e = u_ij - H X_ij and
e' = v_ij - F' X_ij, so that it takes three matrices a particle: G and N, times tau kappa, and a part of D.

References:
    Christensen, R. M., Theory of Viscoelasticity, 2nd ed., section 1.6 (the Kelvin solid).
    Belytschko, T., Liu, W. K. and Moran, B., Nonlinear Finite Elements, chapter 6 (the stable explicit step).
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.elastic import METHOD
from warp_mps.elastic.hamiltonian.pair_sums import pair_sums


@functools.cache
def viscous_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `viscous_stress` and `viscous_force`."""
    real, vec, mat = types.real, types.vec, types.mat
    pair_moment = pair_sums(types).moment

    @types.kernel(METHOD)
    def viscous_stress(
        # Model:
        first: wp.int32,  # first particle of this launch
        dt: real,  # time step [s]
        start: wp.array(dtype=wp.int32),  # first pair of each particle, [n + 1]
        index: wp.array(dtype=wp.int32),  # neighbour j of each pair, [pairs]
        bond: wp.array(dtype=vec),  # reference vectors X_ij [m], [pairs]
        weight: wp.array(dtype=real),  # weights omega_ij [1/m^2], [pairs]
        inverse_shape: wp.array(dtype=mat),  # A_i^-1 [-], [n]
        volume: wp.array(dtype=real),  # reference volumes V_i [m^d], [n]
        tau_lame: wp.array(dtype=real),  # tau lambda [Pa s], [n]
        tau_mu: wp.array(dtype=real),  # tau mu [Pa s], [n]
        tau_kappa: wp.array(dtype=real),  # tau kappa_i [N m s], [n]
        # State in:
        gradient: wp.array(dtype=mat),  # displacement gradients H_i [-], [n]
        u: wp.array(dtype=vec),  # displacements u [m], [n]
        v: wp.array(dtype=vec),  # velocities [m/s], [n]
        # State out:
        stiffness_out: wp.array(dtype=mat),  # tau kappa_i G_i [N m], [n]
        damping_out: wp.array(dtype=mat),  # tau kappa_i N_i [N m s], [n]
        dilatation_out: wp.array(dtype=real),  # tr(E'_i) [1/s], [n]
        pull_out: wp.array(dtype=mat),  # D_i less the control's part and the mean dilatation's [N m], [n]
    ):
        """G_i, N_i and D_i - G_i H_i - N_i F'_i, times tau kappa_i and with A_i^-1 as in the module's docstring."""
        i = first + wp.tid()
        u_i = u[i]
        v_i = v[i]
        total = pair_moment(i, start, index, bond, weight, v)
        inverse = inverse_shape[i]
        rate = total * inverse
        one = wp.identity(n=wp.static(types.dimension), dtype=real)
        h = gradient[i]
        f = h + one
        half = real(0.5) * dt
        middle = f - half * rate
        growth = wp.transpose(middle) * rate
        s = tau_mu[i] * (growth + wp.transpose(growth)) + (tau_lame[i] * wp.trace(growth)) * one
        dilatation_out[i] = wp.trace(growth)
        # sums of e (x) e and e (x) e', by pairs: e is small beside u_ij where the body has turned
        squares = mat()
        mixed = mat()
        for k in range(start[i], start[i + 1]):
            j = index[k]
            e = u[j] - u_i - h * bond[k]
            squares += wp.outer(weight[k] * e, e)
            mixed += wp.outer(weight[k] * e, v[j] - v_i - rate * bond[k])
        control = (squares - half * mixed) * rate + mixed * middle
        kappa_f = tau_kappa[i] * f
        stiffness = kappa_f * wp.transpose(rate)
        damping = kappa_f * wp.transpose(middle) - half * stiffness
        stiffness_out[i] = stiffness
        damping_out[i] = damping
        pull = (volume[i] * (f * s) + tau_kappa[i] * control) * inverse
        pull_out[i] = pull - stiffness * h - damping * rate

    @types.kernel(METHOD)
    def viscous_force(
        # Model:
        first: wp.int32,  # first particle of this launch
        start: wp.array(dtype=wp.int32),  # first pair of each particle, [n + 1]
        index: wp.array(dtype=wp.int32),  # neighbour j of each pair, [pairs]
        bond: wp.array(dtype=vec),  # reference vectors X_ij [m], [pairs]
        weight: wp.array(dtype=real),  # weights omega_ij [1/m^2], [pairs]
        # State in:
        u: wp.array(dtype=vec),  # displacements u [m], [n]
        v: wp.array(dtype=vec),  # velocities [m/s], [n]
        stiffness: wp.array(dtype=mat),  # tau kappa_i G_i [N m], [n]
        damping: wp.array(dtype=mat),  # tau kappa_i N_i [N m s], [n]
        pull: wp.array(dtype=mat),  # D_i less the control's part [N m], [n]
        # State in and out:
        u_before: wp.array(dtype=vec),  # displacements of the last step [m], [n]
        viscous: wp.array(dtype=vec),  # viscous forces of the last step, then of this one [N], [n]
        force: wp.array(dtype=vec),  # total forces [N], [n]
        dissipated: wp.array(dtype=wp.float64),  # energy dissipated so far [J], [n]
    ):
        """Add the viscous force f_i, and the energy -1/2 (f^n + f^(n+1)) . du that it dissipates.

        The mean force over the step is that of the two half kicks of velocity Verlet, and that in the work of a moving
        support.
        """
        i = first + wp.tid()
        u_i = u[i]
        v_i = v[i]
        stiffness_i = stiffness[i]
        damping_i = damping[i]
        pull_i = pull[i]
        total = vec()
        for k in range(start[i], start[i + 1]):
            j = index[k]
            of_bond = (pull_i + pull[j]) * bond[k]
            of_control = (stiffness_i + stiffness[j]) * (u[j] - u_i) + (damping_i + damping[j]) * (v[j] - v_i)
            total += weight[k] * (of_bond + of_control)
        work = wp.float64(wp.dot(viscous[i] + total, u_i - u_before[i]))
        dissipated[i] = dissipated[i] - wp.float64(0.5) * work
        u_before[i] = u_i
        viscous[i] = total
        force[i] = force[i] + total

    return SimpleNamespace(viscous_stress=viscous_stress, viscous_force=viscous_force)
