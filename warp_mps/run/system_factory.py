"""The system that a scene makes: its elastic bodies, its fluids, or both, with their kernels loaded."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from warp_mps.particles.particles import Particles
from warp_mps.run.schedule import Clock
from warp_mps.scene import Scene


def make_system(
    scene: Scene,
    particles: Particles,
    clock: Clock,
    *,
    types: Any,
    device: Any,
    graphs: bool,
    announce: Callable[[str], None] | None,
) -> Any:
    """Make the system of a scene on a device.

    Args:
        scene: The case.
        particles: Its particles.
        clock: Its time step and schedule.
        types: Number types.
        device: Warp device.
        graphs: Whether launches are replayed as graphs.
        announce: Called with a message when kernels have to be compiled first.

    Returns:
        A `warp_mps.run.system.System`: the method of the scene's bodies, of its fluids, or of their coupling.

    Raises:
        InputError: The scene's bodies, supports, loads or domain do not fit its particles.
    """
    from warp_mps.core.device import load_modules

    load_modules(_declare(scene, types), device, announce)
    options: dict[str, Any] = {"types": types, "device": device}
    if scene.fluids and scene.bodies:
        from warp_mps.coupling.hydroelastic import Hydroelastic

        return Hydroelastic(scene, particles, interval=clock.dt, graphs=graphs, **options)
    if scene.fluids:
        from warp_mps.fluid.fluids import Fluids

        return Fluids(scene, particles, graphs=graphs, **options)
    if scene.analysis == "static":
        from warp_mps.elastic.implicit.static import StaticSolid

        return StaticSolid(scene, particles, graphs=graphs, **options)
    if scene.implicit:
        from warp_mps.elastic.implicit.solid import ImplicitSolid

        return ImplicitSolid(scene, particles, dt=clock.dt, graphs=graphs, **options)
    from warp_mps.elastic.explicit.solid import Solid

    return Solid(scene, particles, dt=clock.dt, **options)


def _declare(scene: Scene, types: Any) -> list[str]:
    """Declare the kernels that a scene needs, and return the names of their modules."""
    modules: list[str] = []
    if scene.fluids:
        from warp_mps.fluid import fluids

        modules += fluids.declare_kernels(types)
    if scene.bodies:
        from warp_mps.elastic import declare_kernels as elastic

        modules += elastic.declare_kernels(types)
    if scene.walls and not scene.fluids:
        from warp_mps.walls.poses import declare_walls

        modules.append(declare_walls(types))
    if scene.implicit or (scene.bodies and scene.fluids):
        from warp_mps.elastic.implicit.kernels import declare_implicit

        modules += declare_implicit(types)
    if scene.bodies and scene.fluids:
        from warp_mps.coupling import hydroelastic

        modules += hydroelastic.declare_kernels(types)
    return list(dict.fromkeys(modules))
