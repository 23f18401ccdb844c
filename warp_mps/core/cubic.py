"""Hermite's cubic between two rows of a table: value, rate and second derivative on the device.

With s from 0 to 1 over an interval of length h, a step x_1 - x_0 and the slopes at its ends times h, m_0 and m_1,

    x - x_0 = s^2 (3 - 2 s) step + s (1 - s) ((1 - s) m_0 - s m_1)
"""

import functools
from typing import Any

import warp as wp


@functools.cache
def cubic_funcs(real: Any, vec: Any, module: str) -> tuple[Any, Any, Any]:
    """Device functions of s, step, m_0 and m_1: x - x_0, its derivative with respect to s, and the second one."""

    @wp.func(module=module)
    def cubic_value(s: real, step: vec, m_0: vec, m_1: vec) -> vec:
        rest = real(1.0) - s
        return (s * s * (real(3.0) - real(2.0) * s)) * step + (s * rest) * (rest * m_0 - s * m_1)

    @wp.func(module=module)
    def cubic_rate(s: real, step: vec, m_0: vec, m_1: vec) -> vec:
        turn = real(6.0) * step - real(4.0) * m_0 - real(2.0) * m_1
        bend = m_0 + m_1 - real(2.0) * step
        return m_0 + s * turn + (real(3.0) * s * s) * bend

    @wp.func(module=module)
    def cubic_second(s: real, step: vec, m_0: vec, m_1: vec) -> vec:
        turn = real(6.0) * step - real(4.0) * m_0 - real(2.0) * m_1
        bend = m_0 + m_1 - real(2.0) * step
        return turn + (real(6.0) * s) * bend

    return cubic_value, cubic_rate, cubic_second
