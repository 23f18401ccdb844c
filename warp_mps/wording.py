"""Results in words: times, errors, and what a run did in a few lines."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from warp_mps.results import RunSummary

# a relative error that is smaller is one of rounding
ROUNDING = 1e-13


def outline(summary: RunSummary) -> str:
    """What a run did, its energies at the end, and its measurements, a line each."""
    unit = "J/m" if summary.dimension == 2 else "J"
    reason = f" ({summary.reason})" if summary.reason else ""
    energies = {name: value for name, value in summary.energy.items() if value and name != "drift"}
    shown = ", ".join(f"{name} {value:.4g}" for name, value in energies.items())
    return "\n".join(
        [
            f"{headline(summary)}; {summary.status}{reason}",
            "particles: " + ", ".join(f"{name} {count}" for name, count in summary.particles.items()),
            *([f"energy [{unit}]: {shown}"] if shown else []),
            *(f"{row['name']}: {_measured(row)}" for row in summary.measurements),
        ]
    )


def _measured(row: dict[str, Any]) -> str:
    if row["value"] is None:
        return str(row.get("reason", "none"))
    text = f"{row['value']:.5g} {row['unit']}".rstrip()
    if row["reference"] is None:
        return text
    error = f", {percent(row['error'])}" if row["error"] is not None else ""
    return f"{text} (reference {row['reference']:.5g}{error})"


def headline(summary: RunSummary) -> str:
    """How far a run came, how fast, and how accurate it was."""
    speed = sum(value or 0.0 for value in summary.particle_steps_per_second.values())
    return (
        f"{summary.case}: {summary.steps} steps, {summary.time:.6g} s simulated in {duration(summary.wall_seconds)} "
        f"({speed / 1e6:.3g} million particle-steps a second), {_account(summary)}"
    )


def _account(summary: RunSummary) -> str:
    """What tells of the accuracy of a run: its energy, or with fluids, which lose some, the pressure solves."""
    if not summary.fluid:
        return f"energy drift {percent(summary.energy.get('drift'))}"
    lost, unsolved = (int(summary.fluid.get(name, 0)) for name in ("lost", "unsolved"))
    text = f"{summary.fluid.get('pressure_iterations', 0.0):.3g} iterations a pressure solve"
    text += f", {unsolved} UNSOLVED" if unsolved else ""
    if summary.coupling:
        disagreed = int(summary.coupling.get("disagreed", 0))
        text += f", {summary.coupling.get('passes', 0.0):.3g} passes a step between water and bodies"
        text += f", {disagreed} steps DISAGREED" if disagreed else ""
    return text + (f", {lost} particles lost" if lost else "")


def percent(value: float | None) -> str:
    """A relative error as text; nothing where there is none."""
    if value is None:
        return ""
    if abs(value) < ROUNDING:
        return "0 %"
    return f"{100.0 * value:+.2f} %" if abs(value) >= 5e-5 else f"{100.0 * value:+.1e} %"


def duration(seconds: float) -> str:
    """A time as text, in the unit that suits it."""
    if seconds < 120.0:
        return f"{seconds:.2g} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 7200.0 else f"{seconds / 3600.0:.1f} h"
