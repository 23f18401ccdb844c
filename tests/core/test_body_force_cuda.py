"""The kernels of body forces, and that of a Warp function, compile for CUDA, on a machine without a GPU as well."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import warp as wp

from warp_mps.core.body_force_kernels import body_force_kernel
from warp_mps.core.types import PRECISIONS, numeric_types
from warp_mps.elastic.boundary import body_force_kernels as elastic
from warp_mps.fluid import body_force_kernels as fluid
from warp_mps.scene.body_force import function_identity

pytestmark = pytest.mark.long


@wp.func
def swirl(x: Any, t: Any):
    """A force that depends on place and time."""
    return wp.sin(t) * x


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("dimension", [2, 3])
def test_every_kernel_compiles_for_cuda(dimension: int, precision: str, tmp_path: Path) -> None:
    types = numeric_types(dimension, precision)
    own = body_force_kernel(swirl, function_identity(swirl), types)
    expected = {own.module.name: ["add_body_force"]}
    for method in (elastic, fluid):
        expected[types.module(method.METHOD)] = list(vars(method.body_force_kernels(types)))
    for number, (module, names) in enumerate(expected.items()):
        folder = tmp_path / str(number)
        wp.compile_aot_module(module, arch=80, module_dir=folder, use_ptx=True)
        code = "".join(file.read_text() for file in folder.glob("*.ptx"))
        assert [name for name in names if f"__locals__{name}_" not in code] == []
