"""Printed output of the commands: cases, costs, results."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from warp_mps.observers.sampling import make_sampler
from warp_mps.particles.filling import fill_scene
from warp_mps.particles.particles import Particles
from warp_mps.particles.selection import select_held
from warp_mps.results.formatting import duration, percent
from warp_mps.results.summary import RunSummary, headline
from warp_mps.run.cost import Cost, available_memory, estimate, refuse_too_large
from warp_mps.run.remarks import remarks_on_case
from warp_mps.run.schedule import Clock
from warp_mps.scene import Load, Scene, Support
from warp_mps.usd.shipped_cases import shipped_cases

WIDE = 300
ROOM_FOR_SOURCES = 130


def print_cases() -> int:
    """Print the shipped cases and the first line of each description."""
    from pxr import Sdf

    table = _table("case", "what it is")
    for name, path in shipped_cases().items():
        text = Sdf.Layer.OpenAsAnonymous(str(path)).documentation.strip()
        table.add_row(name, text.splitlines()[0] if text else "")
    console().print(table)
    return 0


def print_check(scene: Scene) -> int:
    """Print the cost of a run of a scene, and refuse a scene that the run would refuse.

    Raises:
        InputError: The bodies, supports, loads or probes do not fit the particles, or there is not enough memory.
    """
    cost = estimate(scene)
    lines: list[str] = []
    if cost.memory <= available_memory():
        particles = fill_scene(scene)
        lines = [*part_lines(scene, particles), *remarks_on_case(scene, particles)]
        held: list[Support | Load] = [*scene.supports, *scene.loads]
        for item in held:
            select_held(particles, item)
        for probe in scene.probes:
            make_sampler(probe, scene, particles)
    console().print(_cost_table(scene, cost))
    for line in lines:
        console().print(line, highlight=False, soft_wrap=True)
    refuse_too_large(scene)
    return 0


def _cost_table(scene: Scene, cost: Cost) -> Table:
    clock, static = Clock(scene), scene.analysis == "static"
    table = _table("", "")
    table.show_header = False
    table.add_row("case", f"{scene.name} ({_kind(scene)})")
    for name, count in cost.particles.items():
        table.add_row(f"particles of {name}", f"{count}")
    table.add_row("neighbours of a particle", f"{cost.neighbours}")
    note = "" if cost.dt <= cost.dt_limit else f"  ABOVE THE LIMIT of {cost.dt_limit:.4g} s: will be unstable"
    step = "longest time step" if scene.fluids else "load step" if static else "time step"
    table.add_row(step, f"{cost.dt:.4g}{'' if static else ' s'}{note}")
    table.add_row("steps at least, frames" if scene.fluids else "steps, frames", f"{cost.steps}, {cost.frames}")
    rates = (1.0 / (every * clock.dt) for every in (clock.frame_every, clock.sample_every))
    if not static:
        table.add_row("frames, rows of probes.csv a second", ", ".join(f"{rate:.6g}" for rate in rates))
    available = available_memory()
    note = "" if cost.memory <= available else "  TOO MUCH: will be refused"
    table.add_row("memory", f"{_bytes(cost.memory)} of {_bytes(available)} available{note}")
    free = shutil.disk_usage(".").free
    note = "" if 2.0 * cost.disk <= free else "  TOO MUCH: save fewer frames, by a lower mps:frameRate"
    here = f"at most {_bytes(cost.disk)}, twice that while it is written, {_bytes(free)} are free here"
    table.add_row("animation", f"{here}{note}")
    table.add_row("expected time on one CPU core", duration(cost.seconds))
    return table


def part_lines(scene: Scene, particles: Particles) -> list[str]:
    """A line for each material of the bodies that are made of several: its particles and their mass."""
    lines, unit, number = [], "kg" if scene.dimension == 3 else "kg/m", 0
    for body in scene.bodies:
        for name in (body.name, *(f"{body.name}, part {part.name}" for part in body.parts)):
            masses = particles.masses[particles.materials == number]
            number += 1
            if body.parts:
                lines.append(f"{name}: {len(masses)} particles, {masses.sum():.6g} {unit}")
    return lines


def print_summary(summary: RunSummary, folder: Path) -> None:
    """Print how a run went and where its results are."""
    out = console()
    out.print(headline(summary), highlight=False, soft_wrap=True)
    if summary.measurements:
        print_measurements([(summary.case, row) for row in summary.measurements])
    out.print(f"results in {folder}", highlight=False, soft_wrap=True)


def _kind(scene: Scene) -> str:
    """Dimension and method of a scene."""
    if scene.fluids:
        kind = f"{scene.dimension}-D, fluid scheme {scene.flow.scheme}"
        return f"{kind}, model {scene.elasticity.model}" if scene.bodies else kind
    kind = "3-D" if scene.dimension == 3 else f"2-D, plane {scene.plane}"
    return f"{kind}, model {scene.elasticity.model}"


def print_measurements(rows: Sequence[tuple[str, dict[str, Any]]]) -> None:
    """Print measurements beside their references: case, result, measured, reference, error, source.

    On a narrow terminal the sources are listed below the table, by number.
    """
    out = console()
    sources = list(dict.fromkeys(row["source"] for _, row in rows if row["source"]))
    beside = out.width >= ROOM_FOR_SOURCES
    table = _table("case", "result", "measured", "reference", "error", *(["source"] * beside))
    last = ""
    for case, row in rows:
        reference = "" if row["reference"] is None else f"{row['reference']:.5g}"
        if not beside and row["source"]:
            reference += f" ({sources.index(row['source']) + 1})"
        measured = row.get("reason", "none") if row["value"] is None else f"{row['value']:.5g} {row['unit']}"
        cells = [measured, reference, percent(row["error"]), *([row["source"]] * beside)]
        table.add_row("" if case == last else case, row["name"], *cells)
        last = case
    out.print(table, highlight=False, markup=False)
    if not beside:
        for number, source in enumerate(sources, start=1):
            out.print(f"({number}) {source}", highlight=False, markup=False)


def console() -> Console:
    """Standard output; wide if it is not a terminal, so that lines of a log are not wrapped."""
    return Console() if sys.stdout.isatty() else Console(width=WIDE)


def _table(*columns: str) -> Table:
    """A table; its last column wraps on a narrow terminal."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    for column in columns[:-1]:
        table.add_column(column, no_wrap=True)
    table.add_column(columns[-1], overflow="fold")
    return table


def _bytes(value: float) -> str:
    return f"{value / 2**30:.3g} GiB" if value >= 2**30 else f"{value / 2**20:.3g} MiB"
