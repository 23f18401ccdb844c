"""A clamped plate of aluminium under water, whose answers are known from finite elements."""

from __future__ import annotations

from warp_mps.scene import Body, Load, Material, Scene, Support
from warp_mps.shapes import Box

# 2 m of water [Pa]
PRESSURE = 19620.0
# of the middle [m]: 160 x 8 quadratic elements, plane strain, the pressure on the upper face
DEFLECTION = -6.616e-5


def plate(layers: int, **scene: object) -> Scene:
    """1 x 0.05 m, clamped at both ends with a column of particles on each clamped section, without its own weight.

    Args:
        layers: Particles through the thickness.
        scene: Fields of the scene.
    """
    spacing = 0.05 / layers
    metal = Material(2700.0, 67.5e9, 0.34)
    shape = Box((1.0 + 4.0 * spacing, 0.05))
    body = Body(name="plate", shape=shape, material=metal, spacing=spacing, node_axes=(0,))
    clamps = [
        Support(name=name, region=Box((4.0 * spacing, 0.1), center=(sign * (0.5 + 2.0 * spacing), 0.0)))
        for name, sign in (("left", -1.0), ("right", 1.0))
    ]
    top = Box((1.0 - spacing, spacing), center=(0.0, 0.025))
    water = Load(name="water", region=top, acceleration=(0.0, -PRESSURE / (metal.density * spacing)))
    fields = {"supports": tuple(clamps), "loads": (water,), "duration": 1.0}
    return Scene(**{"bodies": (body,), **fields, **scene})  # type: ignore[arg-type]
