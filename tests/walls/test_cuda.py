"""Every kernel of the walls compiles for CUDA, on a machine without a GPU as well."""

from __future__ import annotations

from pathlib import Path

import pytest
import warp as wp

from warp_mps.core.types import numeric_types
from warp_mps.scene.choices import PRECISIONS
from warp_mps.walls.kernels import wall_kernels
from warp_mps.walls.poses import declare_walls


@pytest.mark.long
@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("dimension", [2, 3])
def test_every_kernel_compiles_for_cuda(dimension: int, precision: str, tmp_path: Path) -> None:
    numbers = numeric_types(dimension, precision)
    wp.compile_aot_module(declare_walls(numbers), arch=80, module_dir=tmp_path, use_ptx=True)
    code = "".join(file.read_text() for file in tmp_path.glob("*.ptx"))
    missing = [name for name in vars(wall_kernels(numbers)) if f".entry wall_kernels__locals__{name}_" not in code]
    assert missing == []
