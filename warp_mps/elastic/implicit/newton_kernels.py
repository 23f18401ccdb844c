"""Kernels of Newton's method: residual and potential, trial steps, and the sums that the host reads.

The potential that is minimized over the displacements of the free axes is

    Pi(u) = W(u) - f . u + a/2 (u - c) . m (u - c),   -dPi/du = r = f_el(u) + f - a m (u - c)

with the elastic energy W, applied forces f that do not depend on u, and in a step of time an inertia a about a place c.

The residual cannot become smaller than the rounding of the forces that cancel in it. Displacements are known to
eps |u|, eps the unit roundoff, and the pair forces and the inertia answer to that by

    r_round = eps (|K_ii| + m a) |u|

with the diagonal block K_ii of the tangent at rest: a stiff body that has moved far as a whole has a large one.
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.elastic.implicit.tangent_kernels import METHOD

# Values that the host reads: the square of the residual, r . du, the squares of its scale and of its rounding, and
# twice the potential. Sums come in pairs: the last value is the sum of squares of the terms of the potential.
RESIDUAL, SLOPE, SCALE, ROUNDING, POTENTIAL, NUMBERS = 0, 1, 2, 3, 4, 6


# relative error of a number that is stored
UNIT_ROUNDOFF = {"float64": 2.0**-53, "float32": 2.0**-24}


@functools.cache
def newton_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `residual`, `jump`, `right_hand_side`, `add_jump`, `trial` and `store_sums`."""
    real, vec, d = types.real, types.vec, types.dimension
    real64 = wp.float64
    vec64 = wp.types.vector(length=d, dtype=wp.float64)
    mat64 = wp.types.matrix(shape=(d, d), dtype=wp.float64)
    roundoff = UNIT_ROUNDOFF[types.precision]

    @types.kernel(METHOD)
    def residual(
        # Model:
        free: wp.array(dtype=vec),  # 1 on free axes, 0 on held ones, [n]
        mass: wp.array(dtype=real),  # masses [kg], [n]
        inertia: wp.array(dtype=wp.float64),  # inertia a of the step, 0 in statics [1/s^2], [1]
        stiffness: wp.array(dtype=mat64),  # magnitudes of the diagonal blocks K_ii at rest [N/m], [n]
        # State in:
        u: wp.array(dtype=vec),  # displacements u [m], [n]
        center: wp.array(dtype=vec),  # places c [m], [n]
        force: wp.array(dtype=vec),  # elastic forces [N], [n]
        applied: wp.array(dtype=vec),  # applied forces f [N], [n]
        energy: wp.array(dtype=real),  # elastic energies [J], [n]
        # State out:
        residual_out: wp.array(dtype=vec64),  # residual r [N], [n]
        scale_out: wp.array(dtype=vec64),  # scale of the residual [N], [n]
        rounding_out: wp.array(dtype=vec64),  # rounding of the residual [N], [n]
        potential_out: wp.array(dtype=wp.float64),  # twice the potential [J], [n]
    ):
        """Residual r and its rounding on free axes, potential Pi; scale of r: applied forces, elastic on held axes."""
        i = wp.tid()
        f = vec64(force[i])
        load = vec64(applied[i])
        away = vec64(u[i] - center[i])
        pull = (inertia[0] * real64(mass[i])) * away
        r = f + load - pull
        scale = load
        size = wp.abs(vec64(u[i]))
        rounding = real64(roundoff) * (stiffness[i] * size + (inertia[0] * real64(mass[i])) * size)
        for axis in range(wp.static(d)):
            if free[i][axis] == real(0.0):
                r[axis] = real64(0.0)
                scale[axis] = f[axis]
                rounding[axis] = real64(0.0)
        residual_out[i] = r
        scale_out[i] = scale
        rounding_out[i] = rounding
        potential_out[i] = real64(2.0) * (real64(energy[i]) - wp.dot(load, vec64(u[i]))) + wp.dot(pull, away)

    @types.kernel(METHOD)
    def jump(
        # Model:
        free: wp.array(dtype=vec),  # 1 on free axes, 0 on held ones, [n]
        # State in:
        u: wp.array(dtype=vec),  # displacements u [m], [n]
        target: wp.array(dtype=vec),  # target displacements of held axes [m], [n]
        # State out:
        change_out: wp.array(dtype=vec64),  # changes du [m], [n]
    ):
        """Change of held axes to their target, u_target - u; 0 on free axes."""
        i = wp.tid()
        away = vec64(target[i] - u[i])
        for axis in range(wp.static(d)):
            if free[i][axis] > real(0.0):
                away[axis] = real64(0.0)
        change_out[i] = away

    @types.kernel(METHOD)
    def right_hand_side(
        # Model:
        free: wp.array(dtype=vec),  # 1 on free axes, 0 on held ones, [n]
        # State in:
        residual: wp.array(dtype=vec64),  # residual r [N], [n]
        pushed: wp.array(dtype=vec64),  # A du of the held axes [N], [n]
        # State out:
        right_out: wp.array(dtype=vec64),  # right-hand side [N], [n]
        change_out: wp.array(dtype=vec64),  # changes du [m], [n]
    ):
        """Right-hand side r - A du_held of the change of the free axes, and its initial guess 0."""
        i = wp.tid()
        right_out[i] = residual[i] - wp.cw_mul(vec64(free[i]), pushed[i])
        change_out[i] = vec64()

    @types.kernel(METHOD)
    def add_jump(
        # State in:
        jump: wp.array(dtype=vec64),  # changes of held axes [m], [n]
        # State in and out:
        change: wp.array(dtype=vec64),  # changes du [m], [n]
    ):
        """Add the change of the held axes to that of the free ones."""
        i = wp.tid()
        change[i] = change[i] + jump[i]

    @types.kernel(METHOD)
    def trial(
        # Model:
        step: wp.array(dtype=wp.float64),  # length of the step of the line search [-], [1]
        # State in:
        u_kept: wp.array(dtype=vec),  # displacements that it starts from [m], [n]
        change: wp.array(dtype=vec64),  # changes du [m], [n]
        # State out:
        u_out: wp.array(dtype=vec),  # trial displacements [m], [n]
    ):
        """Trial displacements u = u_kept + step du of the line search."""
        i = wp.tid()
        u_out[i] = vec(vec64(u_kept[i]) + step[0] * change[i])

    @types.kernel(METHOD)
    def store_sums(
        # Model:
        place: wp.int32,  # where the sums are stored
        # State in:
        sums: wp.array(dtype=wp.vec2d),  # two sums, [1]
        # State out:
        numbers_out: wp.array(dtype=wp.float64),  # values that the host reads, [NUMBERS]
    ):
        """Store two sums where the host reads them."""
        numbers_out[place] = sums[0][0]
        numbers_out[place + 1] = sums[0][1]

    made = (residual, jump, right_hand_side, add_jump, trial, store_sums)
    return SimpleNamespace(**{kernel.func.__name__: kernel for kernel in made})
