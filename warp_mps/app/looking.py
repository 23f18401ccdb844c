"""The commands that look at the results of a run; they read the run's folder and compute nothing anew."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from tyro.conf import Positional, arg

Folder = Annotated[Path, arg(metavar="DIR", help="Folder of a run, such as runs/CASE.")]
Overwrite = Annotated[bool, arg(help="Replace files that are there.")]


def convert(
    folder: Positional[Folder],
    *,
    to: Annotated[Literal["pvd"], arg(help="Format: pvd, for ParaView, VisIt and VTK.")] = "pvd",
    overwrite: Overwrite = False,
) -> int:
    """Convert the animation of a run: DIR/pvd/run.pvd, with a .vtp for each body, wall or fluid and frame.

    Times are in seconds. Positions, widths and velocities are in the stage's units, as in run.usdc (the files hold
    metersPerUnit); pressures and stresses are in Pa, strain energies in J/m^3.
    """
    from warp_mps.app.convert import convert_to_pvd

    assert to == "pvd"
    return convert_to_pvd(folder, overwrite=overwrite)


def plot(
    folder: Positional[Folder],
    *,
    out: Annotated[
        Path | None, arg(metavar="FILE", help="File to write: .png, .svg or .pdf; default: DIR/probes.png.")
    ] = None,
    overwrite: Overwrite = False,
) -> int:
    """Draw every probe and the energies of a run against time [s], in the units of probes.csv.

    References of the case are drawn where they are values of a probe; of the potential energy its change.
    """
    from warp_mps.app.plot import plot_history

    return plot_history(folder, out, overwrite=overwrite)
