"""The limit of a process's address space (``ulimit -v``): below it, libraries crash where they are imported."""

from __future__ import annotations

import os

# what the libraries reserve when they are imported, and what their threads reserve on each core [bytes]
NEEDED, NEEDED_PER_CORE = 2 * 2**30, 64 * 2**20


def too_small() -> str:
    """Why Warp, USD and NumPy cannot start within the limit; empty if they can."""
    try:
        import resource
    except ImportError:  # Windows
        return ""
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    needed = NEEDED + NEEDED_PER_CORE * (os.cpu_count() or 1)
    if limit != resource.RLIM_INFINITY and limit < needed:
        least = f"at least {needed / 2**30:.2f} GiB on this machine"
        return f"the address space is {limit / 2**30:.2f} GiB (ulimit -v), must be {least}"
    return ""
