"""The check of a case as text: names and values, a line each."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from warp_mps.results.formatting import duration, memory
from warp_mps.run.cost.memory import PROGRAM
from warp_mps.run.inventory.flotation import Flotation
from warp_mps.run.inventory.items import ItemCheck

if TYPE_CHECKING:
    from warp_mps.run.inventory.case_check import CaseCheck

# in spacings: smaller misfits and gaps are left out
LEAST_MISFIT = 0.01


def outline(found: CaseCheck) -> str:
    """A check of a case, and its remarks."""
    rows = [*cost_rows(found), *(row for item in found.items for row in item_rows(item))]
    width = max(len(name) for name, _ in rows)
    return "\n".join([*(f"{name:<{width}}  {value}".rstrip() for name, value in rows), *found.remarks])


def cost_rows(found: CaseCheck) -> Iterator[tuple[str, str]]:
    """Names and values of what a run of a case takes."""
    cost, step, kinds = found.cost, found.cost.time_step, {item.kind for item in found.items}
    static, flows = found.analysis == "static", "fluid" in kinds
    yield "case", f"{found.case} ({found.method})"
    note = "" if step.length <= step.stable else f"  ABOVE THE LIMIT of {step.stable:.4g} s: will be unstable"
    name = "longest time step" if flows else "load step" if static else "time step"
    yield name, f"{step.length:.4g}{'' if static else ' s'}, limited by {step.limited_by}{note}"
    others = sorted((length, cause) for cause, length in step.limits.items() if cause != step.limited_by)
    for number, (length, cause) in enumerate(others):
        yield "" if number else "  other limits", f"{length:.4g} s, {cause}"
    if kinds >= {"body", "fluid"}:
        explicit = f"{step.substeps} explicit ones in a step of the fluid"
        yield "steps of the bodies", "implicit, those of the fluid" if step.implicit else explicit
    yield "steps, about; frames" if flows else "steps, frames", f"{step.steps}, {cost.frames}"
    if not static:
        yield "frames, rows of probes.csv a second", f"{cost.frame_rate:.6g}, {cost.sample_rate:.6g}"
    beside = f"beside {memory(PROGRAM)} of the program itself"
    yield "memory", f"{memory(cost.memory)} {beside}, of {memory(found.available_memory)} available"
    yield "animation", f"at most {memory(cost.disk)}, twice that while it is written"
    yield "CPU time on one core, about", duration(cost.seconds)


def item_rows(item: ItemCheck) -> Iterator[tuple[str, str]]:
    """Names and values of what an item is."""
    plane = len(item.size) == 2
    yield f"{item.kind} {item.name}", "" if item.path == f"{item.kind} '{item.name}'" else item.path
    size = f"{_times(item.size)} m"
    if item.size_in_stage:
        size += f", {_times(item.size_in_stage)} units of the stage"
    yield "  size, from", f"{size}, {_point(item.low, item.spacing)} m"
    across = f", {_times(item.lattice.across)} at most" if item.lattice else ""
    yield "  particles", f"{item.particles} of {item.spacing:g} m{across}"
    if item.lattice and abs(item.lattice.worst) > LEAST_MISFIT:
        offsets = {side: offset for side, offset in item.lattice.offsets.items() if abs(offset) > LEAST_MISFIT}
        yield "  beyond its drawn faces, in spacings", ", ".join(f"{offsets[side]:+.3g} {side}" for side in offsets)
    yield from _mass_rows(item, plane)
    if item.flotation:
        yield from _flotation_rows(item.flotation)
    if item.wet_sides:
        yield "  wet on", ", ".join(item.wet_sides)
    apart = [gap for gap in item.gaps if abs(gap.gap) > LEAST_MISFIT]
    if apart:
        yield "  gaps, in spacings", ", ".join(f"{gap.gap:.3g} {gap.side} to {gap.neighbour}" for gap in apart)


def _mass_rows(item: ItemCheck, plane: bool) -> Iterator[tuple[str, str]]:
    properties = item.mass
    yield "  area" if plane else "  volume", f"{properties.volume:.6g} m^{2 if plane else 3}"
    centre = f"{_point(properties.centre, item.spacing)} m"
    if properties.mass is None or properties.inertia is None:
        yield "  centre", centre
        return
    yield "  mass", f"{properties.mass:.6g} {'kg/m' if plane else 'kg'}"
    for share in item.parts:
        yield f"    of {share.name}", f"{share.particles} particles, {share.mass:.6g} {'kg/m' if plane else 'kg'}"
    moments = ", ".join(f"{row[k]:.4g}" for k, row in enumerate(properties.inertia))
    yield "  centre of gravity, inertia about it", f"{centre}, {moments} {'kg m' if plane else 'kg m^2'}"


def _flotation_rows(found: Flotation) -> Iterator[tuple[str, str]]:
    if found.draught is None:
        yield "  floats", f"no: it sinks; drawn at a draught of {found.drawn:.4g} m"
        return
    yield "  draught", f"{found.draught:.4g} m in equilibrium, {found.drawn:.4g} m as drawn"
    fate = "" if (found.metacentric_height or 0.0) > 0.0 else ", it capsizes"
    yield "  metacentric height", f"{found.metacentric_height:.4g} m{fate}"


def _times(lengths: Sequence[float]) -> str:
    return " x ".join(f"{length:.6g}" for length in lengths)


def _point(coordinates: Sequence[float], spacing: float) -> str:
    """A point as text, without the rounding of coordinates that are 0."""
    return f"({', '.join(f'{0.0 if abs(value) < 1e-9 * spacing else value:.6g}' for value in coordinates)})"
