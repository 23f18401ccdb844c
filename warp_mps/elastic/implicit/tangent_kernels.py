"""The tangent of the Hamiltonian model's forces: its action on displacements, and its diagonal blocks.

With the notation of `warp_mps.elastic.hamiltonian.kernels`, a change du of the displacements changes

    dH_i = [sum_j omega_ij du_ij (x) X_ij] A_i^-1,   dB_i = V_i (dP/dH : dH_i) A_i^-1 - kappa_i dH_i

and the forces by -K du,

    (K du)_i = -sum_j omega_ij [(dB_i + dB_j) X_ij + (kappa_i + kappa_j) du_ij]

In a strongly compressed neighbourhood, J < FIRM_BELOW, the control changes as well, with g(J) and the sum of squares
S_i = sum_j omega_ij |e_ij|^2 of `warp_mps.elastic.hamiltonian.control`:

    dJ = (J F^-T) : dH,   dS = 2 sum_j omega_ij e_ij . du_ij
    dB_i += -kappa_i g' dJ H_i + kappa_i/2 [(g'' dJ S + g' dS) J F^-T + g' S d(J F^-T)] A_i^-1
    (K du)_i -= sum_j omega_ij (kappa_i g'_i dJ_i + kappa_j g'_j dJ_j) u_ij

The mean dilatations change by the means of dD, and add q d(dD/dF) and dq dD/dF to dP
(`warp_mps.elastic.hamiltonian.dilatation_kernels`).

K is symmetric, since the forces are the gradient of an energy. The operator of a step is K + m a, with the inertia a of
the time integration rule (0 in statics).

A diagonal block of K holds sums of V (C : (du (x) b)) b, C = dP/dH. It is needed for preconditioning only: C is taken
as that of the linear law in a particle that is rotated and stretched by F, which is exact at rest and always positive,

    V (C : (du (x) b)) b ~ V [(lambda + mu) (F b) (x) (F b) + mu |F b|^2 I] du

Of lambda', which acts on mean dilatations, it counts the share `MEAN_SHARE` as lambda: a particle moves the means of
its neighbours less than their own dilatations (0.15 to 0.3 of the entry in 2-D, 0.1 to 0.2 in 3-D).
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.linear.kernels import RESTART
from warp_mps.core.types import NumericTypes
from warp_mps.elastic.hamiltonian.control import FIRM_BELOW, control_funcs
from warp_mps.elastic.hamiltonian.pair_sums import pair_sums
from warp_mps.elastic.materials.laws import law_funcs
from warp_mps.elastic.materials.volume import volume_funcs

METHOD = "implicit"
# entries of a diagonal block that come from mean dilatations, over those that the same lambda would give by itself
MEAN_SHARE = 0.2


@functools.cache
def tangent_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `choose`, `pull_change`, `product`, `blocks` and `precondition`.

    The solver's vectors are in double precision whatever the run's; the operator is applied in the run's.
    """
    real, vec, mat, d = types.real, types.vec, types.mat, types.dimension
    real64 = wp.float64
    vec64 = wp.types.vector(length=d, dtype=wp.float64)
    mat64 = wp.types.matrix(shape=(d, d), dtype=wp.float64)
    sums = pair_sums(types)
    pair_moment, pair_force = sums.moment, sums.force
    stress_change = law_funcs(types).stress_change
    volumes, controls = volume_funcs(types), control_funcs(types)
    dilatation_slope, dilatation_slope_change = volumes.dilatation_slope, volumes.dilatation_slope_change
    cofactor, cofactor_change = volumes.cofactor, volumes.cofactor_change
    growth_slope, growth_curvature = controls.growth_slope, controls.growth_curvature

    @types.kernel(METHOD)
    def choose(
        # State in:
        control: wp.array(dtype=wp.int32),  # state of the solver, see `warp_mps.core.linear.kernels`
        x: wp.array(dtype=vec64),  # solution [m], [n]
        p: wp.array(dtype=vec64),  # search direction [m], [n]
        # State out:
        direction_out: wp.array(dtype=vec),  # the vector that is multiplied [m], [n]
    ):
        """The vector that a pass of the solver multiplies: the solution x in a restart pass, else the direction p."""
        i = wp.tid()
        if control[RESTART] != 0:
            direction_out[i] = vec(x[i])
        else:
            direction_out[i] = vec(p[i])

    @types.kernel(METHOD)
    def pull_change(
        # Model:
        start: wp.array(dtype=wp.int32),  # first pair of each particle, [n + 1]
        index: wp.array(dtype=wp.int32),  # neighbour j of each pair, [pairs]
        bond: wp.array(dtype=vec),  # reference vectors X_ij [m], [pairs]
        weight: wp.array(dtype=real),  # weights omega_ij [1/m^2], [pairs]
        inverse_shape: wp.array(dtype=mat),  # A_i^-1 [-], [n]
        volume: wp.array(dtype=real),  # reference volumes V_i [m^d], [n]
        kappa: wp.array(dtype=real),  # stiffness kappa_i of the hourglass control [N m], [n]
        law: wp.array(dtype=wp.int32),  # 0 for St. Venant-Kirchhoff, 1 for neo-Hookean, [n]
        lame: wp.array(dtype=real),  # Lame's constant lambda [Pa], [n]
        mu: wp.array(dtype=real),  # Lame's constant mu [Pa], [n]
        plane_stress: wp.int32,  # 1 for plane stress, else 0
        # State in:
        u: wp.array(dtype=vec),  # displacements u [m], [n]
        gradient: wp.array(dtype=mat),  # displacement gradients H_i [-], [n]
        resistance: wp.array(dtype=real),  # kappa_i g(J_i) [N m], [n]
        mean_stress: wp.array(dtype=real),  # Kirchhoff stress q_i of the mean dilatations [Pa], [n]
        direction: wp.array(dtype=vec),  # direction du [m], [n]
        # State out:
        dilatation_out: wp.array(dtype=real),  # changes dD_i of the dilatations [-], [n]
        resistance_out: wp.array(dtype=real),  # changes of kappa_i g(J_i) [N m], [n]
        change_out: wp.array(dtype=mat),  # dB_i, but for the change of the mean dilatations [N m], [n]
    ):
        """Change dB_i of B_i along a direction du."""
        i = wp.tid()
        total = pair_moment(i, start, index, bond, weight, direction)
        inverse = inverse_shape[i]
        h = gradient[i]
        dh = total * inverse
        dp = stress_change(law[i], h, dh, lame[i], mu[i], plane_stress)
        if mean_stress[i] != real(0.0):
            dp += mean_stress[i] * dilatation_slope_change(law[i], h, dh)
        dilatation_out[i] = wp.ddot(dilatation_slope(law[i], h), dh)
        dk = real(0.0)
        f = h + wp.identity(n=wp.static(d), dtype=real)
        j = wp.determinant(f)
        if j < real(FIRM_BELOW):
            squares = real(0.0)
            squares_change = real(0.0)
            for k in range(start[i], start[i + 1]):
                other = index[k]
                e = u[other] - u[i] - h * bond[k]
                squares += weight[k] * wp.dot(e, e)
                squares_change += weight[k] * wp.dot(e, direction[other] - direction[i])
            cof = cofactor(f)
            dj = wp.ddot(cof, dh)
            slope = growth_slope(j)
            dk = kappa[i] * slope * dj
            dz = growth_curvature(j) * dj * squares + real(2.0) * slope * squares_change
            half = real(0.5) * kappa[i] / volume[i]
            dp += (half * dz) * cof + (half * slope * squares) * cofactor_change(f, dh)
        resistance_out[i] = dk
        change_out[i] = volume[i] * dp * inverse - resistance[i] * dh - dk * h

    @types.kernel(METHOD)
    def product(
        # Model:
        start: wp.array(dtype=wp.int32),  # first pair of each particle, [n + 1]
        index: wp.array(dtype=wp.int32),  # neighbour j of each pair, [pairs]
        bond: wp.array(dtype=vec),  # reference vectors X_ij [m], [pairs]
        weight: wp.array(dtype=real),  # weights omega_ij [1/m^2], [pairs]
        mass: wp.array(dtype=real),  # masses [kg], [n]
        inertia: wp.array(dtype=wp.float64),  # inertia a of the step, 0 in statics [1/s^2], [1]
        # State in:
        u: wp.array(dtype=vec),  # displacements u [m], [n]
        resistance: wp.array(dtype=real),  # kappa_i g(J_i) [N m], [n]
        direction: wp.array(dtype=vec),  # direction du [m], [n]
        resistance_change: wp.array(dtype=real),  # changes of kappa_i g(J_i) [N m], [n]
        change: wp.array(dtype=mat),  # dB_i [N m], [n]
        # State out:
        product_out: wp.array(dtype=vec64),  # (K + m a) du [N], [n]
    ):
        """Product (K + m a) du of the tangent."""
        i = wp.tid()
        force = pair_force(i, start, index, bond, weight, resistance, direction, change)
        for k in range(start[i], start[i + 1]):
            dk = resistance_change[i] + resistance_change[index[k]]
            if dk != real(0.0):
                force += (weight[k] * dk) * (u[index[k]] - u[i])
        product_out[i] = (inertia[0] * real64(mass[i])) * vec64(direction[i]) - vec64(force)

    @types.func(METHOD)
    def acoustic(c: real, f: mat, b: vec, lame: real, mu: real, law: wp.int32, plane_stress: wp.int32) -> mat:
        """C times (F b) (x) (F b) and |F b|^2; the neo-Hookean law's lambda is not yet that of plane stress."""
        plane = lame
        if law != 0 and plane_stress == 1:
            plane = real(2.0) * mu * lame / (lame + real(2.0) * mu)
        g = b + f * b
        unit = wp.identity(n=wp.static(d), dtype=real)
        return c * ((plane + mu) * wp.outer(g, g) + (mu * wp.dot(g, g)) * unit)

    @types.kernel(METHOD)
    def blocks(
        # Model:
        start: wp.array(dtype=wp.int32),  # first pair of each particle, [n + 1]
        index: wp.array(dtype=wp.int32),  # neighbour j of each pair, [pairs]
        bond: wp.array(dtype=vec),  # reference vectors X_ij [m], [pairs]
        weight: wp.array(dtype=real),  # weights omega_ij [1/m^2], [pairs]
        inverse_shape: wp.array(dtype=mat),  # A_i^-1 [-], [n]
        volume: wp.array(dtype=real),  # reference volumes V_i [m^d], [n]
        law: wp.array(dtype=wp.int32),  # 0 for St. Venant-Kirchhoff, 1 for neo-Hookean, [n]
        lame: wp.array(dtype=real),  # Lame's constant lambda [Pa], [n]
        mu: wp.array(dtype=real),  # Lame's constant mu [Pa], [n]
        plane_stress: wp.int32,  # 1 for plane stress, else 0
        mean_lame: wp.array(dtype=real),  # part lambda' of lambda on the mean dilatation [Pa], [n]
        mass: wp.array(dtype=real),  # masses [kg], [n]
        inertia: wp.array(dtype=wp.float64),  # inertia a of the step, 0 in statics [1/s^2], [1]
        free: wp.array(dtype=vec),  # 1 on free axes, 0 on held ones, [n]
        # State in:
        gradient: wp.array(dtype=mat),  # displacement gradients H_i [-], [n]
        resistance: wp.array(dtype=real),  # kappa_i g(J_i) [N m], [n]
        # State out:
        block_out: wp.array(dtype=mat64),  # diagonal blocks D_i [N/m], [n]
        inverse_out: wp.array(dtype=mat64),  # their inverses among the free axes [m/N], [n]
    ):
        """Diagonal block D_i of K + m a, and its inverse among the free axes."""
        i = wp.tid()
        unit = wp.identity(n=wp.static(d), dtype=real)
        asymmetry = vec()
        total = mat()
        control = real(0.0)
        for k in range(start[i], start[i + 1]):
            j = index[k]
            w = weight[k]
            asymmetry += w * bond[k]
            b = inverse_shape[j] * bond[k]
            counted = lame[j] + real(MEAN_SHARE) * mean_lame[j]
            total += acoustic(w * w * volume[j], gradient[j], b, counted, mu[j], law[j], plane_stress)
            control += w * (resistance[i] + resistance[j]) - w * w * resistance[j] * wp.dot(b, bond[k])
        # what the particle's own gradient adds where its neighbours do not surround it
        a = inverse_shape[i] * asymmetry
        counted_here = lame[i] + real(MEAN_SHARE) * mean_lame[i]
        total += acoustic(volume[i], gradient[i], a, counted_here, mu[i], law[i], plane_stress)
        control -= resistance[i] * wp.dot(a, asymmetry)
        block = mat64(total + control * unit)
        held = mat64()
        for row in range(wp.static(d)):
            block[row, row] += inertia[0] * real64(mass[i])
            for column in range(wp.static(d)):
                if free[i][row] > real(0.0) and free[i][column] > real(0.0):
                    held[row, column] = block[row, column]
                elif row == column:
                    held[row, column] = real64(1.0)
        block_out[i] = block
        inverse_out[i] = wp.inverse(held)

    @types.kernel(METHOD)
    def precondition(
        # State in:
        inverse: wp.array(dtype=mat64),  # inverses of the diagonal blocks [m/N], [n]
        r: wp.array(dtype=vec64),  # residual [N], [n]
        # State out:
        z_out: wp.array(dtype=vec64),  # preconditioned residual [m], [n]
    ):
        """Block Jacobi preconditioner z_i = D_i^-1 r_i."""
        i = wp.tid()
        z_out[i] = inverse[i] * r[i]

    made = (choose, pull_change, product, blocks, precondition)
    return SimpleNamespace(**{kernel.func.__name__: kernel for kernel in made})
