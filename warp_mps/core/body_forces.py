"""Accelerations by the body forces of a scene at the places of particles, on a device."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.body_force_kernels import body_force_kernel
from warp_mps.core.device import load_modules
from warp_mps.core.types import NumericTypes
from warp_mps.errors import InputError, RunError
from warp_mps.scene import BodyForce
from warp_mps.scene.validation.rules import place


class BodyForces:
    """The sum of body forces at particles.

    Python functions are evaluated on the host by `evaluate`, outside of any graph; `launch` adds those of Warp.

    Attributes:
        accelerations: Of each particle, after `launch` [m/s^2], vec [n].
        on_host: Whether any function is one of Python.

    Args:
        forces: The body forces.
        rows: For each, whether it acts on each particle, shape [len(forces), n].
        types: Number types.
        device: Warp device.

    Raises:
        InputError: A Warp function cannot be compiled for these types.
    """

    def __init__(self, forces: Sequence[BodyForce], rows: np.ndarray, *, types: NumericTypes, device: Any) -> None:
        self._device, self._count, self._shape = device, rows.shape[1], (rows.shape[1], types.dimension)
        self.accelerations = wp.zeros(self._count, dtype=types.vec, device=device)
        self._of_host = wp.zeros(self._count, dtype=types.vec, device=device)
        self._host: list[tuple[BodyForce, np.ndarray]] = []
        self._launches: list[tuple[Any, wp.array]] = []
        for force, acts in zip(forces, rows, strict=True):
            if force.is_warp_function:
                kernel = _load(force, types, device)
                self._launches.append((kernel, wp.array(acts.astype(float), dtype=types.real, device=device)))
            else:
                self._host.append((force, np.flatnonzero(acts)))
        self._started = False

    @property
    def on_host(self) -> bool:
        """Whether any function is one of Python."""
        return bool(self._host)

    def evaluate(self, x: np.ndarray, time: float) -> None:
        """Evaluate the Python functions at positions [m], shape [n, d], and a time [s], and copy the result over.

        Raises:
            InputError: At its first call, a function raised an exception or gave no finite array of the right shape.
            RunError: Likewise, later.
        """
        total = np.zeros(self._shape)
        for force, rows in self._host:
            total[rows] += self._call(force, x[rows].astype(float), time)
        self._of_host.assign(total)
        self._started = True

    def launch(self, x: wp.array, time: wp.array) -> None:
        """Launch the sum of the accelerations.

        Args:
            x: Positions [m], vec [n].
            time: Time [s], float64 [1].
        """
        wp.copy(self.accelerations, self._of_host)
        for kernel, acts in self._launches:
            wp.launch(kernel, self._count, [x, time, acts], [self.accelerations], device=self._device)

    def _call(self, force: BodyForce, x: np.ndarray, time: float) -> np.ndarray:
        try:
            given = force.acceleration(x, time)
            found = np.asarray(given, float) if np.isrealobj(given) else np.zeros(0)
        except Exception as error:
            raise self._failure(force, time, f"raised {type(error).__name__}: {error}") from error
        if np.ma.isMaskedArray(given) or not np.isrealobj(given):
            raise self._failure(force, time, "gave a masked or complex array, must be an array of real numbers")
        if found.shape != x.shape:
            raise self._failure(force, time, f"gave an array of shape {found.shape}, must be {x.shape}")
        if not np.isfinite(found).all():
            k = int(np.argmin(np.isfinite(found).all(axis=1)))
            at = ", ".join(f"{value:.6g}" for value in x[k])
            raise self._failure(force, time, f"gave {found[k].tolist()} at ({at}) m, must be finite")
        return found

    def _failure(self, force: BodyForce, time: float, reason: str) -> Exception:
        where = place(force, "body force")
        if not self._started:
            return InputError(where, "acceleration", f"{reason}")
        return RunError(f"{where}: at {time:.6g} s its function {reason}")


def _load(force: BodyForce, types: NumericTypes, device: Any) -> Any:
    """The kernel of a Warp function, compiled for a device."""
    kernel = body_force_kernel(force.acceleration, force.identity, types)
    try:
        load_modules([kernel.module.name], device)
    except Exception as error:
        vector = f"wp.vec{types.dimension}{'d' if types.precision == 'float64' else ''} and wp.{types.precision}"
        cause = str(error).strip().splitlines()[-1].lstrip(";")
        reason = f"cannot be compiled as a function of {vector} to a vector: {cause}"
        raise InputError(place(force, "body force"), "acceleration", reason) from error
    return kernel
