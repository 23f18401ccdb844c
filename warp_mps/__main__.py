"""Entry point of ``warp-mps`` and ``python -m warp_mps``."""

from __future__ import annotations

import sys

from warp_mps.app.cli import main

if __name__ == "__main__":
    sys.exit(main())
