"""Benchmark of the elastic solver: particle-steps a second, with the share of each part of a step."""

from __future__ import annotations

import functools
import itertools
import sys
import time
from collections.abc import Callable, Sequence
from typing import Any

from rich.table import Table

from warp_mps.app.printing import console
from warp_mps.particles.filling import count_particles
from warp_mps.run.cost import available_memory, memory_of
from warp_mps.run.simulation import Simulation
from warp_mps.scene import Body, Elasticity, Material, Scene
from warp_mps.scene.choices import ElasticModelName, PrecisionName
from warp_mps.shapes import Box

# default numbers of particles
SIZES = (1_000, 10_000, 100_000, 1_000_000)
# seconds of a measurement and number of rounds, of which the fastest counts
ROUND_SECONDS = 0.5
ROUNDS = 3


def bench_solid(
    sizes: Sequence[int],
    *,
    models: Sequence[ElasticModelName],
    dimensions: Sequence[int],
    precisions: Sequence[PrecisionName],
    device: str,
    threads: int = 1,
) -> int:
    """Measure an elastic block of each model, size, dimension and precision and print a table.

    Args:
        sizes: Numbers of particles; none means those of `SIZES`.
        models: Elastic models.
        dimensions: 2, 3 or both.
        precisions: ``float64``, ``float32`` or both.
        device: Device to run on.
        threads: Threads on the CPU device.
    """
    table = Table(box=None, pad_edge=False, header_style="bold")
    for column in (
        "model",
        "space",
        "particles",
        "neighbours",
        "precision",
        "us a step",
        "us a particle-step",
        "million/s",
    ):
        table.add_column(column, justify="right", no_wrap=True)
    table.add_column("share of each kernel")
    for model, dimension, size, precision in itertools.product(models, dimensions, sizes or SIZES, precisions):
        scene = block(model, dimension, size)
        if not fits(scene, size):
            continue
        print(f"warp-mps: {model}, {dimension}-D, {size} particles, {precision}", file=sys.stderr, flush=True)
        table.add_row(model, *_measure(scene, precision, device, threads))
    console().print(table)
    return 0


def fits(scene: Scene, size: int) -> bool:
    """Whether a scene of a size fits into memory; says so if it does not."""
    if memory_of(scene, count_particles(scene)) <= available_memory():
        return True
    print(f"warp-mps: {size} particles in {scene.dimension}-D do not fit into memory, left out", file=sys.stderr)
    return False


def block(model: ElasticModelName, dimension: int, size: int) -> Scene:
    """A square or cubic block of about `size` particles, stretching and shrinking freely."""
    side = round(size ** (1.0 / dimension))
    material = Material(density=1000.0, youngs_modulus=1e6, poissons_ratio=0.3)
    body = Body(
        name="block",
        shape=Box((float(side),) * dimension),
        material=material,
        spacing=1.0,
        angular_velocity=0.1 if dimension == 2 else (0.1, 0.2, 0.3),
    )
    # 12 neighbours in 2-D and 32 in 3-D, as other codes have them in the figures that they publish
    elasticity = Elasticity(model=model, effective_radius=2.1)
    return Scene(name="bench", bodies=(body,), dimension=dimension, duration=1.0, elasticity=elasticity)


def _measure(scene: Scene, precision: PrecisionName, device: str, threads: int) -> list[str]:
    simulation = Simulation(scene, device=device, precision=precision, threads=threads)
    seconds = _seconds_a_step(simulation)
    count = simulation.particles.count
    neighbours = len(simulation.solid.model.index) / count
    return [
        f"{scene.dimension}-D",
        f"{count}",
        f"{neighbours:.1f}",
        precision,
        f"{1e6 * seconds:.4g}",
        f"{1e6 * seconds / count:.4f}",
        f"{count / seconds / 1e6:.3g}",
        _shares(simulation),
    ]


def _seconds_a_step(simulation: Simulation) -> float:
    return _fastest(lambda steps: _advance(simulation, steps))


def _advance(simulation: Simulation, steps: int) -> None:
    simulation.advance(steps)
    simulation.synchronize()


def _shares(simulation: Simulation) -> str:
    """Each phase of a step alone, as a graph of its own, as a part of their sum."""
    from warp_mps.core.replay import capture
    from warp_mps.elastic.explicit.solid import Solid

    device, count = simulation.device, simulation.particles.elastic
    times: dict[str, float] = {}
    assert isinstance(simulation.solid, Solid)
    for phase in simulation.solid.phases:
        graph = capture(functools.partial(phase.launch, 0, count), device)
        times[phase.name] = _fastest(_replay(graph, simulation))
    total = sum(times.values())
    return ", ".join(f"{name} {100.0 * value / total:.0f} %" for name, value in times.items())


def _replay(graph: Any, simulation: Simulation) -> Callable[[int], None]:
    import warp as wp

    def replay(times: int) -> None:
        for _ in range(times):
            wp.capture_launch(graph)
        simulation.synchronize()

    return replay


def _fastest(work: Callable[[int], None]) -> float:
    """Seconds of one of many repetitions, from the fastest round."""
    work(1)
    begin = time.perf_counter()
    work(1)
    once = max(time.perf_counter() - begin, 1e-7)
    repetitions = max(1, min(100_000, int(ROUND_SECONDS / once)))
    best = float("inf")
    for _ in range(ROUNDS):
        begin = time.perf_counter()
        work(repetitions)
        best = min(best, (time.perf_counter() - begin) / repetitions)
    return best
