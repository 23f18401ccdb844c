"""Every kernel compiles for CUDA, on a machine without a GPU as well."""

from __future__ import annotations

from pathlib import Path

import pytest
import warp as wp

from warp_mps.core.neighbours import neighbour_kernels
from warp_mps.core.types import numeric_types
from warp_mps.elastic.declare_kernels import KERNELS, declare_kernels
from warp_mps.elastic.implicit.kernels import KERNELS as IMPLICIT
from warp_mps.elastic.implicit.kernels import declare_implicit
from warp_mps.scene.choices import PRECISIONS


@pytest.mark.long
@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("dimension", [2, 3])
def test_every_kernel_compiles_for_cuda(dimension: int, precision: str, tmp_path: Path) -> None:
    numbers = numeric_types(dimension, precision)
    for module in declare_kernels(numbers):
        wp.compile_aot_module(module, arch=80, module_dir=tmp_path, use_ptx=True)
    code = "".join(file.read_text() for file in tmp_path.glob("*.ptx"))
    declared = [(make.__name__, name) for make in KERNELS for name in vars(make(numbers))]
    declared += [(neighbour_kernels.__name__, name) for name in vars(neighbour_kernels(numeric_types(dimension)))]
    missing = [kernel for kernel in declared if ".entry {}__locals__{}_".format(*kernel) not in code]
    assert missing == []


@pytest.mark.long
@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("dimension", [2, 3])
def test_every_implicit_kernel_compiles_for_cuda(dimension: int, precision: str, tmp_path: Path) -> None:
    numbers = numeric_types(dimension, precision)
    for module in declare_implicit(numbers):
        wp.compile_aot_module(module, arch=80, module_dir=tmp_path, use_ptx=True)
    code = "".join(file.read_text() for file in tmp_path.glob("*.ptx"))
    declared = [(make.__name__, name) for make in IMPLICIT for name in vars(make(numbers))]
    missing = [kernel for kernel in declared if ".entry {}__locals__{}_".format(*kernel) not in code]
    assert missing == []
