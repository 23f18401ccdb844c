"""Kelvin-Voigt damping: forces of the rate of deformation beside those of the deformation, tau times as large.

They come from one dissipation function, which is to the rates what the energy of the model is to the strains
(`warp_mps.elastic.hamiltonian`, whose notation this is; a dash is a rate in time):

    D = sum_i V_i tau (mu E'_i : E'_i + lambda/2 tr(E'_i)^2) + sum_i sum_j 1/2 tau kappa_i omega_ij |c'_ij|^2

tau is the material's retardation time, E' the rate of the Green-Lagrange strain and c_ij = F_i^T e_ij what controls the
zero-energy modes, seen from the body; F' is fitted to the neighbours' velocities as F is to their displacements. Small
motion about rest then has a damping matrix of tau times its stiffness matrix: a mode of angular frequency omega has the
damping ratio tau omega / 2. Rotations change neither E nor c: they are not damped, and momentum and angular momentum
are kept. The forces f = -dD/dv are

    f_i = sum_j omega_ij [(D_i + D_j) X_ij + tau kappa_i F_i c'_ij - tau kappa_j F_j c'_ji]
    D_i = [V_i F_i S_i + tau kappa_i sum_j omega_ij e_ij (x) c'_ij] A_i^-1,   S = tau (2 mu E' + lambda tr(E') I)

The velocities that a step has when it evaluates forces are those in the middle of its move, while F and e are those of
its end. E and c have grown by exactly dt E' and dt c' if the factors beside F' and e' are those of the middle of the
move, F - dt/2 F' and e - dt/2 e': so a step of a rigid rotation gives no force, however large. The rates lag by half a
step, which those of an explicit step have to; a mode's frequency is off by a part of the order of tau omega^2 dt.

References:
    Christensen, R. M., Theory of Viscoelasticity, 2nd ed., section 1.6 (the Kelvin solid).
    Belytschko, T., Liu, W. K. and Moran, B., Nonlinear Finite Elements, chapter 6 (the stable explicit step).
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.kit import Kit

METHOD = "elastic"


@functools.cache
def viscous_kernels(kit: Kit) -> SimpleNamespace:
    """Kernels `viscous_stress` and `viscous_force`."""
    real, vec, mat = kit.real, kit.vec, kit.mat

    @kit.func(METHOD)
    def control_rate(h: mat, rate: mat, x: vec, du: vec, dv: vec, half: real) -> vec:
        """Rate c' of a pair: F'^T e + F^T e' in the middle of the step, `half` of it ago."""
        e_rate = dv - rate * x
        e = du - h * x - half * e_rate
        return wp.transpose(rate) * e + e_rate + wp.transpose(h - half * rate) * e_rate

    @kit.kernel(METHOD)
    def viscous_stress(
        # Model:
        first: wp.int32,
        dt: real,
        start: wp.array(dtype=wp.int32),
        index: wp.array(dtype=wp.int32),
        bond: wp.array(dtype=vec),
        weight: wp.array(dtype=real),
        inverse_shape: wp.array(dtype=mat),
        volume: wp.array(dtype=real),
        tau_lame: wp.array(dtype=real),
        tau_mu: wp.array(dtype=real),
        tau_kappa: wp.array(dtype=real),
        # State in:
        gradient: wp.array(dtype=mat),
        u: wp.array(dtype=vec),
        v: wp.array(dtype=vec),
        # State out:
        rate_out: wp.array(dtype=mat),
        pull_out: wp.array(dtype=mat),
    ):
        """F'_i and D_i."""
        i = first + wp.tid()
        u_i = u[i]
        v_i = v[i]
        total = mat()
        for k in range(start[i], start[i + 1]):
            total += wp.outer(weight[k] * (v[index[k]] - v_i), bond[k])
        inverse = inverse_shape[i]
        rate = total * inverse
        one = wp.identity(n=wp.static(kit.dimension), dtype=real)
        h = gradient[i]
        f = h + one
        half = real(0.5) * dt
        growth = wp.transpose(f - half * rate) * rate
        s = tau_mu[i] * (growth + wp.transpose(growth)) + (tau_lame[i] * wp.trace(growth)) * one
        control = mat()
        for k in range(start[i], start[i + 1]):
            j = index[k]
            e = u[j] - u_i - h * bond[k]
            c_rate = control_rate(h, rate, bond[k], u[j] - u_i, v[j] - v_i, half)
            control += wp.outer(weight[k] * e, c_rate)
        rate_out[i] = rate
        pull_out[i] = (volume[i] * (f * s) + tau_kappa[i] * control) * inverse

    @kit.kernel(METHOD)
    def viscous_force(
        # Model:
        first: wp.int32,
        dt: real,
        start: wp.array(dtype=wp.int32),
        index: wp.array(dtype=wp.int32),
        bond: wp.array(dtype=vec),
        weight: wp.array(dtype=real),
        tau_kappa: wp.array(dtype=real),
        # State in:
        gradient: wp.array(dtype=mat),
        u: wp.array(dtype=vec),
        v: wp.array(dtype=vec),
        rate: wp.array(dtype=mat),
        pull: wp.array(dtype=mat),
        # State in and out:
        u_before: wp.array(dtype=vec),
        viscous: wp.array(dtype=vec),
        force: wp.array(dtype=vec),
        dissipated: wp.array(dtype=wp.float64),
    ):
        """Add the viscous force, and account for what it takes out.

        Its work is the mean of the forces at the ends of a step's move times the move: what the two half kicks of
        velocity Verlet do, and what the work of a moving support takes it for.
        """
        i = first + wp.tid()
        u_i = u[i]
        v_i = v[i]
        h_i = gradient[i]
        rate_i = rate[i]
        pull_i = pull[i]
        kappa_i = tau_kappa[i]
        half = real(0.5) * dt
        total = vec()
        for k in range(start[i], start[i + 1]):
            j = index[k]
            x = bond[k]
            du = u[j] - u_i
            dv = v[j] - v_i
            h_j = gradient[j]
            # the neighbour's own c'_ji is that of x_ji = -x_ij
            c_i = kappa_i * control_rate(h_i, rate_i, x, du, dv, half)
            c_j = tau_kappa[j] * control_rate(h_j, rate[j], x, du, dv, half)
            total += weight[k] * ((pull_i + pull[j]) * x + c_i + h_i * c_i + c_j + h_j * c_j)
        work = wp.float64(wp.dot(viscous[i] + total, u_i - u_before[i]))
        dissipated[i] = dissipated[i] - wp.float64(0.5) * work
        u_before[i] = u_i
        viscous[i] = total
        force[i] = force[i] + total

    return SimpleNamespace(viscous_stress=viscous_stress, viscous_force=viscous_force)
