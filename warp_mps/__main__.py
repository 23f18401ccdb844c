"""Entry point of ``warp-mps`` and ``python -m warp_mps``."""

from __future__ import annotations

import os
import signal
import sys

from warp_mps.app import cli
from warp_mps.core.interrupts import STOPPING

# exit codes above this are those of signals
INTERRUPTED = 128


def main() -> int:
    """Run the command line; the exit code of an interrupted run stays, however often it is interrupted."""
    # NumPy reads it as it is imported: the bits of its linear algebra, which couples water and bodies, depend on it
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    code = cli.main()
    if code > INTERRUPTED:
        for number in STOPPING:
            signal.signal(number, signal.SIG_IGN)
    return code


if __name__ == "__main__":
    sys.exit(main())
