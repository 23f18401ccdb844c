"""Explicit time integration: velocity Verlet in kick-drift-kick form, with gravity and damping.

    v += dt/2 f/m,   u += dt v,   forces,   v += dt/2 f/m

The state is the displacement u = x - X, so that a strain of 1e-5 keeps its digits. The inverse mass of a held axis is
0; a moving support then imposes the motion of its particles.

References:
    Belytschko, T., Liu, W. K. and Moran, B., Nonlinear Finite Elements, chapter 6.
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.elastic import METHOD


@functools.cache
def motion_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `drift`, `kick`, `damp`, `add_lagged_damping`, `add_force` and `count_step`."""
    real, vec = types.real, types.vec

    @types.kernel(METHOD)
    def drift(
        # Model:
        first: wp.int32,  # first particle of this launch
        dt: real,  # time step [s]
        inverse_mass: wp.array(dtype=vec),  # inverse masses, 0 on held axes [1/kg], [n]
        # State in:
        force: wp.array(dtype=vec),  # total forces of the last step [N], [n]
        # State in and out:
        u: wp.array(dtype=vec),  # displacements u [m], [n]
        v: wp.array(dtype=vec),  # velocities [m/s], [n]
    ):
        """Half a kick with the forces of the last step, v += dt/2 f/m, then the drift u += dt v."""
        i = first + wp.tid()
        v_i = v[i] + real(0.5) * dt * wp.cw_mul(inverse_mass[i], force[i])
        v[i] = v_i
        u[i] = u[i] + dt * v_i

    @types.kernel(METHOD)
    def kick(
        # Model:
        first: wp.int32,  # first particle of this launch
        dt: real,  # time step [s]
        gravity: vec,  # acceleration of gravity [m/s^2]
        mass: wp.array(dtype=real),  # masses [kg], [n]
        inverse_mass: wp.array(dtype=vec),  # inverse masses, 0 on held axes [1/kg], [n]
        # State in and out:
        force: wp.array(dtype=vec),  # total forces [N], [n]
        v: wp.array(dtype=vec),  # velocities [m/s], [n]
    ):
        """Add the weight m g, which completes the force, then the second half of the kick, v += dt/2 f/m."""
        i = first + wp.tid()
        force_i = force[i] + mass[i] * gravity
        force[i] = force_i
        v[i] = v[i] + real(0.5) * dt * wp.cw_mul(inverse_mass[i], force_i)

    @types.kernel(METHOD)
    def damp(
        # Model:
        factor: wp.float64,  # exp(-damping dt/2) [-]
        mass: wp.array(dtype=real),  # masses [kg], [n]
        inverse_mass: wp.array(dtype=vec),  # inverse masses, 0 on held axes [1/kg], [n]
        # State in and out:
        v: wp.array(dtype=vec),  # velocities [m/s], [n]
        dissipated: wp.array(dtype=wp.float64),  # energy dissipated so far [J], [n]
    ):
        """Mass-proportional damping over half a step, exact: v *= exp(-damping dt/2); held axes are left out."""
        i = wp.tid()
        v_i = v[i]
        loss = wp.float64(0.0)
        for axis in range(wp.static(types.dimension)):
            if inverse_mass[i][axis] > real(0.0):
                before = wp.float64(v_i[axis])
                v_i[axis] = real(factor * before)
                after = wp.float64(v_i[axis])
                loss += wp.float64(0.5) * wp.float64(mass[i]) * (before - after) * (before + after)
        v[i] = v_i
        dissipated[i] = dissipated[i] + loss

    @types.kernel(METHOD)
    def add_lagged_damping(
        # Model:
        first: wp.int32,  # first particle of this launch
        dt: real,  # time step [s]
        factor: real,  # tau/dt [-]
        # State in:
        v: wp.array(dtype=vec),  # velocities [m/s], [n]
        # State in and out:
        elastic_before: wp.array(dtype=vec),  # elastic forces of the last step [N], [n]
        viscous_before: wp.array(dtype=vec),  # viscous forces of the last step [N], [n]
        force: wp.array(dtype=vec),  # elastic forces, then with viscous ones [N], [n]
        dissipated: wp.array(dtype=wp.float64),  # energy dissipated so far [J], [n]
    ):
        """Add the viscous force f_v = `factor` (f^n - f^(n-1)), with the elastic forces f and the factor tau/dt.

        It dissipates -dt/2 (f_v^n + f_v^(n-1)) . v in a step: the kicks at both ends of the step use these forces.
        """
        i = first + wp.tid()
        elastic = force[i]
        viscous = factor * (elastic - elastic_before[i])
        loss = real(0.5) * dt * wp.dot(viscous_before[i] + viscous, v[i])
        elastic_before[i] = elastic
        viscous_before[i] = viscous
        force[i] = elastic + viscous
        dissipated[i] = dissipated[i] - wp.float64(loss)

    @types.kernel(METHOD)
    def add_force(
        # State in:
        external: wp.array(dtype=vec),  # forces to add [N], [n]
        # State in and out:
        force: wp.array(dtype=vec),  # total forces [N], [n]
    ):
        """Add external forces, f += f_ext."""
        i = wp.tid()
        force[i] = force[i] + external[i]

    @types.kernel(METHOD)
    def count_step(
        # State in and out:
        steps: wp.array(dtype=wp.int32),  # number of steps done, [1]
    ):
        """Count a step: the time is t = n dt, so that rounding does not accumulate."""
        steps[0] = steps[0] + 1

    return SimpleNamespace(
        drift=drift,
        kick=kick,
        damp=damp,
        add_lagged_damping=add_lagged_damping,
        add_force=add_force,
        count_step=count_step,
    )
