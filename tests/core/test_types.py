"""Number types by dimension and precision."""

from __future__ import annotations

import pytest
import warp as wp

from warp_mps.core.types import numeric_types


@pytest.mark.parametrize(("dimension", "axial", "rotor"), [(2, 1, 2), (3, 3, 4)])
def test_sizes_of_the_types(dimension: int, axial: int, rotor: int) -> None:
    numbers = numeric_types(dimension)
    assert [len(dtype()) for dtype in (numbers.vec, numbers.axial, numbers.rotor, numbers.vec3)] == [
        dimension,
        axial,
        rotor,
        3,
    ]


@pytest.mark.parametrize(("precision", "real"), [("float64", wp.float64), ("float32", wp.float32)])
def test_precision_of_the_types(precision: str, real: type) -> None:
    numbers = numeric_types(3, precision)
    assert numbers.real is real
    names = {
        wp.zeros(1, dtype=dtype, device="cpu").numpy().dtype.name
        for dtype in (numbers.vec, numbers.axial, numbers.rotor)
    }
    assert names == {precision}


def test_kits_are_made_once() -> None:
    assert numeric_types(2, "float64") is numeric_types(2, "float64")


@pytest.mark.parametrize("arguments", [(1, "float64"), (4, "float64"), (2, "float16")])
def test_no_other_dimension_or_precision(arguments: tuple[int, str]) -> None:
    with pytest.raises(ValueError, match="must be 2 or 3"):
        numeric_types(*arguments)
