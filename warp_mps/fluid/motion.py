"""Motion of fluid particles: the predictor, collisions, shifting, and the clock of adaptive steps.

A step goes u* = u + dt (viscosity + g), x* = x + dt u*, then by the pressure u = u* + du, x = x* + dt du. Two particles
closer than `COLLISION` that approach each other collide, which the pressure alone does not prevent in violent flow.
Where pressures may be negative, or gradients are not repulsive, particles are shifted against the gradient of their
concentration (Lind, Xu, Stansby & Rogers 2012), away from the free surface. Where streams part, a lattice is drawn out
to rows with voids between them: shifts have to be as large as the strain of a step, or the voids grow. Collisions take
energy, and are frequent in flows that shear; what is kept apart otherwise, by shifts or by repulsive gradients, only
collides below `KEPT_APART`, but with walls, between whose particles it would slip through.

Where water does not slip, viscosity sees inside a wall the velocity u_w + (u_w - u), u that of the water about there,
so that the water has the wall's velocity u_w at the wall's face (Adami, Hu & Adams 2012).

References:
    Adami, S., Hu, X. Y. and Adams, N. A., Journal of Computational Physics 231 (2012) 7057.
    Koshizuka, S. and Oka, Y., Nuclear Science and Engineering 123 (1996) 421.
    Lind, S. J., Xu, R., Stansby, P. K. and Rogers, B. D., Journal of Computational Physics 231 (2012) 1499.
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.periodic import displacement_function
from warp_mps.core.types import NumericTypes
from warp_mps.core.weights import weight_function
from warp_mps.fluid.lists import METHOD

# distances below which particles collide [l0], the second of what is kept apart otherwise; coefficient of restitution
COLLISION, KEPT_APART, RESTITUTION = 0.8, 0.5, 0.2
# closest distance that a shift sees [l0]
CLOSEST = 0.05
# shift per gradient of the concentration and way of the fastest particle in a step, and the largest shift [l0]
SHIFT, LARGEST_SHIFT = 10.0, 0.2


@functools.cache
def motion_kernels(types: NumericTypes) -> SimpleNamespace:
    """The kernels of the motion, in the order of a step from `mirror` to `finish`, and `fastest`, `plan` and `tick`."""
    real, vec, d = types.real, types.vec, types.dimension
    vec64 = wp.types.vector(length=d, dtype=wp.float64)
    displacement, weight = displacement_function(types), weight_function(types)

    @types.func(METHOD)
    def bounce(x_ij: vec, u_ij: vec, reach: real) -> vec:
        """Change of the velocity of i, as if j were fixed, when the two collide."""
        square = wp.dot(x_ij, x_ij)
        if square >= reach * reach or square == real(0.0):
            return vec()
        r = wp.sqrt(square)
        approach = wp.min(wp.dot(u_ij, x_ij) / r, real(0.0))
        return (real(wp.static(1.0 + RESTITUTION)) * approach / r) * x_ij

    @types.func(METHOD)
    def closest(shift_i: vec, shift_j: vec, reach: real, spacing: real) -> real:
        """Distance below which two particles collide: the reach, or less where both are shifted."""
        if wp.dot(shift_i, shift_i) * wp.dot(shift_j, shift_j) > real(0.0):
            return real(KEPT_APART) * spacing
        return reach

    @types.kernel(METHOD)
    def mirror(
        # Model:
        period: vec,
        radius: real,
        sticks: wp.array(dtype=wp.int32),
        listed: wp.array(dtype=wp.int32, ndim=2),
        count: wp.array(dtype=wp.int32),
        # State in:
        x: wp.array(dtype=vec),
        u: wp.array(dtype=vec),
        lost: wp.array(dtype=wp.int32),
        # Out:
        mirrored_out: wp.array(dtype=vec),
    ):
        """Velocity that the viscosity of the water sees at a wall's particle."""
        j = wp.tid()
        u_j = u[j]
        total = vec()
        weights = real(0.0)
        if sticks[j] == 1:
            for m in range(count[j]):
                i = listed[j, m]
                w = real(1 - lost[i]) * weight(wp.length(displacement(x[i], x[j], period)), radius)
                total += w * (u_j - u[i])
                weights += w
        if weights > real(0.0):
            u_j += total / weights
        mirrored_out[j] = u_j

    @types.kernel(METHOD)
    def viscosity(
        # Model:
        walls: wp.int32,
        period: vec,
        radius: real,
        factor: real,
        sticks: wp.array(dtype=wp.int32),
        listed: wp.array(dtype=wp.int32, ndim=2),
        count: wp.array(dtype=wp.int32),
        # State in:
        x: wp.array(dtype=vec),
        u: wp.array(dtype=vec),
        lost: wp.array(dtype=wp.int32),
        mirrored: wp.array(dtype=vec),
        # Out:
        acceleration_out: wp.array(dtype=vec),
    ):
        """Viscous acceleration nu lap u, of walls and fluid alike; walls without slip hold the fluid back."""
        i = wp.tid()
        x_i = x[i]
        u_i = u[i]
        if i < walls:
            u_i = mirrored[i]
        total = vec()
        for m in range(count[i]):
            j = listed[i, m]
            if sticks[i] + sticks[j] == 2 and lost[j] == 0:
                u_j = u[j]
                if j < walls:
                    u_j = mirrored[j]
                total += weight(wp.length(displacement(x_i, x[j], period)), radius) * (u_j - u_i)
        acceleration_out[i] = factor * total

    @types.kernel(METHOD)
    def predict(
        # Model:
        walls: wp.int32,
        gravity: vec,
        mass: wp.float64,
        # State in:
        dt: wp.array(dtype=wp.float64),
        acceleration: wp.array(dtype=vec),
        lost: wp.array(dtype=wp.int32),
        # State out:
        x_out: wp.array(dtype=vec),
        u_out: wp.array(dtype=vec),
        impulse_out: wp.array(dtype=vec64),
        work_out: wp.array(dtype=wp.float64),
    ):
        """The predictor of the fluid, and the viscous impulse on the walls, with their work."""
        i = wp.tid()
        h = real(dt[0])
        if i < walls:
            gained = (mass * dt[0]) * vec64(acceleration[i])
            impulse_out[i] = impulse_out[i] + gained
            work_out[i] = work_out[i] - wp.dot(gained, vec64(u_out[i]))
        elif lost[i] == 0:
            u = u_out[i] + h * (gravity + acceleration[i])
            u_out[i] = u
            x_out[i] = x_out[i] + h * u

    @types.kernel(METHOD)
    def apply(
        # Model:
        walls: wp.int32,
        # State in:
        dt: wp.array(dtype=wp.float64),
        du: wp.array(dtype=vec),
        # State out:
        x_out: wp.array(dtype=vec),
        u_out: wp.array(dtype=vec),
    ):
        """Change the velocities of the fluid, and its positions with them."""
        k = wp.tid()
        i = k + walls
        u_out[i] = u_out[i] + du[k]
        x_out[i] = x_out[i] + real(dt[0]) * du[k]

    @types.kernel(METHOD)
    def collide(
        # Model:
        walls: wp.int32,
        period: vec,
        spacing: real,
        reach: real,
        firmness: wp.array(dtype=real),
        listed: wp.array(dtype=wp.int32, ndim=2),
        count: wp.array(dtype=wp.int32),
        # State in:
        x: wp.array(dtype=vec),
        u: wp.array(dtype=vec),
        shift: wp.array(dtype=vec),
        # Out:
        du_out: wp.array(dtype=vec),
    ):
        """Change of a fluid particle's velocity by collisions."""
        k = wp.tid()
        i = k + walls
        x_i = x[i]
        u_i = u[i]
        du = vec()
        for m in range(count[i]):
            j = listed[i, m]
            x_ij = displacement(x_i, x[j], period)
            if j < walls:
                du += firmness[j] * bounce(x_ij, u[j] - u_i, real(COLLISION) * spacing)
            else:
                du += real(0.5) * bounce(x_ij, u[j] - u_i, closest(shift[k], shift[j - walls], reach, spacing))
        du_out[k] = du

    @types.kernel(METHOD)
    def move_apart(
        # Model:
        walls: wp.int32,
        period: vec,
        radius: real,
        spacing: real,
        n0: real,
        listed: wp.array(dtype=wp.int32, ndim=2),
        count: wp.array(dtype=wp.int32),
        # State in:
        x: wp.array(dtype=vec),
        way: wp.array(dtype=wp.float64),
        surface: wp.array(dtype=wp.int32),
        # Out:
        shift_out: wp.array(dtype=vec),
    ):
        """Shift of a fluid particle."""
        k = wp.tid()
        i = k + walls
        x_i = x[i]
        slope = vec()
        inside = surface[k] == 0
        for m in range(count[i]):
            j = listed[i, m]
            x_ij = displacement(x_i, x[j], period)
            square = wp.dot(x_ij, x_ij)
            if square < radius * radius:
                r = wp.max(wp.sqrt(square), real(CLOSEST) * spacing)
                w = weight(r, radius) / r
                slope += (w / n0) * x_ij
                if j >= walls:
                    inside = inside and surface[j - walls] == 0
        shift = vec()
        if inside:
            shift = (real(-SHIFT) * real(way[0])) * slope
            length = wp.length(shift)
            if length > real(LARGEST_SHIFT) * spacing:
                shift = (real(LARGEST_SHIFT) * spacing / length) * shift
        shift_out[k] = shift

    @types.kernel(METHOD)
    def collide_walls(
        # Model:
        period: vec,
        spacing: real,
        mass: real,
        firmness: wp.array(dtype=real),
        listed: wp.array(dtype=wp.int32, ndim=2),
        count: wp.array(dtype=wp.int32),
        # State in:
        x: wp.array(dtype=vec),
        u: wp.array(dtype=vec),
        # State in and out:
        impulse: wp.array(dtype=vec64),
        work: wp.array(dtype=wp.float64),
    ):
        """Impulse on a wall's particle by collisions, and the wall's work."""
        j = wp.tid()
        total = vec()
        for m in range(count[j]):
            i = listed[j, m]
            total += bounce(displacement(x[i], x[j], period), u[j] - u[i], real(COLLISION) * spacing)
        gained = -wp.float64(mass) * wp.float64(firmness[j]) * vec64(total)
        impulse[j] = impulse[j] + gained
        work[j] = work[j] - wp.dot(gained, vec64(u[j]))

    @types.kernel(METHOD)
    def finish(
        # Model:
        walls: wp.int32,
        low: vec,
        high: vec,
        period: vec,
        gravity: vec,
        # State in:
        dt: wp.array(dtype=wp.float64),
        du: wp.array(dtype=vec),
        shift: wp.array(dtype=vec),
        # State out:
        x_out: wp.array(dtype=vec),
        u_out: wp.array(dtype=vec),
        lost_out: wp.array(dtype=wp.int32),
        stale_out: wp.array(dtype=wp.int32),
        fallen_out: wp.array(dtype=wp.float64),
    ):
        """End a step: collisions and shifts, periods, and particles that have left the domain and the lists."""
        k = wp.tid()
        i = k + walls
        if lost_out[i] == 1:
            return
        u = u_out[i] + du[k]
        x = x_out[i] + real(dt[0]) * du[k] + shift[k]
        for axis in range(wp.static(d)):
            if period[axis] > real(0.0):
                gone = period[axis] * wp.floor((x[axis] - low[axis]) / period[axis])
                if gone != real(0.0):
                    x[axis] = x[axis] - gone
                    fallen_out[k] = fallen_out[k] + wp.float64(gravity[axis] * gone)
            elif not (x[axis] >= low[axis] and x[axis] <= high[axis]):
                lost_out[i] = 1
        if lost_out[i] == 1:
            u = vec()
            stale_out[0] = 1
        x_out[i] = x
        u_out[i] = u

    @types.kernel(METHOD)
    def fastest(chunk: wp.int32, u: wp.array(dtype=vec), fastest_out: wp.array(dtype=real)):
        """Square of the largest speed of each chunk of particles."""
        c = wp.tid()
        value = real(0.0)
        for i in range(c * chunk, wp.min((c + 1) * chunk, u.shape[0])):
            value = wp.max(value, wp.dot(u[i], u[i]))
        fastest_out[c] = value

    @types.kernel(METHOD)
    def plan(
        # Model:
        limit: wp.float64,
        reach: wp.float64,
        # State in:
        fastest: wp.array(dtype=real),
        target: wp.array(dtype=wp.float64),
        time: wp.array(dtype=wp.float64),
        # Out:
        dt_out: wp.array(dtype=wp.float64),
        way_out: wp.array(dtype=wp.float64),
        left_out: wp.array(dtype=wp.int32),
        time_after_out: wp.array(dtype=wp.float64),
    ):
        """The next step, one of equal ones up to the target time, and the way of the fastest particle in it."""
        square = real(0.0)
        for c in range(fastest.shape[0]):
            square = wp.max(square, fastest[c])
        longest = wp.min(limit, reach / wp.max(wp.sqrt(wp.float64(square)), wp.float64(1.0e-30)))
        rest = target[0] - time[0]
        steps = wp.max(wp.ceil(rest / longest - wp.float64(1.0e-9)), wp.float64(1.0))
        dt_out[0] = rest / steps
        way_out[0] = rest / steps * wp.sqrt(wp.float64(square))
        left_out[0] = wp.int32(wp.min(steps, wp.float64(1.0e9)))
        if steps == wp.float64(1.0):
            time_after_out[0] = target[0]
        else:
            time_after_out[0] = time[0] + rest / steps

    @types.kernel(METHOD)
    def tick(
        # State in:
        time_after: wp.array(dtype=wp.float64),
        # State out:
        time_out: wp.array(dtype=wp.float64),
        steps_out: wp.array(dtype=wp.int32),
    ):
        """Count a step."""
        time_out[0] = time_after[0]
        steps_out[0] = steps_out[0] + 1

    return SimpleNamespace(
        mirror=mirror, viscosity=viscosity, predict=predict, apply=apply, collide=collide, move_apart=move_apart,
        collide_walls=collide_walls, finish=finish, fastest=fastest, plan=plan, tick=tick,
    )  # fmt: skip
