"""The process that `warp_mps.usd.case.isolated_open` starts: it opens one stage in bounded memory and time."""

from __future__ import annotations

import contextlib
import math
import os
import sys
import time

from pxr import Usd

from warp_mps.errors import InputError
from warp_mps.usd import register_schema
from warp_mps.usd.case.isolated_open import MEMORY, MEMORY_PER_BYTE, READY, TOO_LARGE
from warp_mps.usd.case.layers import check_layers


def main(path: str, seconds: str, *external: str) -> int:
    """Open a stage and read every value in it, in bounded memory and time; errors that USD reports are ignored here."""
    register_schema()
    _limit_memory(MEMORY + MEMORY_PER_BYTE * os.path.getsize(path))
    limit_time(float(seconds))
    sys.stdout.buffer.write(READY)
    sys.stdout.buffer.flush()
    try:
        _read(path, allow_external=bool(external))
    except MemoryError:
        return TOO_LARGE
    except (InputError, RuntimeError, UnicodeDecodeError) as error:
        return TOO_LARGE if "bad_alloc" in getattr(error, "reason", str(error)) else 0
    return 0


def _read(path: str, *, allow_external: bool) -> None:
    layers = check_layers(path, allow_external=allow_external, tried=True)
    stage = Usd.Stage.Open(layers[0])
    for prim in stage.Traverse(Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)):
        for attribute in prim.GetAttributes():
            attribute.Get()


def _limit_memory(size: int) -> None:
    """Let the system refuse more memory than this, where it can; and leave no image of a crash behind."""
    with contextlib.suppress(ImportError, ValueError, OSError):
        import resource

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_DATA, (size, size))


def limit_time(seconds: float) -> None:
    """Let the system end the process (SIGXCPU) after this much more processor time, where it can."""
    with contextlib.suppress(ImportError, ValueError, OSError):
        import resource

        # what the start has taken counts too, and the limit is in whole seconds
        soft = math.ceil(time.process_time() + seconds)
        _, hard = resource.getrlimit(resource.RLIMIT_CPU)
        resource.setrlimit(resource.RLIMIT_CPU, (soft, hard))


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
