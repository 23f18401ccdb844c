"""Every kernel of fluids compiles for CUDA, on a machine without a GPU as well."""

from __future__ import annotations

from pathlib import Path

import pytest
import warp as wp

from warp_mps.core.types import numeric_types
from warp_mps.fluid import METHOD
from warp_mps.fluid.fluids import declare_kernels
from warp_mps.fluid.kernels import FACTORIES, fluid_kernels
from warp_mps.scene.choices import PRECISIONS


@pytest.mark.long
@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("dimension", [2, 3])
def test_every_kernel_compiles_for_cuda(dimension: int, precision: str, tmp_path: Path) -> None:
    numbers = numeric_types(dimension, precision)
    assert numbers.module(METHOD) in declare_kernels(numbers)
    wp.compile_aot_module(numbers.module(METHOD), arch=80, module_dir=tmp_path, use_ptx=True)
    code = "".join(file.read_text() for file in tmp_path.glob("*.ptx"))
    kernels = [
        (make.__name__, name)
        for make in FACTORIES
        for name, item in vars(make(numbers)).items()
        if isinstance(item, wp.Kernel)
    ]
    assert len(kernels) > 12
    assert {name for _, name in kernels} <= vars(fluid_kernels(numbers)).keys()
    missing = [kernel for kernel in kernels if ".entry {}__locals__{}_".format(*kernel) not in code]
    assert missing == []
