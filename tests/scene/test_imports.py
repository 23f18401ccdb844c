"""A scene is plain data: constructing one needs neither Warp, nor USD, nor a method."""

from __future__ import annotations

import subprocess
import sys

import pytest

SCRIPT = """
import sys
from warp_mps.scene import Body, Fluid, Material, Scene, Wall
from warp_mps.shapes import Box

body = Body(name="plate", shape=Box((0.4, 0.1), (0.0, 0.5)), material=Material(1000.0, 1e7, 0.3), spacing=0.02)
water = Fluid(name="water", shape=Box((0.4, 0.2)), spacing=0.02)
floor = Wall(name="floor", shape=Box((0.8, 0.1), (0.0, -0.15)), spacing=0.02)
Scene(bodies=(body,), fluids=(water,), walls=(floor,), duration=1.0, gravity=(0.0, -9.81))
print("\\n".join(sys.modules))
"""


@pytest.fixture(scope="module")
def modules() -> set[str]:
    command = [sys.executable, "-c", SCRIPT]
    return set(subprocess.run(command, check=True, capture_output=True, text=True).stdout.split())


@pytest.mark.parametrize("package", ["warp", "pxr", "matplotlib", "trimesh"])
def test_a_scene_does_not_import_a_heavy_package(modules: set[str], package: str) -> None:
    assert "warp_mps.scene.validation.scene" in modules
    assert package not in modules


@pytest.mark.parametrize("package", ["core", "particles", "walls", "elastic", "fluid", "coupling", "run", "usd", "app"])
def test_a_scene_does_not_import_a_package_above_it(modules: set[str], package: str) -> None:
    above = f"warp_mps.{package}"
    assert [name for name in modules if name == above or name.startswith(f"{above}.")] == []
