"""Every kernel compiles for CUDA, on a machine without a GPU as well."""

from __future__ import annotations

from pathlib import Path

import pytest
import warp as wp

from warp_mps.core.kit import PRECISIONS, kit
from warp_mps.elastic.solid import declare_kernels


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("dimension", [2, 3])
def test_every_module_compiles_for_cuda(dimension: int, precision: str, tmp_path: Path) -> None:
    names = declare_kernels(kit(dimension, precision))
    for name in names:
        wp.compile_aot_module(name, arch=80, module_dir=tmp_path, use_ptx=True)
    text = "".join(file.read_text() for file in tmp_path.glob("*.ptx"))
    for kernel in ("count", "fill", "pressure", "force", "drift", "kick", "candidates", "drive", "chunk_sums"):
        assert f".entry {kernel}_" in text
