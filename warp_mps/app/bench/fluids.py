"""Benchmark of fluids: particle-steps a second of a dam break, with the share of each part of a step."""

from __future__ import annotations

import itertools
import sys
import time
from collections.abc import Sequence
from typing import Any

from rich.table import Table

from warp_mps.app.bench.solids import fits
from warp_mps.app.printing import console
from warp_mps.core.linear.conjugate_gradient import Statistics
from warp_mps.run.simulation import Simulation
from warp_mps.scene import Flow, Fluid, Scene, Wall
from warp_mps.scene.choices import PrecisionName
from warp_mps.shapes import Box

# default numbers of particles by dimension
SIZES: dict[int, tuple[int, ...]] = {2: (1_000, 10_000, 100_000), 3: (30_000,)}
# warm-up steps of the collapse
WARM_STEPS = 40
# seconds and number of rounds, of which the fastest counts; least and most steps of a round; steps for the shares
ROUND_SECONDS, ROUNDS = 1.0, 3
ROUND_STEPS = (5, 200)
SHARED_STEPS = 10
# thickness of walls in spacings
THICK = {2: 4, 3: 3}
# true residual of the pressure solve
TOLERANCE = 1e-4
COLUMNS = (
    "space",
    "fluid",
    "walls",
    "precision",
    "ms a step",
    "million/s",
    "ms a search",
    "iterations a solve",
    "residual",
)


def bench_fluids(
    sizes: Sequence[int], *, dimensions: Sequence[int], precisions: Sequence[PrecisionName], device: str
) -> int:
    """Measure a dam break of each size, dimension and precision and print a table.

    Args:
        sizes: Numbers of fluid particles; none means those of `SIZES`.
        dimensions: 2, 3 or both.
        precisions: ``float64``, ``float32`` or both.
        device: Device to run on.
    """
    table = Table(box=None, pad_edge=False, header_style="bold")
    for column in COLUMNS:
        table.add_column(column, justify="right")
    table.add_column("share of each part")
    for dimension, precision in itertools.product(dimensions, precisions):
        for size in sizes or SIZES[dimension]:
            scene = dam(dimension, size)
            if not fits(scene, size):
                continue
            print(f"warp-mps: dam break, {dimension}-D, {size} particles, {precision}", file=sys.stderr, flush=True)
            table.add_row(*_measure(scene, precision, device))
    console().print(table)
    return 0


def dam(dimension: int, size: int) -> Scene:
    """A column of about `size` particles, twice as high as wide, at the end of a tank four times as long.

    All lengths are whole numbers of spacings, of 1 m, so that the lattices of water and walls fit each other.
    """
    width = max(2, round((size / 2.0) ** (1.0 / dimension)))
    thick = THICK[dimension]
    depth = [float(width)] * (dimension - 2)
    length, height = 4.0 * width, 2.0 * width + 5.0
    low, high = [-float(thick)] * (dimension - 2), [float(width + thick)] * (dimension - 2)
    walls = [
        _wall("floor", [-thick, -thick, *low], [length + thick, 0.0, *high]),
        _wall("left", [-thick, 0.0, *low], [0.0, height, *high]),
        _wall("right", [length, 0.0, *low], [length + thick, height, *high]),
    ]
    if dimension == 3:
        walls += [
            _wall("back", [0.0, 0.0, *low], [length, height, 0.0]),
            _wall("front", [0.0, 0.0, *depth], [length, height, *high]),
        ]
    water = Fluid(name="water", shape=box([0.0] * dimension, [width, 2.0 * width, *depth]), spacing=1.0)
    return Scene(
        name="bench", dimension=dimension, fluids=(water,), walls=tuple(walls), duration=1.0,
        gravity=(0.0, -9.81, 0.0)[:dimension], flow=Flow(tolerance=TOLERANCE),
    )  # fmt: skip


def box(low: Sequence[float], high: Sequence[float]) -> Box:
    """A box by its corners."""
    size = tuple(float(b - a) for a, b in zip(low, high, strict=True))
    return Box(size, tuple((a + b) / 2.0 for a, b in zip(low, high, strict=True)))


def _wall(name: str, low: Sequence[float], high: Sequence[float]) -> Wall:
    return Wall(name=name, shape=box(low, high), spacing=1.0)


def _measure(scene: Scene, precision: PrecisionName, device: str) -> list[str]:
    simulation = Simulation(scene, device=device, precision=precision)
    fluids, liquid = simulation.fluids, simulation.particles.liquid
    fluids.advance(WARM_STEPS * fluids.model.step_limit)
    before = fluids.statistics()
    seconds = _seconds_a_step(simulation)
    after = fluids.statistics()
    shares = _shares(simulation)
    return [
        f"{scene.dimension}-D",
        f"{liquid}",
        f"{simulation.particles.count - liquid}",
        precision,
        f"{1e3 * seconds:.4g}",
        f"{liquid / seconds / 1e6:.3g}",
        f"{1e3 * _seconds_a_search(simulation):.4g}",
        f"{_iterations_a_solve(before, after):.1f}",
        f"{after.worst_residual:.1e}",
        shares,
    ]


def _iterations_a_solve(before: Statistics, after: Statistics) -> float:
    return (after.iterations - before.iterations) / (after.solves - before.solves)


def _seconds_a_step(simulation: Simulation) -> float:
    """Seconds of a step, from the fastest of a few intervals of the flow."""
    seconds, steps = _interval(simulation, ROUND_STEPS[0])
    least, most = ROUND_STEPS
    steps = min(max(least, round(ROUND_SECONDS * steps / seconds)), most)
    rounds = (_interval(simulation, steps) for _ in range(ROUNDS))
    return min(seconds / steps for seconds, steps in rounds)


def _seconds_a_search(simulation: Simulation) -> float:
    """Seconds of a neighbour search, which fast flow needs in every step and slow flow in few."""
    fluids, best = simulation.fluids, float("inf")
    for _ in range(ROUNDS):
        begin = time.perf_counter()
        fluids.step.renew_neighbours()
        simulation.synchronize()
        best = min(best, time.perf_counter() - begin)
    return best


def _interval(simulation: Simulation, steps: int) -> tuple[float, int]:
    """Seconds and steps of an interval of so many of the longest steps."""
    fluids = simulation.fluids
    end = fluids.time + steps * fluids.model.step_limit
    begin = time.perf_counter()
    done = fluids.advance(end)
    simulation.synchronize()
    return time.perf_counter() - begin, done


def _shares(simulation: Simulation) -> str:
    """The parts of some more steps, each part a graph of its own, in percent of their sum."""
    from warp_mps.core.replay import capture

    fluids = simulation.fluids
    graphs = [(name, capture(launch, simulation.device)) for name, launch in fluids.step.phases]
    fluids.step.time_step.set_target(fluids.time + 1e3 * SHARED_STEPS * fluids.model.step_limit)
    times = dict.fromkeys((name for name, _ in graphs), 0.0)
    for _ in range(SHARED_STEPS):
        for name, graph in graphs:
            times[name] += _replay(graph, simulation)
    total = sum(times.values())
    return ", ".join(f"{name} {100.0 * value / total:.0f} %" for name, value in times.items())


def _replay(graph: Any, simulation: Simulation) -> float:
    """Seconds of a graph."""
    import warp as wp

    begin = time.perf_counter()
    wp.capture_launch(graph)
    simulation.synchronize()
    return time.perf_counter() - begin
