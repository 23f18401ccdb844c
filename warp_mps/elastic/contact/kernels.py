"""Contact: bodies touch at their faces, however the lattices that their particles lie on meet.

The measure of contact is not the distance of two particles but the contact density q_iB of a particle i in another body
B: a kernel sum over all of B's particles within two spacings (`warp_mps.elastic.contact.law`), normalized to 1 where
flat faces touch. The excess over 1 stores V_iB = 1/2 k_iB (q_iB - 1)^2. With g_iB = dV_iB/dq_iB and A the body of i,
the exact gradient is a pair force,

    f_ij = -(g_iB w_iB + g_jA w_jA) W'(|x_ij| / s) / s  (x_i - x_j) / |x_ij|

central, equal and opposite: momentum, angular momentum and energy are kept. "Body" is a group of bonded bodies here, or
a wall. Self-contact is that of a group with itself; it leaves out particles that were closer than two and a half
spacings in the reference configuration, and so the reference neighbours.

A step sums twice over the candidates: the contact density, then the forces. `slope` is g_iB w_iB, the derivative of
V_iB with respect to the kernel sum.
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.core.weights import wendland_functions
from warp_mps.elastic import METHOD
from warp_mps.elastic.contact.law import SUPPORT

# particles of one thread: on a CPU most have no candidates, and a loop is faster than a call
PARTICLES_PER_THREAD = {"cpu": 64, "cuda": 1}


@functools.cache
def contact_funcs(types: NumericTypes) -> SimpleNamespace:
    """Device functions `pair_support`, `weight` and `slope_ratio` of the law."""
    real = types.real

    @types.func(METHOD)
    def pair_support(a: real, b: real) -> real:
        """Support of the kernel for particles of two spacings: s = 2 max(a, b) [m]."""
        return real(wp.static(SUPPORT)) * wp.max(a, b)

    wendland = wendland_functions(types)
    return SimpleNamespace(
        pair_support=pair_support, weight=wendland.wendland_c2, slope_ratio=wendland.wendland_c2_slope_ratio
    )


@functools.cache
def contact_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `contact_density` and `force`."""
    real, vec = types.real, types.vec
    funcs = contact_funcs(types)
    pair_support, weight, slope_ratio = funcs.pair_support, funcs.weight, funcs.slope_ratio

    @types.kernel(METHOD)
    def contact_density(
        # Model:
        per_thread: wp.int32,  # particles of one thread
        reference: wp.array(dtype=vec),  # reference positions X_i [m], [n]
        spacing: wp.array(dtype=real),  # particle spacings [m], [n]
        group: wp.array(dtype=wp.int32),  # group of bodies of each particle, [n]
        stiffness: wp.array(dtype=real),  # Young's moduli [Pa], [n]
        softest: wp.array(dtype=real),  # least modulus of each group [Pa], [groups]
        weights: wp.array(dtype=real, ndim=2),  # w of two groups [-], [groups, groups]
        scales: wp.array(dtype=real, ndim=2),  # k over the least modulus [m^d], [groups, groups]
        start: wp.array(dtype=wp.int32),  # first place of each row of candidates, [n + 1]
        listed: wp.array(dtype=wp.int32),  # candidates, sorted by group, [entries]
        faces: wp.array(dtype=wp.int32),  # number of groups near each particle, [n]
        facing: wp.array(dtype=wp.int32, ndim=2),  # these groups, [n, faces]
        end: wp.array(dtype=wp.int32, ndim=2),  # one past the last candidate of each, [n, faces]
        # State in:
        u: wp.array(dtype=vec),  # displacements u [m], [n]
        # State out:
        slope_out: wp.array(dtype=real, ndim=2),  # g_iB w_iB of each group [J], [n, faces]
        energy_out: wp.array(dtype=real),  # contact energies [J], [n]
    ):
        """g_iB w_iB of every group B that a particle faces, and the energy sum_B 1/2 g_iB (q_iB - 1)."""
        for i in range(wp.tid() * per_thread, wp.min((wp.tid() + 1) * per_thread, start.shape[0] - 1)):
            k = start[i]
            total = real(0.0)
            for s in range(faces[i]):
                other = facing[i, s]
                q = real(0.0)
                for m in range(k, end[i, s]):
                    j = listed[m]
                    r = wp.length(reference[j] - reference[i] + (u[j] - u[i]))
                    q += weight(r / pair_support(spacing[i], spacing[j]))
                k = end[i, s]
                w = weights[group[i], other]
                beyond = wp.max(w * q - real(1.0), real(0.0))
                g = real(0.0)
                if beyond > real(0.0):
                    g = scales[group[i], other] * wp.min(stiffness[i], softest[other]) * beyond
                slope_out[i, s] = g * w
                total += real(0.5) * g * beyond
            energy_out[i] = total

    @types.kernel(METHOD)
    def force(
        # Model:
        per_thread: wp.int32,  # particles of one thread
        reference: wp.array(dtype=vec),  # reference positions X_i [m], [n]
        spacing: wp.array(dtype=real),  # particle spacings [m], [n]
        group: wp.array(dtype=wp.int32),  # group of bodies of each particle, [n]
        start: wp.array(dtype=wp.int32),  # first place of each row of candidates, [n + 1]
        listed: wp.array(dtype=wp.int32),  # candidates, sorted by group, [entries]
        faces: wp.array(dtype=wp.int32),  # number of groups near each particle, [n]
        facing: wp.array(dtype=wp.int32, ndim=2),  # these groups, [n, faces]
        end: wp.array(dtype=wp.int32, ndim=2),  # one past the last candidate of each, [n, faces]
        # State in:
        u: wp.array(dtype=vec),  # displacements u [m], [n]
        slope: wp.array(dtype=real, ndim=2),  # g_iB w_iB of each group [J], [n, faces]
        stored: wp.array(dtype=real),  # contact energies [J], [n]
        # State in and out:
        total_force: wp.array(dtype=vec),  # total forces [N], [n]
        # State out:
        contact_out: wp.array(dtype=vec),  # contact forces [N], [n]
    ):
        """Contact force sum_j f_ij of a particle, also added to its total force."""
        for i in range(wp.tid() * per_thread, wp.min((wp.tid() + 1) * per_thread, start.shape[0] - 1)):
            n = faces[i]
            total = vec()
            k = start[i]
            for s in range(n):
                for m in range(k, end[i, s]):
                    j = listed[m]
                    both = slope[i, s]
                    # most candidates have no contact energy
                    if stored[j] > real(0.0):
                        for t in range(faces[j]):
                            if facing[j, t] == group[i]:
                                both += slope[j, t]
                    if both > real(0.0):
                        support = pair_support(spacing[i], spacing[j])
                        x = reference[j] - reference[i] + (u[j] - u[i])
                        total -= (both * slope_ratio(wp.length(x) / support) / (support * support)) * x
                k = end[i, s]
            contact_out[i] = total
            if n > 0:
                total_force[i] = total_force[i] + total

    return SimpleNamespace(contact_density=contact_density, force=force)
