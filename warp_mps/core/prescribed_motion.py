"""Prescribed motion on the device: value, rate and second derivative of a harmonic motion or of a table.

The harmonic motion starts at 0, with amplitude A, frequency f and phase p:

    x(t) = A [sin(2 pi f t + p) - sin(p)]

Between two rows x_0 and x_1 of a table, an interval h apart, with s from 0 to 1 over it, the linear interpolation is
x = x_0 + s (x_1 - x_0). The cubic one is Hermite's, with the slopes m_0 and m_1 at the rows times h:

    x = x_0 + s^2 (3 - 2 s) (x_1 - x_0) + s (1 - s) ((1 - s) m_0 - s m_1)

Outside the table the value is that of its first or last row. `warp_mps.scene.spline` computes the slopes, and evaluates
the same tables on the host.

References:
    de Boor, C., A Practical Guide to Splines, Springer (1978), chapter IV.
"""

import functools
from types import SimpleNamespace
from typing import Any

import warp as wp


@functools.cache
def prescribed_motion_functions(real: Any, vec: Any, module: str) -> SimpleNamespace:
    """Device functions `harmonic_motion` and `table_motion`; each returns a value, its rate and second derivative.

    Args:
        real: Scalar type of the motion.
        vec: Vector type of the motion. Times, frequencies and phases are float64 whatever the type.
        module: Name of the Warp module of the kernels that call them.
    """

    @wp.func(module=module)
    def harmonic_motion(t: wp.float64, amplitude: vec, frequency: wp.float64, phase: wp.float64):
        """A [sin(2 pi f t + p) - sin(p)] and its derivatives in time."""
        omega = wp.float64(wp.TAU) * frequency
        angle = omega * t + phase
        value = real(wp.sin(angle) - wp.sin(phase)) * amplitude
        rate = real(omega * wp.cos(angle)) * amplitude
        second = real(-omega * omega * wp.sin(angle)) * amplitude
        return value, rate, second

    @wp.func(module=module)
    def cubic_value(s: real, step: vec, m_0: vec, m_1: vec) -> vec:
        """X - x_0 of Hermite's cubic, for a step x_1 - x_0."""
        rest = real(1.0) - s
        return (s * s * (real(3.0) - real(2.0) * s)) * step + (s * rest) * (rest * m_0 - s * m_1)

    @wp.func(module=module)
    def cubic_rate(s: real, step: vec, m_0: vec, m_1: vec) -> vec:
        """dx/ds of Hermite's cubic."""
        quadratic = real(6.0) * step - real(4.0) * m_0 - real(2.0) * m_1
        cubic = m_0 + m_1 - real(2.0) * step
        return m_0 + s * quadratic + (real(3.0) * s * s) * cubic

    @wp.func(module=module)
    def cubic_second(s: real, step: vec, m_0: vec, m_1: vec) -> vec:
        """d2x/ds2 of Hermite's cubic."""
        quadratic = real(6.0) * step - real(4.0) * m_0 - real(2.0) * m_1
        cubic = m_0 + m_1 - real(2.0) * step
        return quadratic + (real(6.0) * s) * cubic

    @wp.func(module=module)
    def table_motion(
        t: wp.float64,
        first: wp.int32,
        last: wp.int32,
        times: wp.array(dtype=wp.float64),
        rows: wp.array(dtype=vec),
        slopes: wp.array(dtype=vec),
        cubic: wp.int32,
    ):
        """The table of rows `first` to `last`, inclusive, and its derivatives; linear where `cubic` is 0."""
        k = wp.clamp(wp.lower_bound(times, first, last + 1, t), first + 1, last)
        span = times[k] - times[k - 1]
        s = real(wp.clamp((t - times[k - 1]) / span, wp.float64(0.0), wp.float64(1.0)))
        h = real(span)
        inside = t >= times[first] and t < times[last]
        step = rows[k] - rows[k - 1]
        value = vec()
        rate = vec()
        second = vec()
        if cubic == 0:
            value = rows[k - 1] + s * step
            if inside:
                rate = step / h
        else:
            m_0 = h * slopes[k - 1]
            m_1 = h * slopes[k]
            value = rows[k - 1] + cubic_value(s, step, m_0, m_1)
            if inside:
                rate = cubic_rate(s, step, m_0, m_1) / h
                second = cubic_second(s, step, m_0, m_1) / (h * h)
        return value, rate, second

    return SimpleNamespace(harmonic_motion=harmonic_motion, table_motion=table_motion)
