"""Contact: particles that are not neighbours in the reference configuration repel each other below their spacing.

The repulsion is the gradient of the potential 1/2 k (d - |x_ij|)^2 of each pair closer than d, the mean of the two
spacings: central, equal and opposite, energy kept. Candidates are found with `wp.HashGrid` a little beyond d and are
listed; the list is renewed, inside the replayed step, when a particle has moved half of that margin.
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.kit import Kit

METHOD = "elastic"
# margin of the candidate list beyond the contact distance, in units of the smallest spacing
SKIN = 0.35
# a particle of a lattice surface meets few others; the list says so when this is not enough
CANDIDATES = {2: 12, 3: 32}


@functools.cache
def contact_kernels(kit: Kit) -> SimpleNamespace:
    """Kernels `locate`, `candidates`, `force` and `energy`."""
    real, vec, vec3 = kit.real, kit.vec, kit.vec3

    @kit.func(METHOD)
    def repulsion(r: real, distance: real, k: real) -> real:
        """Magnitude of the force of a pair at a distance r."""
        return k * wp.max(distance - r, real(0.0))

    @kit.kernel(METHOD)
    def locate(
        # Model:
        reference: wp.array(dtype=vec),
        margin: real,
        # State in:
        u: wp.array(dtype=vec),
        u_listed: wp.array(dtype=vec),
        # Out:
        points_out: wp.array(dtype=vec3),
        stale_out: wp.array(dtype=wp.int32),
    ):
        """Positions for the grid, and whether any particle has moved by half of the margin since the last list."""
        i = wp.tid()
        x = reference[i] + u[i]
        point = vec3()
        for axis in range(wp.static(kit.dimension)):
            point[axis] = x[axis]
        points_out[i] = point
        moved = u[i] - u_listed[i]
        if wp.dot(moved, moved) > real(0.25) * margin * margin:
            stale_out[0] = 1

    @kit.kernel(METHOD)
    def candidates(
        # Model:
        grid: wp.uint64,
        reach: real,
        margin: real,
        spacing: wp.array(dtype=real),
        reference: wp.array(dtype=vec),
        group: wp.array(dtype=wp.int32),
        neighbour_radius: wp.array(dtype=real),
        within_group: wp.int32,
        # State in:
        points: wp.array(dtype=vec3),
        u: wp.array(dtype=vec),
        # Out:
        listed_out: wp.array(dtype=wp.int32, ndim=2),
        count_out: wp.array(dtype=wp.int32),
        u_listed_out: wp.array(dtype=vec),
        stale_out: wp.array(dtype=wp.int32),
        overflow_out: wp.array(dtype=wp.int32),
    ):
        """List what could come into contact, sorted, so that sums do not depend on when the list was made."""
        i = wp.tid()
        capacity = listed_out.shape[1]
        n = wp.int32(0)
        for j in wp.hash_grid_query(grid, points[i], reach):
            near = j != i and wp.length(points[j] - points[i]) < real(0.5) * (spacing[i] + spacing[j]) + margin
            if near and group[i] == group[j]:
                bonded = wp.length(reference[j] - reference[i]) < wp.max(neighbour_radius[i], neighbour_radius[j])
                near = within_group == 1 and not bonded
            if near:
                if n < capacity:
                    k = n
                    while k > 0 and listed_out[i, wp.max(k - 1, 0)] > j:
                        listed_out[i, k] = listed_out[i, k - 1]
                        k -= 1
                    listed_out[i, k] = j
                    n += 1
                else:
                    overflow_out[0] = i + 1
        count_out[i] = n
        u_listed_out[i] = u[i]
        if i == 0:
            stale_out[0] = 0

    @kit.kernel(METHOD)
    def force(
        # Model:
        reference: wp.array(dtype=vec),
        spacing: wp.array(dtype=real),
        stiffness: wp.array(dtype=real),
        listed: wp.array(dtype=wp.int32, ndim=2),
        count: wp.array(dtype=wp.int32),
        # State in:
        u: wp.array(dtype=vec),
        # State out:
        contact_out: wp.array(dtype=vec),
        force_out: wp.array(dtype=vec),
    ):
        i = wp.tid()
        n = count[i]
        total = vec()
        if n > 0:
            x_i = reference[i] + u[i]
            for k in range(n):
                j = listed[i, k]
                x = reference[j] + u[j] - x_i
                r = wp.length(x)
                push = repulsion(r, real(0.5) * (spacing[i] + spacing[j]), wp.min(stiffness[i], stiffness[j]))
                if push > real(0.0):
                    total -= (push / wp.max(r, real(1.0e-30))) * x
            force_out[i] = force_out[i] + total
        contact_out[i] = total

    @kit.kernel(METHOD)
    def energy(
        # Model:
        reference: wp.array(dtype=vec),
        spacing: wp.array(dtype=real),
        stiffness: wp.array(dtype=real),
        listed: wp.array(dtype=wp.int32, ndim=2),
        count: wp.array(dtype=wp.int32),
        # State in:
        u: wp.array(dtype=vec),
        # Out:
        energy_out: wp.array(dtype=real),
    ):
        """Half of the potential of each of a particle's pairs."""
        i = wp.tid()
        total = real(0.0)
        for k in range(count[i]):
            j = listed[i, k]
            r = wp.length(reference[j] + u[j] - reference[i] - u[i])
            gap = wp.max(real(0.5) * (spacing[i] + spacing[j]) - r, real(0.0))
            total += real(0.25) * wp.min(stiffness[i], stiffness[j]) * gap * gap
        energy_out[i] = total

    return SimpleNamespace(locate=locate, candidates=candidates, force=force, energy=energy)
