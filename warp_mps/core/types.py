"""The number types of a run, by dimension and precision, and the Warp module that its kernels belong to."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import warp as wp

from warp_mps.scene.choices import PRECISIONS, PrecisionName


@dataclass(frozen=True)
class NumericTypes:
    """Number types of kernels of one dimension and precision.

    Kernels are made by cached factories that take these types, so that 2-D and 3-D, float64 and float32 come from the
    same lines. All kernels of one method and the same types share one Warp module, which is compiled once.

    Attributes:
        dimension: 2 or 3.
        precision: ``float64`` or ``float32``.
    """

    dimension: int
    precision: PrecisionName

    @property
    def real(self) -> Any:
        """Scalar type."""
        return wp.float64 if self.precision == "float64" else wp.float32

    @property
    def vec(self) -> Any:
        """Vector of the space."""
        return wp.types.vector(length=self.dimension, dtype=self.real)

    @property
    def mat(self) -> Any:
        """Square matrix of the space."""
        return wp.types.matrix(shape=(self.dimension, self.dimension), dtype=self.real)

    @property
    def axial(self) -> Any:
        """Angular velocity or torque: 1 component in 2-D, 3 in 3-D."""
        return wp.types.vector(length=2 * self.dimension - 3, dtype=self.real)

    @property
    def rotor(self) -> Any:
        """A particle's rotation; see `warp_mps.core.rotation`."""
        return wp.types.vector(length=2 * self.dimension - 2, dtype=self.real)

    @property
    def vec3(self) -> Any:
        """3-vector, which `wp.HashGrid` requires in 2-D as well."""
        return wp.types.vector(length=3, dtype=self.real)

    def module(self, method: str) -> str:
        """Name of the Warp module for a method's kernels."""
        return f"warp_mps.{method}.{self.dimension}d.{self.precision}"

    def kernel(self, method: str) -> Callable[[Callable[..., None]], Any]:
        """Decorator of a kernel of a method; no gradients are generated, which halves the compile time."""
        return wp.kernel(module=self.module(method), enable_backward=False)

    def func(self, method: str) -> Callable[[Callable[..., Any]], Any]:
        """Decorator of a device function of a method."""
        return wp.func(module=self.module(method))


@functools.cache
def numeric_types(dimension: int, precision: PrecisionName = "float64") -> NumericTypes:
    """The types of a dimension and a precision.

    Raises:
        ValueError: No such dimension or precision.
    """
    if dimension not in (2, 3) or precision not in PRECISIONS:
        raise ValueError(
            f"dimension is {dimension}, must be 2 or 3, and precision is {precision!r}, must be one of {PRECISIONS}"
        )
    return NumericTypes(dimension, precision)
