"""Every kernel between water and bodies compiles for CUDA, on a machine without a GPU as well."""

from __future__ import annotations

from pathlib import Path

import pytest
import warp as wp

from warp_mps.core.types import PRECISIONS, numeric_types
from warp_mps.coupling.hydroelastic import declare_kernels
from warp_mps.coupling.interface_kernels import interface_kernels
from warp_mps.coupling.robin_kernels import METHOD, robin_kernels


@pytest.mark.long
@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("dimension", [2, 3])
def test_every_kernel_compiles_for_cuda(dimension: int, precision: str, tmp_path: Path) -> None:
    numbers = numeric_types(dimension, precision)
    assert declare_kernels(numbers) == [numbers.module(METHOD)]
    wp.compile_aot_module(numbers.module(METHOD), arch=80, module_dir=tmp_path, use_ptx=True)
    code = "".join(file.read_text() for file in tmp_path.glob("*.ptx"))
    kernels = [(make.__name__, name) for make in (robin_kernels, interface_kernels) for name in vars(make(numbers))]
    assert len(kernels) == 11
    missing = [kernel for kernel in kernels if ".entry {}__locals__{}_".format(*kernel) not in code]
    assert missing == []
