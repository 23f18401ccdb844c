"""Starting Warp, choosing a device, and loading the kernels before they are needed."""

import contextlib
import errno
import os
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import warp as wp

from warp_mps.core.native_output import native_errors
from warp_mps.errors import InputError


def open_device(name: str) -> Any:
    """Start Warp and return a device.

    Args:
        name: ``cpu``, or a CUDA device such as ``cuda:0``.

    Raises:
        InputError: There is no such device.
    """
    wp.config.log_level = wp.LOG_WARNING
    # on machines without a GPU, Warp's library says so on every run
    with native_errors(), _kernel_cache():
        wp.init()
    known = [device.alias for device in wp.get_devices()]
    if name not in known and not (name == "cuda" and wp.is_cuda_available()):
        raise InputError("", "device", f"{name!r} is not available, must be one of: {', '.join(known)}")
    try:
        return wp.get_device(name)
    except RuntimeError:
        raise InputError("", "device", f"{name!r} is not available, must be one of: {', '.join(known)}") from None


def load_modules(names: Sequence[str], device: Any, announce: Callable[[str], None] | None = None) -> None:
    """Load Warp modules, saying so first when any of them has yet to be compiled.

    Args:
        names: Names of the modules; all their kernels must have been declared.
        device: Device to load them on.
        announce: Called with the message.
    """
    if announce and any(not _is_cached(name, device) for name in names):
        announce(
            f"compiling kernels for {device} (only the first time, about {'a minute' if device.is_cuda else '10 s'})"
        )
    for name in names:
        with native_errors(), _kernel_cache():
            wp.load_module(name, device=device)


@contextlib.contextmanager
def _kernel_cache() -> Iterator[None]:
    """Say in one line that the folder of compiled kernels cannot be used.

    Raises:
        InputError: A file in it is damaged, or it cannot be written.
    """
    try:
        yield
    except (MemoryError, InputError):
        raise
    # Warp raises plain exceptions, and those of the readers of the files in the cache
    except Exception as error:
        folder = wp.config.kernel_cache_dir or os.environ.get("WARP_CACHE_PATH") or "Warp's kernel cache"
        if isinstance(error, OSError) and error.errno not in (errno.EISDIR, errno.ENOTEMPTY):
            reason = f"the kernels cannot be saved: {error.strerror}; let WARP_CACHE_PATH name a folder that can be"
        else:
            reason = f"the compiled kernels cannot be loaded ({_brief(error)}); delete this folder"
        raise InputError(str(folder), "", reason) from error


def _brief(error: Exception) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split())[:120]


def _is_cached(name: str, device: Any) -> bool:
    cache = Path(wp.config.kernel_cache_dir or "")
    # kernels on the CPU are compiled for blocks of one thread
    return (cache / wp.get_module(name).get_module_identifier(1 if device.is_cpu else None)).is_dir()
