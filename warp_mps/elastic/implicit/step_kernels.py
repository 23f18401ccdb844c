"""Kernels of implicit steps: load increments of statics, and the theta rule of time integration.

The equations are those of `warp_mps.elastic.implicit.static` and `warp_mps.elastic.implicit.theta_rule`.
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.elastic.implicit.tangent_kernels import METHOD


@functools.cache
def step_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels of statics: `scale_loads` to `static_work`; of a step, in order: `assemble_step` to `total_force`."""
    real, vec, d = types.real, types.vec, types.dimension
    real64 = wp.float64
    vec64 = wp.types.vector(length=types.dimension, dtype=wp.float64)

    @types.kernel(METHOD)
    def scale_loads(
        # Model:
        factor: wp.array(dtype=wp.float64),  # load factor s [-], [1]
        load: wp.array(dtype=vec),  # loads f [N], [n]
        place: wp.array(dtype=vec),  # displacements u_end of held axes [m], [n]
        # State out:
        applied_out: wp.array(dtype=vec),  # applied forces [N], [n]
        target_out: wp.array(dtype=vec),  # target displacements of held axes [m], [n]
    ):
        """Loads s f and target displacements s u_end of held axes at a load factor s."""
        i = wp.tid()
        part = real(factor[0])
        applied_out[i] = part * load[i]
        target_out[i] = part * place[i]

    @types.kernel(METHOD)
    def extrapolate_increment(
        # Model:
        part: wp.array(dtype=wp.float64),  # share of the last increment [-], [1]
        free: wp.array(dtype=vec),  # 1 on free axes, 0 on held ones, [n]
        # State in:
        u_earlier: wp.array(dtype=vec),  # displacements before the last increment [m], [n]
        # State in and out:
        u: wp.array(dtype=vec),  # displacements u [m], [n]
    ):
        """Initial guess u += part (u - u_earlier) on free axes: the last increment, continued."""
        i = wp.tid()
        u[i] = u[i] + real(part[0]) * wp.cw_mul(free[i], u[i] - u_earlier[i])

    @types.kernel(METHOD)
    def static_work(
        # Model:
        free: wp.array(dtype=vec),  # 1 on free axes, 0 on held ones, [n]
        # State in:
        u_before: wp.array(dtype=vec),  # displacements before the step [m], [n]
        force_before: wp.array(dtype=vec),  # elastic forces before the step [N], [n]
        applied_before: wp.array(dtype=vec),  # applied forces before the step [N], [n]
        u: wp.array(dtype=vec),  # displacements u [m], [n]
        force: wp.array(dtype=vec),  # elastic forces [N], [n]
        applied: wp.array(dtype=vec),  # applied forces [N], [n]
        # State in and out:
        work: wp.array(dtype=wp.float64),  # work so far [J], [n]
    ):
        """Work of an increment, W += 1/2 (f^n + f^(n+1)) . du: of loads, and of supports against the elastic forces."""
        i = wp.tid()
        total = real64(0.0)
        for axis in range(wp.static(d)):
            mean = real64(applied_before[i][axis]) + real64(applied[i][axis])
            if free[i][axis] == real(0.0):
                mean = -real64(force_before[i][axis]) - real64(force[i][axis])
            total += real64(0.5) * mean * real64(u[i][axis] - u_before[i][axis])
        work[i] = work[i] + total

    @types.kernel(METHOD)
    def assemble_step(
        # Model:
        theta: wp.float64,  # theta of the rule [-]
        damping: wp.float64,  # mass-proportional damping [1/s]
        dt: wp.array(dtype=wp.float64),  # time step [s], [1]
        gravity: vec,  # acceleration of gravity [m/s^2]
        mass: wp.array(dtype=real),  # masses [kg], [n]
        # State in:
        u: wp.array(dtype=vec),  # displacements u [m], [n]
        v: wp.array(dtype=vec),  # velocities [m/s], [n]
        end: wp.array(dtype=vec),  # displacements of held axes at the end of the step [m], [n]
        load_before: wp.array(dtype=vec),  # loads at the start of the step [N], [n]
        load: wp.array(dtype=vec),  # loads at the end of the step [N], [n]
        external: wp.array(dtype=vec),  # external forces, constant over the step [N], [n]
        # State out:
        inertia_out: wp.array(dtype=wp.float64),  # inertia a [1/s^2], [1]
        u_before_out: wp.array(dtype=vec),  # displacements before the step [m], [n]
        center_out: wp.array(dtype=vec),  # places c [m], [n]
        target_out: wp.array(dtype=vec),  # target displacements of held axes [m], [n]
        pushed_out: wp.array(dtype=vec),  # loads and external forces [N], [n]
        applied_out: wp.array(dtype=vec),  # applied forces [N], [n]
    ):
        """The equation at t + theta dt: c, a, the target of held axes, and the applied forces."""
        i = wp.tid()
        h = theta * dt[0]
        if i == 0:
            inertia_out[0] = (real64(1.0) + damping * h) / (h * h)
        u_before_out[i] = u[i]
        center_out[i] = u[i] + real(h / (real64(1.0) + damping * h)) * v[i]
        target_out[i] = u[i] + real(theta) * (end[i] - u[i])
        pushed = real(real64(1.0) - theta) * load_before[i] + real(theta) * load[i] + external[i]
        pushed_out[i] = pushed
        applied_out[i] = pushed + mass[i] * gravity

    @types.kernel(METHOD)
    def initial_guess(
        # Model:
        theta: wp.float64,  # theta of the rule [-]
        dt: wp.array(dtype=wp.float64),  # time step [s], [1]
        free: wp.array(dtype=vec),  # 1 on free axes, 0 on held ones, [n]
        # State in:
        u_before: wp.array(dtype=vec),  # displacements before the step [m], [n]
        velocity: wp.array(dtype=vec),  # mean velocities of the last step [m/s], [n]
        # State in and out:
        u: wp.array(dtype=vec),  # displacements u [m], [n]
    ):
        """Initial guess u = u_0 + theta dt v on free axes, with the mean velocity v of the last step."""
        i = wp.tid()
        u[i] = u[i] + wp.cw_mul(free[i], u_before[i] + real(theta * dt[0]) * velocity[i] - u[i])

    @types.kernel(METHOD)
    def mean_velocity(
        # State in:
        dt: wp.array(dtype=wp.float64),  # time step [s], [1]
        u_before: wp.array(dtype=vec),  # displacements before the step [m], [n]
        u: wp.array(dtype=vec),  # displacements u [m], [n]
        # State out:
        velocity_out: wp.array(dtype=vec),  # mean velocities [m/s], [n]
    ):
        """Mean velocity (u_1 - u_0)/dt over a step."""
        i = wp.tid()
        velocity_out[i] = (u[i] - u_before[i]) / real(dt[0])

    @types.kernel(METHOD)
    def extrapolate(
        # Model:
        theta: wp.float64,  # theta of the rule [-]
        damping: wp.float64,  # mass-proportional damping [1/s]
        dt: wp.array(dtype=wp.float64),  # time step [s], [1]
        free: wp.array(dtype=vec),  # 1 on free axes, 0 on held ones, [n]
        mass: wp.array(dtype=real),  # masses [kg], [n]
        # State in:
        u_before: wp.array(dtype=vec),  # displacements before the step [m], [n]
        end: wp.array(dtype=vec),  # displacements of held axes at the end of the step [m], [n]
        end_speed: wp.array(dtype=vec),  # velocities of held axes at the end of the step [m/s], [n]
        force: wp.array(dtype=vec),  # elastic forces [N], [n]
        pushed: wp.array(dtype=vec),  # loads and external forces [N], [n]
        applied: wp.array(dtype=vec),  # applied forces [N], [n]
        # State in and out:
        u: wp.array(dtype=vec),  # displacements u [m], [n]
        v: wp.array(dtype=vec),  # velocities [m/s], [n]
        work: wp.array(dtype=wp.float64),  # work so far [J], [n]
        dissipated: wp.array(dtype=wp.float64),  # energy dissipated so far [J], [n]
    ):
        """u_1 and v_1 from u_theta, the work of applied forces, and the energy loss of damping and of the theta rule.

        A support's work is the gain of kinetic energy of what it moves, less the work of the other forces there.
        """
        i = wp.tid()
        u_i = u[i]
        v_i = v[i]
        m = real64(mass[i])
        gained = real64(0.0)
        lost = real64(0.0)
        for axis in range(wp.static(d)):
            old = real64(v_i[axis])
            if free[i][axis] > real(0.0):
                away = real64(u_i[axis] - u_before[i][axis])
                speed = away / (theta * dt[0])
                new = old + (speed - old) / theta
                move = away / theta
                u_i[axis] = u_before[i][axis] + real(move)
                v_i[axis] = real(new)
                gained += real64(pushed[i][axis]) * move
                lost += (theta - real64(0.5)) * m * (new - old) * (new - old) + damping * dt[0] * m * speed * speed
            else:
                move = real64(end[i][axis] - u_before[i][axis])
                new = real64(end_speed[i][axis])
                others = real64(force[i][axis]) + real64(applied[i][axis])
                u_i[axis] = end[i][axis]
                v_i[axis] = real(new)
                gained += real64(0.5) * m * (new * new - old * old)
                gained += (real64(pushed[i][axis]) - others) * move
        u[i] = u_i
        v[i] = v_i
        work[i] = work[i] + gained
        dissipated[i] = dissipated[i] + lost

    @types.kernel(METHOD)
    def add_dissipation(
        # State in:
        u_before: wp.array(dtype=vec),  # displacements before the step [m], [n]
        u: wp.array(dtype=vec),  # displacements u [m], [n]
        force: wp.array(dtype=vec),  # elastic forces at t + theta dt [N], [n]
        energy: wp.array(dtype=real),  # elastic energies [J], [n]
        # State in and out:
        energy_before: wp.array(dtype=real),  # elastic energies before the step, then after it [J], [n]
        dissipated: wp.array(dtype=wp.float64),  # energy dissipated so far [J], [n]
    ):
        """Energy that the theta rule dissipates in the deformation, W_0 - W_1 - f(u_theta) . du.

        For small strains it is (theta - 1/2) du . K du, K the stiffness.
        """
        i = wp.tid()
        done = wp.dot(vec64(force[i]), vec64(u[i]) - vec64(u_before[i]))
        dissipated[i] = dissipated[i] + (real64(energy_before[i]) - real64(energy[i]) - done)
        energy_before[i] = energy[i]

    @types.kernel(METHOD)
    def total_force(
        # Model:
        gravity: vec,  # acceleration of gravity [m/s^2]
        mass: wp.array(dtype=real),  # masses [kg], [n]
        # State in:
        load: wp.array(dtype=vec),  # loads at the end of the step [N], [n]
        external: wp.array(dtype=vec),  # external forces, constant over the step [N], [n]
        # State out:
        elastic_out: wp.array(dtype=vec),  # elastic forces [N], [n]
        # State in and out:
        force: wp.array(dtype=vec),  # elastic forces, then total ones [N], [n]
    ):
        """Keep the elastic forces, and add loads, external forces and weight: f = f_el + f_load + f_ext + m g."""
        i = wp.tid()
        elastic_out[i] = force[i]
        force[i] = force[i] + load[i] + external[i] + mass[i] * gravity

    made = (
        scale_loads,
        extrapolate_increment,
        static_work,
        assemble_step,
        initial_guess,
        mean_velocity,
        extrapolate,
        add_dissipation,
        total_force,
    )
    return SimpleNamespace(**{kernel.func.__name__: kernel for kernel in made})
