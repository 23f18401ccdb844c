"""Small folders of runs that were never made, of which every number is known."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from tests.app.results import UPRIGHT, write_result
from warp_mps.particles.filling import fill_scene
from warp_mps.results.history import TIME_LABEL, History, energy_labels, write_history
from warp_mps.results.summary import RunSummary
from warp_mps.scene import Fluid, Scene, StageFrame, Wall
from warp_mps.shapes import Box
from warp_mps.usd.animation.writer import AnimationWriter

MEASURED: list[dict[str, Any]] = [
    {
        "name": "height <b>",
        "value": 0.019,
        "unit": "m",
        "reference": 0.02,
        "error": -0.05,
        "source": "by hand & eye",
        "measure": "final",
        "column": "tip.y [m]",
        "window": [0.0, None],
        "at": None,
    }
]
SETTINGS = {"description": "A block rises.\n\nIt is <not> held.", "bodies": {"block": {"spacing [m]": 0.1}}}


def write_run(folder: Path, *, frame: StageFrame = UPRIGHT, **facts: Any) -> None:
    """Write run.usdc, probes.csv and run.json of a block that rises by 0.02 m a frame above a floor."""
    write_result(folder, frame=frame, frames=3)
    write_tables(folder, **facts)


def write_tables(folder: Path, **facts: Any) -> None:
    """Write probes.csv and run.json alone."""
    times = np.linspace(0.0, 0.02, 5)
    rows = [(t, 0.0, 2.0 * t, 3.0 + t, -t, 0.0, 0.0, 0.0, 0.0) for t in times]
    write_history(folder / "probes.csv", History([TIME_LABEL, "tip.x [m]", "tip.y [m]", *energy_labels(2)], rows))
    known = {"case": "resting", "status": "done", "time": 0.02, "measurements": MEASURED, "settings": SETTINGS}
    energy = {"kinetic": 3.0, "drift": 0.0125}
    RunSummary(**{"energy": energy, "momentum_error": 2e-16, **known, **facts}).write(folder / "run.json")


def write_water(folder: Path, *, nowhere: bool = False) -> None:
    """Write run.usdc of 8 by 6 particles of water in the x-y plane, one lost, with pressures by depth.

    Args:
        folder: Where it goes.
        nowhere: Whether no particle has a place that is a number.
    """
    floor = Wall(name="floor", shape=Box((0.8, 0.3), center=(0.0, -0.45)), spacing=0.1)
    water = Fluid(name="water", shape=Box((0.8, 0.6)), spacing=0.1)
    scene = Scene(fluids=(water,), walls=(floor,), gravity=(0.0, -9.81), duration=1.0, name="water")
    particles = fill_scene(scene)
    writer = AnimationWriter(
        folder / "run.usdc",
        particles,
        scene.frame,
        frame_rate=10.0,
        provenance={"case": "water"},
        primvars=("pressure",),
    )
    for k in range(4):
        positions = particles.positions.copy()
        positions[-1] = np.nan if k == 3 else positions[-1]
        positions *= np.nan if nowhere else 1.0
        depth = 9810.0 * (0.3 - particles.positions[:, 1])
        writer.write(0.1 * k, positions, np.full_like(positions, 0.1 * k), pressure=depth)
    writer.close()
