"""Benchmark of coupled runs: a column of water on an elastic plate, with the share of each part of a step."""

from __future__ import annotations

import itertools
import math
import sys
import time
from collections.abc import Callable, Sequence
from typing import Any

from rich.table import Table

from warp_mps.app.bench.fluids import THICK, TOLERANCE, box
from warp_mps.app.bench.solids import fits
from warp_mps.app.printing import console
from warp_mps.coupling.hydroelastic import Hydroelastic
from warp_mps.run.simulation import Simulation
from warp_mps.scene import Body, Contact, Flow, Fluid, Material, Scene, Support, Wall
from warp_mps.scene.choices import IntegratorName, PrecisionName

# default numbers of fluid particles by dimension
SIZES: dict[int, tuple[int, ...]] = {2: (1_000, 10_000), 3: (10_000,)}
WAYS: tuple[IntegratorName, ...] = ("explicit", "implicit")
# wood; spacings of 1 m
PLATE = Material(500.0, 1e9, 0.3)
# longest steps of the water in an interval; numbers of warm-up and of measured intervals
INTERVAL, WARM, MEASURED = 8.0, 2, 4
# parts of a step by the names of their launches; the remainder is the coupling
PARTS = {
    "set time step": "fluid",
    "predict": "fluid",
    "correct": "fluid",
    "solve pressure": "pressure",
    "solve pressure again": "pressure",
}
COLUMNS = ("space", "fluid", "bodies", "steps of bodies", "precision", "ms a step", "passes", "iterations a solve")


def bench_coupling(
    sizes: Sequence[int], *, dimensions: Sequence[int], precisions: Sequence[PrecisionName], device: str
) -> int:
    """Measure a column of each size, dimension and precision, on a plate that takes either kind of steps.

    Args:
        sizes: Numbers of fluid particles; none means those of `SIZES`.
        dimensions: 2, 3 or both.
        precisions: ``float64``, ``float32`` or both.
        device: Device to run on.
    """
    table = Table(box=None, pad_edge=False, header_style="bold")
    for title in COLUMNS:
        table.add_column(title, justify="right")
    table.add_column("share of each part")
    for dimension, precision in itertools.product(dimensions, precisions):
        for size, way in itertools.product(sizes or SIZES[dimension], WAYS):
            scene = column(dimension, size, way)
            if not fits(scene, size):
                continue
            line = f"warp-mps: water on a plate, {dimension}-D, {size} particles, {way}, {precision}"
            print(line, file=sys.stderr, flush=True)
            table.add_row(*_measure(scene, precision, device))
    console().print(table)
    return 0


def column(dimension: int, size: int, way: IntegratorName) -> Scene:
    """A cube of about `size` particles of water on a plate that is held beyond the walls about the water."""
    width, thick = max(6, round(size ** (1.0 / dimension))), THICK[dimension]
    low, high = [-float(thick)] * (dimension - 2), [float(width + thick)] * (dimension - 2)
    depth, height = [float(width)] * (dimension - 2), float(width + 5)
    walls = [("left", [-thick, 0.0, *low], [0.0, height, *high])]
    walls += [("right", [width, 0.0, *low], [width + thick, height, *high])]
    if dimension == 3:
        walls += [
            ("back", [0.0, 0.0, *low], [width, height, 0.0]),
            ("front", [0.0, 0.0, *depth], [width, height, *high]),
        ]
    # thick enough to deflect little
    bottom = -float(max(4, width // 8))
    plate = box([-thick, bottom, *low], [width + thick, 0.0, *high])
    ends = [
        ("left", box([-thick, bottom, *low], [0.0, 0.0, *high])),
        ("right", box([width, bottom, *low], [width + thick, 0.0, *high])),
    ]
    # the fall of a particle through the height, as that of `warp_mps.fluid.time_step`
    longest = Flow().courant / math.sqrt(2.0 * 9.81 * width)
    return Scene(
        name="bench", dimension=dimension, duration=1.0, gravity=(0.0, -9.81, 0.0)[:dimension],
        bodies=(Body(name="plate", shape=plate, material=PLATE, spacing=1.0),),
        supports=tuple(Support(name=f"{name}_end", region=region) for name, region in ends),
        walls=tuple(Wall(name=name, shape=box(a, b), spacing=1.0) for name, a, b in walls),
        fluids=(Fluid(name="water", shape=box([0.0] * dimension, [width, width, *depth]), spacing=1.0),),
        flow=Flow(tolerance=TOLERANCE), integrator=way, contact=Contact(between="none"),
        frame_rate=1.0 / (INTERVAL * longest),
    )  # fmt: skip


def _measure(scene: Scene, precision: PrecisionName, device: str) -> list[str]:
    simulation = Simulation(scene, device=device, precision=precision)
    system, p = simulation.system, simulation.particles
    assert isinstance(system, Hydroelastic)
    simulation.advance(WARM)
    before, steps, passes = system.fluids.statistics(), simulation.steps_done, system.step.passes.statistics.passes
    seconds = min(_interval(simulation) for _ in range(MEASURED))
    after = system.fluids.statistics()
    done, passes = simulation.steps_done - steps, system.step.passes.statistics.passes - passes
    return [
        f"{scene.dimension}-D",
        f"{p.liquid}",
        f"{p.elastic}",
        scene.integrator,
        precision,
        f"{1e3 * seconds:.4g}",
        f"{passes / done:.2f}",
        f"{(after.iterations - before.iterations) / (after.solves - before.solves):.1f}",
        _shares(simulation, system),
    ]


def _interval(simulation: Simulation) -> float:
    """Seconds of a step of the water in one more interval."""
    steps, begin = simulation.steps_done, time.perf_counter()
    simulation.advance(1)
    simulation.synchronize()
    return (time.perf_counter() - begin) / (simulation.steps_done - steps)


def _shares(simulation: Simulation, system: Hydroelastic) -> str:
    """The parts of one more interval, in percent of it."""
    times = dict.fromkeys(("pressure", "fluid", "structure", "exchange"), 0.0)

    def timed(part: Callable[..., str | None], call: Callable[..., Any]) -> Callable[..., Any]:
        def run(*arguments: Any, **options: Any) -> Any:
            simulation.synchronize()
            begin = time.perf_counter()
            call(*arguments, **options)
            simulation.synchronize()
            if name := part(*arguments):
                times[name] += time.perf_counter() - begin

        return run

    passes, structure = system.step.passes, system.structure
    replay, advance = passes.replay, structure.advance
    passes.replay = timed(lambda name, _: PARTS.get(name), replay)  # type: ignore[assignment]
    structure.advance = timed(lambda _: "structure", advance)  # type: ignore[method-assign]
    begin = time.perf_counter()
    simulation.advance(1)
    whole = time.perf_counter() - begin
    passes.replay, structure.advance = replay, advance  # type: ignore[method-assign]
    times["exchange"] = whole - sum(times.values())
    return ", ".join(f"{name} {100.0 * value / whole:.0f} %" for name, value in times.items())
