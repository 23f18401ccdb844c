"""Kernels of the exchange between water and elastic bodies.

The water sees a body as a wall of markers (`warp_mps.coupling.interface`). The pressure Poisson equation sees a marker
j by its acceleration a_j alone (`warp_mps.fluid.pressure.rows`): as -rho sum_j c a_j . x_ij on the right-hand side of a
fluid particle i, c = laplacian * w; beside a flat face x_ij stands for x_ij - tilt_i, here and in what follows. How a_j
answers to pressure is approximated by a mobility b_j, acceleration per force, with the forces V sum_l c p_l x_lj, which
in a half-space are those of `warp_mps.fluid.gradient`: the matrix gets rho V sum_j b_j (c x_ij) . sum_l c p_l x_lj,
symmetric and positive, and what it adds is gone where the iteration over both has converged (a Robin condition; Badia,
Nobile and Vergara 2008).

References:
    Badia, S., Nobile, F. and Vergara, C., Journal of Computational Physics 227 (2008) 7027.
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_mps.core.linear.kernels import RESTART
from warp_mps.core.periodic import displacement_function
from warp_mps.core.types import NumericTypes
from warp_mps.core.weights import weight_function
from warp_mps.fluid.pressure.rows import CLOSEST

METHOD = "coupling"


@functools.cache
def coupling_kernels(types: NumericTypes) -> SimpleNamespace:
    """Kernels `find_wet`, `stiffen`, `respond`, `answer`, `couple` and `couple_product`."""
    real, vec = types.real, types.vec
    displacement, weight = displacement_function(types), weight_function(types)

    @types.func(METHOD)
    def arm(x_i: vec, x_j: vec, tilt: vec, period: vec, radius: real, spacing: real, laplacian: real) -> vec:
        """The arm x_ij - tilt_i times c."""
        x_ij = displacement(x_i, x_j, period)
        square = wp.dot(x_ij, x_ij)
        if square >= radius * radius:
            return vec()
        r = wp.max(wp.sqrt(square), real(CLOSEST) * spacing)
        return (laplacian * weight(r, radius)) * (x_ij - tilt)

    @types.kernel(METHOD)
    def find_wet(
        # Model:
        walls: wp.int32,
        markers: wp.int32,
        listed: wp.array(dtype=wp.int32, ndim=2),
        count: wp.array(dtype=wp.int32),
        # Out:
        wet_out: wp.array(dtype=wp.int32),
    ):
        """Whether a fluid particle has a marker among its neighbours: the others are passed over in every product."""
        k = wp.tid()
        i = k + walls
        found = wp.int32(0)
        for m in range(count[i]):
            if listed[i, m] < markers:
                found = 1
        wet_out[k] = found

    @types.kernel(METHOD)
    def stiffen(
        # Model:
        walls: wp.int32,
        markers: wp.int32,
        period: vec,
        radius: real,
        spacing: real,
        laplacian: real,
        density: real,
        volume: real,
        listed: wp.array(dtype=wp.int32, ndim=2),
        count: wp.array(dtype=wp.int32),
        wet: wp.array(dtype=wp.int32),
        mobility: wp.array(dtype=real),
        # State in:
        x: wp.array(dtype=vec),
        tilt: wp.array(dtype=vec),
        # State in and out:
        diagonal: wp.array(dtype=real),
        # Out:
        own_out: wp.array(dtype=real),
    ):
        """The diagonal of the markers' answer, added to that of the matrix."""
        k = wp.tid()
        if wet[k] == 0:
            return
        i = k + walls
        x_i = x[i]
        total = real(0.0)
        for m in range(count[i]):
            j = listed[i, m]
            if j < markers:
                c = arm(x_i, x[j], tilt[k], period, radius, spacing, laplacian)
                total += mobility[j] * wp.dot(c, c)
        own_out[k] = density * volume * total
        diagonal[k] = diagonal[k] + density * volume * total

    @types.kernel(METHOD)
    def respond(
        # Model:
        walls: wp.int32,
        period: vec,
        radius: real,
        spacing: real,
        laplacian: real,
        volume: real,
        listed: wp.array(dtype=wp.int32, ndim=2),
        count: wp.array(dtype=wp.int32),
        # State in:
        control: wp.array(dtype=wp.int32),
        x: wp.array(dtype=vec),
        tilt: wp.array(dtype=vec),
        p: wp.array(dtype=wp.float64),
        direction: wp.array(dtype=wp.float64),
        # Out:
        force_out: wp.array(dtype=vec),
    ):
        """Approximate force on a marker: of pressures in a fresh pass of the solver, else of a search direction."""
        j = wp.tid()
        x_j = x[j]
        total = vec()
        for m in range(count[j]):
            i = listed[j, m]
            value = direction[i - walls]
            if control[RESTART] != 0:
                value = p[i - walls]
            total += real(value) * arm(x[i], x_j, tilt[i - walls], period, radius, spacing, laplacian)
        force_out[j] = volume * total

    @types.kernel(METHOD)
    def answer(
        # State in:
        mobility: wp.array(dtype=real),
        force: wp.array(dtype=vec),
        a: wp.array(dtype=vec),
        # Out:
        answer_out: wp.array(dtype=vec),
    ):
        """Part of the markers' accelerations that the matrix answers for, less the accelerations."""
        j = wp.tid()
        answer_out[j] = mobility[j] * force[j] - a[j]

    @types.kernel(METHOD)
    def couple(
        # Model:
        walls: wp.int32,
        markers: wp.int32,
        period: vec,
        radius: real,
        spacing: real,
        laplacian: real,
        density: real,
        listed: wp.array(dtype=wp.int32, ndim=2),
        count: wp.array(dtype=wp.int32),
        wet: wp.array(dtype=wp.int32),
        # State in:
        x: wp.array(dtype=vec),
        tilt: wp.array(dtype=vec),
        answer: wp.array(dtype=vec),
        # State in and out:
        rhs: wp.array(dtype=wp.float64),
    ):
        """Add what accelerations of the markers do to the rows of the fluid about them."""
        k = wp.tid()
        if wet[k] == 0:
            return
        i = k + walls
        x_i = x[i]
        total = real(0.0)
        for m in range(count[i]):
            j = listed[i, m]
            if j < markers:
                total += wp.dot(arm(x_i, x[j], tilt[k], period, radius, spacing, laplacian), answer[j])
        rhs[k] = rhs[k] + wp.float64(density * total)

    @types.kernel(METHOD)
    def couple_product(
        # Model:
        walls: wp.int32,
        markers: wp.int32,
        period: vec,
        radius: real,
        spacing: real,
        laplacian: real,
        density: real,
        listed: wp.array(dtype=wp.int32, ndim=2),
        count: wp.array(dtype=wp.int32),
        wet: wp.array(dtype=wp.int32),
        own: wp.array(dtype=real),
        mobility: wp.array(dtype=real),
        # State in:
        control: wp.array(dtype=wp.int32),
        x: wp.array(dtype=vec),
        tilt: wp.array(dtype=vec),
        force: wp.array(dtype=vec),
        p: wp.array(dtype=wp.float64),
        direction: wp.array(dtype=wp.float64),
        # State in and out:
        q: wp.array(dtype=wp.float64),
    ):
        """Add the markers' answer to a product with the matrix, whose diagonal holds it already."""
        k = wp.tid()
        if wet[k] == 0:
            return
        i = k + walls
        x_i = x[i]
        total = real(0.0)
        for m in range(count[i]):
            j = listed[i, m]
            if j < markers:
                total += mobility[j] * wp.dot(arm(x_i, x[j], tilt[k], period, radius, spacing, laplacian), force[j])
        value = direction[k]
        if control[RESTART] != 0:
            value = p[k]
        q[k] = q[k] + wp.float64(density * total) - wp.float64(own[k]) * value

    return SimpleNamespace(
        find_wet=find_wet, stiffen=stiffen, respond=respond, answer=answer, couple=couple, couple_product=couple_product
    )
