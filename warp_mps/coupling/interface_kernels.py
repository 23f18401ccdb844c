"""Kernels between the particles of bodies and the markers that the water sees of them."""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.coupling.robin_kernels import METHOD


@functools.cache
def marker_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `show`, `accelerate`, `share`, `receive` and `load`."""
    vec, d = types.vec, types.dimension
    vec64 = wp.types.vector(length=d, dtype=wp.float64)

    @types.kernel(METHOD)
    def show(
        # Model:
        first: wp.array(dtype=wp.int32),
        members: wp.array(dtype=wp.int32),
        reference: wp.array(dtype=vec64),
        ahead: wp.array(dtype=wp.float64),
        # State in:
        displacement: wp.array(dtype=vec),
        velocity: wp.array(dtype=vec),
        # State out:
        x_out: wp.array(dtype=vec),
        u_out: wp.array(dtype=vec),
    ):
        """Places and velocities of the markers: of now, or of a time ahead if nothing acts."""
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
        first: wp.array(dtype=wp.int32),
        members: wp.array(dtype=wp.int32),
        # State in:
        dt: wp.array(dtype=wp.float64),
        before: wp.array(dtype=vec),
        velocity: wp.array(dtype=vec),
        # Out:
        a_out: wp.array(dtype=vec),
    ):
        """Mean accelerations of the markers over a step that ends with the velocities."""
        j = wp.tid()
        total = vec64()
        for m in range(first[j], first[j + 1]):
            i = members[m]
            total += vec64(velocity[i]) - vec64(before[i])
        a_out[j] = vec(total / (dt[0] * wp.float64(first[j + 1] - first[j])))

    @types.kernel(METHOD)
    def share(
        # Model:
        first: wp.array(dtype=wp.int32),
        members: wp.array(dtype=wp.int32),
        # State in:
        force: wp.array(dtype=vec64),
        # Out:
        external_out: wp.array(dtype=vec),
    ):
        """The forces on the markers, evenly to their particles."""
        j = wp.tid()
        part = force[j] / wp.float64(first[j + 1] - first[j])
        for m in range(first[j], first[j + 1]):
            external_out[members[m]] = vec(part)

    @types.kernel(METHOD)
    def receive(
        # Model:
        first: wp.array(dtype=wp.int32),
        members: wp.array(dtype=wp.int32),
        mass: wp.array(dtype=wp.float64),
        free: wp.array(dtype=vec),
        # State in:
        dt: wp.array(dtype=wp.float64),
        impulse_before: wp.array(dtype=vec64),
        impulse: wp.array(dtype=vec64),
        external: wp.array(dtype=vec),
        displacement_before: wp.array(dtype=vec),
        displacement: wp.array(dtype=vec),
        # State in and out:
        velocity: wp.array(dtype=vec),
        pressed: wp.array(dtype=wp.float64),
        struck: wp.array(dtype=wp.float64),
        held: wp.array(dtype=wp.float64),
    ):
        """What a step has done to the particles of a marker.

        The impulses of the step that its forces do not hold, those of collisions, change velocities at once; a support
        takes them up where it holds. The works are those of the forces, and of collisions on free and on held axes.
        """
        j = wp.tid()
        part = wp.float64(1.0) / wp.float64(first[j + 1] - first[j])
        pushed = vec64()
        for m in range(first[j], first[j + 1]):
            pushed += dt[0] * vec64(external[members[m]])
        rest = impulse[j] - impulse_before[j] - pushed
        for m in range(first[j], first[j + 1]):
            i = members[m]
            before = velocity[i]
            jump = vec64(free[i]) * wp.float64(part / mass[i])
            after = vec(vec64(before) + wp.cw_mul(jump, rest))
            velocity[i] = after
            moved = vec64(displacement[i]) - vec64(displacement_before[i])
            mean = wp.float64(0.5) * part * wp.cw_mul(rest, vec64(before) + vec64(after))
            pressed[j] = pressed[j] + wp.dot(vec64(external[i]), moved)
            on_free = wp.dot(vec64(free[i]), mean)
            struck[j] = struck[j] + on_free
            for axis in range(wp.static(d)):
                held[j] = held[j] + (wp.float64(1.0) - wp.float64(free[i][axis])) * mean[axis]

    @types.kernel(METHOD)
    def load(
        # State in:
        external: wp.array(dtype=vec),
        # State in and out:
        carried: wp.array(dtype=vec),
        force: wp.array(dtype=vec),
    ):
        """Replace the external force that a total force carries by another, before a step begins with it."""
        i = wp.tid()
        force[i] = force[i] + (external[i] - carried[i])
        carried[i] = external[i]

    return SimpleNamespace(show=show, accelerate=accelerate, share=share, receive=receive, load=load)
