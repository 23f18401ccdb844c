"""Times and errors as text."""

from __future__ import annotations

# smaller relative errors are rounding
ROUNDING = 1e-13


def percent(value: float | None) -> str:
    """A relative error as text; empty for None."""
    if value is None:
        return ""
    if abs(value) < ROUNDING:
        return "0 %"
    return f"{100.0 * value:+.2f} %" if abs(value) >= 5e-5 else f"{100.0 * value:+.1e} %"


def duration(seconds: float) -> str:
    """A time as text, in the unit that suits it."""
    if seconds < 120.0:
        return f"{seconds:.2g} s" if seconds < 99.5 else f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 7200.0 else f"{seconds / 3600.0:.1f} h"
