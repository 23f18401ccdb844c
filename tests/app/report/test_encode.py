"""Packed numbers: unpacked as the page does, they are the same."""

from __future__ import annotations

import base64
import zlib

import numpy as np
import pytest

from warp_mps.app.report.encode import Packed, pack, quantize


def unpacked(packed: Packed, frames: int) -> np.ndarray:
    planes = np.frombuffer(zlib.decompress(base64.b64decode(packed.text)), dtype=np.uint8).astype(np.uint16)
    low, high = np.split(planes, 2)
    codes = low | (high << 8)
    numbers = ((codes >> 1) ^ np.where(codes & 1, 0xFFFF, 0).astype(np.uint16)).reshape(frames, -1)
    for _ in range(packed.order):
        numbers = np.cumsum(numbers, axis=0, dtype=np.uint16)
    return numbers


def test_packed_numbers_are_the_same_again() -> None:
    random = np.random.default_rng(3)
    for whole in (
        random.integers(0, 65536, (7, 11)),
        random.integers(0, 256, (1, 5)),
        np.array([[0, 65535], [65535, 0], [0, 65535]]),
    ):
        numbers = whole.astype(np.uint16)
        assert np.array_equal(unpacked(pack(numbers), len(numbers)), numbers)


def test_what_speeds_up_evenly_is_written_as_differences_of_differences() -> None:
    frames, particles = np.arange(40)[:, None], np.arange(100)[None]
    numbers = (3 * frames**2 * (1 + particles % 7) + 501 * particles).astype(np.uint16)
    assert pack(numbers).order == 2
    assert len(pack(numbers).text) < 0.1 * numbers.nbytes
    assert np.array_equal(unpacked(pack(numbers), 40), numbers)


@pytest.mark.parametrize("top", [255, 65535])
def test_quantized_values_are_off_by_half_a_step_at_most(top: int) -> None:
    values = np.random.default_rng(1).uniform(-3.0, 5.0, 1000)
    numbers = quantize(values, -3.0, 5.0, top)
    assert np.abs(-3.0 + 8.0 * numbers / top - values).max() <= 4.0 / top * (1 + 1e-9)
    assert quantize(np.array([-9.0, 9.0, np.inf, np.nan]), -3.0, 5.0, top).tolist() == [0, top, top, 0]
    assert quantize(np.array([2.0]), 2.0, 2.0, top).tolist() == [0]
