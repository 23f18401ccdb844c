"""The package as a whole: its public names."""

from __future__ import annotations

import subprocess
import sys
from importlib import resources

import pytest

import warp_mps


@pytest.mark.parametrize("name", warp_mps.__all__)
def test_every_public_name_leads_to_something_documented(name: str) -> None:
    assert getattr(warp_mps, name).__doc__


def test_what_is_not_public_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = warp_mps.nothing


def test_the_package_is_typed() -> None:
    assert resources.files(warp_mps).joinpath("py.typed").is_file()


def test_importing_it_and_making_a_scene_loads_neither_warp_nor_usd() -> None:
    code = (
        "import sys, warp_mps as mps\n"
        "rubber = mps.Material(1000.0, 1e7, 0.3)\n"
        "body = mps.Body(name='block', shape=mps.Box((0.1, 0.1)), material=rubber, spacing=0.01)\n"
        "force = mps.BodyForce(name='trap', acceleration=lambda x, t: -x)\n"
        "mps.Scene(bodies=(body,), body_forces=(force,), duration=1.0)\n"
        "assert callable(mps.picture) and issubclass(mps.Observer, object)\n"
        "heavy = {'warp', 'pxr', 'matplotlib', 'PIL', 'warp_mps.fluid', 'warp_mps.elastic'}\n"
        "print(sorted(heavy.intersection(sys.modules)))\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
