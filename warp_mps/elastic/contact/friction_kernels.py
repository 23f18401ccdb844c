"""Coulomb friction of faces by central forces: it keeps angular momentum, and a rigid rotation causes none.

A particle i in contact with another body B has the pressing force N_iB = |g_iB grad q_iB| of its own potential, along
the normal n of grad q_iB (`warp_mps.elastic.contact.kernels`). With omega_ij = W_ij / sum_j W_ij, y_ij = x_i - x_j, its
part s_ij in the tangent plane, their mean and their covariance C over omega, friction is the pair force

    f_ij = omega_ij a . (s_ij - mean) y_ij,   a = C^-1 t,   whose sum over j is t, except for its part along n

Forces along y_ij have no moment: the couple of the friction between two layers of particles, a spacing apart, is
balanced by their pressure. The slip is the displacement that is conjugate to t,

    slip' = C^-1 sum_j omega_ij (s_ij - mean) (y_ij . y'_ij)

the sliding velocity where a face slides, and 0 in any common rotation. The faces stick by a spring, t = -k slip, as
stiff as the contact where it is pressed, k = c_iB min(E_i, E_B) (S_iB/l)^2. Where that exceeds mu N_iB, they slide, and
the spring is shortened to mu N_iB (Cundall and Strack). Sticking faces therefore do not creep, but yield by at most mu
times the penetration of the contact. A contact of single points has no spread C, and no friction.

References:
    Cundall, P. A. and Strack, O. D. L., Geotechnique 29 (1979) 47.
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.types import NumericTypes
from warp_mps.elastic import METHOD
from warp_mps.elastic.contact.kernels import contact_funcs

# least variance of the tangential distances for friction, in squares of half of the support; a lattice has 0.2
SPREAD = 0.1


@functools.cache
def friction_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `update_slip`, `add_friction` and `add_stored_energy`."""
    real, vec, mat = types.real, types.vec, types.mat
    funcs = contact_funcs(types)
    pair_support, weight, slope_ratio = funcs.pair_support, funcs.weight, funcs.slope_ratio

    @types.func(METHOD)
    def least_variance(c: mat, n: vec) -> real:
        """The smallest variance of C in the tangent plane."""
        half = real(0.5) * wp.trace(c)
        if wp.static(types.dimension == 2):
            return wp.trace(c)
        return half - wp.sqrt(wp.max(half * half - wp.determinant(c + wp.outer(n, n)), real(0.0)))

    @types.kernel(METHOD)
    def update_slip(
        # Model:
        per_thread: wp.int32,  # particles of one thread
        reference: wp.array(dtype=vec),  # reference positions X_i [m], [n]
        spacing: wp.array(dtype=real),  # particle spacings [m], [n]
        group: wp.array(dtype=wp.int32),  # group of bodies of each particle, [n]
        stiffness: wp.array(dtype=real),  # Young's moduli [Pa], [n]
        softest: wp.array(dtype=real),  # least modulus of each group [Pa], [groups]
        spring_stiffness: wp.array(dtype=real, ndim=2),  # k over the least modulus [m^(d-2)], [groups, groups]
        friction: wp.array(dtype=real, ndim=2),  # coefficients of friction of two groups [-], [groups, groups]
        start: wp.array(dtype=wp.int32),  # first place of each row of candidates, [n + 1]
        listed: wp.array(dtype=wp.int32),  # candidates, sorted by group, [entries]
        faces: wp.array(dtype=wp.int32),  # number of groups near each particle, [n]
        facing: wp.array(dtype=wp.int32, ndim=2),  # these groups, [n, faces]
        end: wp.array(dtype=wp.int32, ndim=2),  # one past the last candidate of each, [n, faces]
        # State in:
        u: wp.array(dtype=vec),  # displacements u [m], [n]
        u_before: wp.array(dtype=vec),  # displacements of the last step [m], [n]
        slope: wp.array(dtype=real, ndim=2),  # g_iB w_iB of each group [J], [n, faces]
        # State in and out:
        slip_group: wp.array(dtype=wp.int32, ndim=2),  # group + 1 of each slip, 0 for none, [n, faces]
        slip: wp.array(dtype=vec, ndim=2),  # slips [m], [n, faces]
        # State out:
        pull_out: wp.array(dtype=vec, ndim=2),  # a / sum_j W [N/m^2], [n, faces]
        mean_out: wp.array(dtype=real, ndim=2),  # a . mean / sum_j W [N/m], [n, faces]
        stored_out: wp.array(dtype=real),  # energies of the springs [J], [n]
    ):
        """Update the slip of every face, and find a / sum_j W and a . mean / sum_j W of its friction.

        The slip is advanced by slip' of the step, and shortened to mu N / k (return to the Coulomb limit).
        `slip_group` is the group + 1 that a slip belongs to, 0 for none: it outlives the list of candidates.
        """
        for i in range(wp.tid() * per_thread, wp.min((wp.tid() + 1) * per_thread, start.shape[0] - 1)):
            stored = real(0.0)
            k = start[i]
            for s in range(faces[i]):
                other = facing[i, s]
                first = k
                k = end[i, s]
                place = wp.int32(-1)
                for t in range(slip_group.shape[1]):
                    if slip_group[i, t] == other + 1:
                        place = t
                pull_out[i, s] = vec()
                mean_out[i, s] = real(0.0)
                limit = friction[group[i], other] * slope[i, s]
                if limit > real(0.0):
                    # the normal, and the pressing force
                    normal = vec()
                    for m in range(first, k):
                        j = listed[m]
                        support = pair_support(spacing[i], spacing[j])
                        y = reference[i] - reference[j] + (u[i] - u[j])
                        normal += (slope_ratio(wp.length(y) / support) / (support * support)) * y
                    size = wp.length(normal)
                    limit = limit * size
                    normal = normal / wp.max(size, real(1.0e-30))
                    # sums over the tangential distances, in units of half the support
                    total = real(0.0)
                    work = real(0.0)
                    mean = vec()
                    moved = vec()
                    spread = mat()
                    unit = real(1.0)
                    for m in range(first, k):
                        j = listed[m]
                        unit = real(0.5) * pair_support(spacing[i], spacing[j])
                        y = (reference[i] - reference[j] + (u[i] - u[j])) / unit
                        w = weight(real(0.5) * wp.length(y))
                        step = ((u[i] - u_before[i]) - (u[j] - u_before[j])) / unit
                        tangential = y - wp.dot(y, normal) * normal
                        # y . dy in the middle of the step: 0 in a rotation, however large
                        gone = w * wp.dot(y - real(0.5) * step, step)
                        total += w
                        work += gone
                        mean += w * tangential
                        moved += gone * tangential
                        spread += w * wp.outer(tangential, tangential)
                    mean = mean / total
                    moved = (moved - work * mean) / total
                    spread = spread / total - wp.outer(mean, mean)
                    short = wp.max(real(wp.static(SPREAD)) - least_variance(spread, normal), real(0.0))
                    inverse = wp.inverse(
                        spread
                        + wp.outer(normal, normal)
                        + short * wp.identity(n=wp.static(types.dimension), dtype=real)
                    )
                    x = unit * (inverse * moved)
                    if place >= 0:
                        x += slip[i, place]
                    x -= wp.dot(x, normal) * normal
                    spring = spring_stiffness[group[i], other] * wp.min(stiffness[i], softest[other])
                    far = spring * wp.length(x)
                    if far > limit:
                        x = (limit / far) * x
                    a = (-spring / (total * unit)) * (inverse * x)
                    pull_out[i, s] = a / unit
                    mean_out[i, s] = wp.dot(a, mean)
                    stored += real(0.5) * spring * wp.dot(x, x)
                    for t in range(slip_group.shape[1]):
                        if place < 0 and slip_group[i, t] == 0:
                            place = t
                    slip_group[i, place] = other + 1
                    slip[i, place] = x
                elif place >= 0:
                    slip_group[i, place] = 0
            stored_out[i] = stored

    @types.kernel(METHOD)
    def add_friction(
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
        pull: wp.array(dtype=vec, ndim=2),  # a / sum_j W [N/m^2], [n, faces]
        mean: wp.array(dtype=real, ndim=2),  # a . mean / sum_j W [N/m], [n, faces]
        stored: wp.array(dtype=real),  # energies of the springs [J], [n]
        # State in and out:
        u_before: wp.array(dtype=vec),  # displacements of the last step [m], [n]
        stored_before: wp.array(dtype=real),  # energies of the springs at the last step [J], [n]
        friction_before: wp.array(dtype=vec),  # friction at the last step [N], [n]
        contact: wp.array(dtype=vec),  # contact forces [N], [n]
        force: wp.array(dtype=vec),  # total forces [N], [n]
        dissipated: wp.array(dtype=wp.float64),  # energy dissipated so far [J], [n]
    ):
        """Add the friction f_i = sum_j (f_ij - f_ji) to the contact forces, and the energy that it dissipates.

        That is its work less the energy that the springs store. The work is the mean of the forces at the two ends of a
        step times the displacement between them, which is the work in velocity Verlet.
        """
        for i in range(wp.tid() * per_thread, wp.min((wp.tid() + 1) * per_thread, start.shape[0] - 1)):
            total = vec()
            k = start[i]
            for s in range(faces[i]):
                for m in range(k, end[i, s]):
                    j = listed[m]
                    if stored[i] > real(0.0) or stored[j] > real(0.0):
                        y = reference[i] - reference[j] + (u[i] - u[j])
                        factor = wp.dot(pull[i, s], y) - mean[i, s]
                        for t in range(faces[j]):
                            if facing[j, t] == group[i]:
                                factor -= wp.dot(pull[j, t], y) + mean[j, t]
                        total += (weight(wp.length(y) / pair_support(spacing[i], spacing[j])) * factor) * y
                k = end[i, s]
            work = wp.float64(wp.dot(friction_before[i] + total, u[i] - u_before[i]))
            kept = wp.float64(stored[i]) - wp.float64(stored_before[i])
            dissipated[i] = dissipated[i] - wp.float64(0.5) * work - kept
            u_before[i] = u[i]
            stored_before[i] = stored[i]
            friction_before[i] = total
            contact[i] = contact[i] + total
            force[i] = force[i] + total

    @types.kernel(METHOD)
    def add_stored_energy(
        # State in:
        stored: wp.array(dtype=real),  # energies of the springs [J], [n]
        # State in and out:
        energy: wp.array(dtype=real),  # contact energies [J], [n]
    ):
        """Add the energy 1/2 k |slip|^2 of the springs of sticking faces."""
        i = wp.tid()
        energy[i] = energy[i] + stored[i]

    return SimpleNamespace(update_slip=update_slip, add_friction=add_friction, add_stored_energy=add_stored_energy)
