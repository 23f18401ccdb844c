"""Kernels that transfer motion and forces across the interface of bodies and fluid.

Marker j stands for the particles i of a set M_j, which `first` and `members` list row by row, N_j of them.
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.coupling.robin_kernels import METHOD


@functools.cache
def interface_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `transfer_motion`, `accelerate`, `transfer_forces`, `apply_collisions` and `replace_force`."""
    vec, d = types.vec, types.dimension
    vec64 = wp.types.vector(length=d, dtype=wp.float64)

    @types.kernel(METHOD)
    def transfer_motion(
        # Model:
        first: wp.array(dtype=wp.int32),  # first member of each marker, [e + 1]
        members: wp.array(dtype=wp.int32),  # particles of the markers, [members]
        reference: wp.array(dtype=vec64),  # reference positions of the particles [m], [n]
        ahead: wp.array(dtype=wp.float64),  # time h ahead [s], [1]
        # State in:
        displacement: wp.array(dtype=vec),  # displacements of the particles [m], [n]
        velocity: wp.array(dtype=vec),  # velocities of the particles [m/s], [n]
        # State out:
        x_out: wp.array(dtype=vec),  # positions of the markers [m], [e]
        u_out: wp.array(dtype=vec),  # velocities of the markers [m/s], [e]
    ):
        """Positions x_j = sum_i (X_i + u_i + h v_i) / N_j and velocities sum_i v_i / N_j of the markers, h `ahead`."""
        j = wp.tid()
        x = vec64()
        u = vec64()
        for m in range(first[j], first[j + 1]):
            i = members[m]
            x += reference[i] + vec64(displacement[i])
            u += vec64(velocity[i])
        part = wp.float64(1.0) / wp.float64(first[j + 1] - first[j])
        x_out[j] = vec(part * (x + ahead[0] * u))
        u_out[j] = vec(part * u)

    @types.kernel(METHOD)
    def accelerate(
        # Model:
        first: wp.array(dtype=wp.int32),  # first member of each marker, [e + 1]
        members: wp.array(dtype=wp.int32),  # particles of the markers, [members]
        # State in:
        dt: wp.array(dtype=wp.float64),  # time step [s], [1]
        before: wp.array(dtype=vec),  # velocities at the start of the step [m/s], [n]
        velocity: wp.array(dtype=vec),  # velocities of the particles [m/s], [n]
        # Out:
        a_out: wp.array(dtype=vec),  # accelerations of the markers [m/s^2], [e]
    ):
        """Mean accelerations a_j = sum_i (v_i - v_i before) / (N_j dt) of the markers over a step."""
        j = wp.tid()
        total = vec64()
        for m in range(first[j], first[j + 1]):
            i = members[m]
            total += vec64(velocity[i]) - vec64(before[i])
        a_out[j] = vec(total / (dt[0] * wp.float64(first[j + 1] - first[j])))

    @types.kernel(METHOD)
    def transfer_forces(
        # Model:
        first: wp.array(dtype=wp.int32),  # first member of each marker, [e + 1]
        members: wp.array(dtype=wp.int32),  # particles of the markers, [members]
        # State in:
        force: wp.array(dtype=vec64),  # forces F_j on the markers [N], [e]
        # Out:
        external_out: wp.array(dtype=vec),  # forces on the particles [N], [n]
    ):
        """Forces f_i = F_j / N_j on the particles of the markers."""
        j = wp.tid()
        part = force[j] / wp.float64(first[j + 1] - first[j])
        for m in range(first[j], first[j + 1]):
            external_out[members[m]] = vec(part)

    @types.kernel(METHOD)
    def apply_collisions(
        # Model:
        first: wp.array(dtype=wp.int32),  # first member of each marker, [e + 1]
        members: wp.array(dtype=wp.int32),  # particles of the markers, [members]
        mass: wp.array(dtype=wp.float64),  # masses [kg], [n]
        free: wp.array(dtype=vec),  # 1 on free axes, 0 on held ones, [n]
        # State in:
        dt: wp.array(dtype=wp.float64),  # time step [s], [1]
        impulse_before: wp.array(dtype=vec64),  # impulses on the markers at the start of the step [N s], [e]
        impulse: wp.array(dtype=vec64),  # impulses on the markers [N s], [e]
        external: wp.array(dtype=vec),  # forces of the fluid on the particles [N], [n]
        displacement_before: wp.array(dtype=vec),  # displacements at the start of the step [m], [n]
        displacement: wp.array(dtype=vec),  # displacements of the particles [m], [n]
        # State in and out:
        velocity: wp.array(dtype=vec),  # velocities of the particles [m/s], [n]
        pressure_work: wp.array(dtype=wp.float64),  # work of the forces so far [J], [e]
        free_work: wp.array(dtype=wp.float64),  # work of collisions on free axes so far [J], [e]
        held_work: wp.array(dtype=wp.float64),  # work of collisions on held axes so far [J], [e]
    ):
        """Collision impulses J_j on the particles of a marker, and the works of a step.

        J_j is the impulse of the step less that of the forces, sum_i dt f_i. It changes the velocities of free axes by
        J_j / (N_j m_i); a support takes it up on the others. The works are those of the forces, and of collisions on
        free and on held axes, the latter with the mean of the velocities before and after.
        """
        j = wp.tid()
        part = wp.float64(1.0) / wp.float64(first[j + 1] - first[j])
        impulse_of_forces = vec64()
        for m in range(first[j], first[j + 1]):
            impulse_of_forces += dt[0] * vec64(external[members[m]])
        rest = impulse[j] - impulse_before[j] - impulse_of_forces
        for m in range(first[j], first[j + 1]):
            i = members[m]
            before = velocity[i]
            jump = vec64(free[i]) * wp.float64(part / mass[i])
            after = vec(vec64(before) + wp.cw_mul(jump, rest))
            velocity[i] = after
            moved = vec64(displacement[i]) - vec64(displacement_before[i])
            mean = wp.float64(0.5) * part * wp.cw_mul(rest, vec64(before) + vec64(after))
            pressure_work[j] = pressure_work[j] + wp.dot(vec64(external[i]), moved)
            on_free = wp.dot(vec64(free[i]), mean)
            free_work[j] = free_work[j] + on_free
            for axis in range(wp.static(d)):
                held_work[j] = held_work[j] + (wp.float64(1.0) - wp.float64(free[i][axis])) * mean[axis]

    @types.kernel(METHOD)
    def replace_force(
        # State in:
        external: wp.array(dtype=vec),  # forces of the fluid on the particles [N], [n]
        # State in and out:
        included: wp.array(dtype=vec),  # external force that the total force includes [N], [n]
        force: wp.array(dtype=vec),  # total forces [N], [n]
    ):
        """Replace the external force in a total force by that of the step which begins."""
        i = wp.tid()
        force[i] = force[i] + (external[i] - included[i])
        included[i] = external[i]

    return SimpleNamespace(
        transfer_motion=transfer_motion,
        accelerate=accelerate,
        transfer_forces=transfer_forces,
        apply_collisions=apply_collisions,
        replace_force=replace_force,
    )
