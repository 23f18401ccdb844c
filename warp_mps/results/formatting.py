"""Times, errors and sizes as text, and numbers as JSON has them."""

from __future__ import annotations

import math
from typing import Any

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
        return f"{seconds:.2g} s" if seconds < 9.95 else f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 7200.0 else f"{seconds / 3600.0:.1f} h"


def memory(size: float) -> str:
    """A size in bytes as text."""
    # 1023 MiB would be 1.02e+03 MiB
    return f"{size / 2**30:.3g} GiB" if size >= 999.5 * 2**20 else f"{size / 2**20:.3g} MiB"


def finite(value: Any) -> Any:
    """The same value with None for NaN and infinity, which JSON has not; also inside dictionaries and lists."""
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
