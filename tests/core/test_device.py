"""Choosing a device, and saying so before kernels are compiled."""

from __future__ import annotations

from pathlib import Path

import pytest
import warp as wp

from warp_mps.core.device import load_modules, open_device
from warp_mps.core.neighbours import METHOD, neighbour_kernels
from warp_mps.core.types import numeric_types
from warp_mps.errors import InputError


def test_the_cpu_is_always_there() -> None:
    assert str(open_device("cpu")) == "cpu"


@pytest.mark.parametrize("name", ["gpu", "cuda:99", ""])
def test_an_unknown_device_is_refused_with_what_there_is(name: str) -> None:
    with pytest.raises(InputError, match="must be one of: cpu"):
        open_device(name)


def test_compiling_is_announced_and_loading_is_not(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    device = open_device("cpu")
    neighbour_kernels(numeric_types(2))
    names, said = [numeric_types(2).module(METHOD)], []
    load_modules(names, device)
    load_modules(names, device, said.append)
    assert said == []
    monkeypatch.setattr(wp.config, "kernel_cache_dir", str(tmp_path))
    wp.get_module(names[0]).unload()
    load_modules(names, device, said.append)
    assert len(said) == 1
    assert "compiling kernels for cpu" in said[0]
