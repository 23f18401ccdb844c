"""The commands for the results of a run; they read the run's folder and compute nothing."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from tyro.conf import Positional, arg

from warp_mps.errors import InputError

Folder = Annotated[Path, arg(metavar="DIR", help="Folder of a run, such as runs/CASE.")]
Overwrite = Annotated[bool, arg(help="Replace files that are there.")]
Colour = Annotated[
    str | None,
    arg(
        metavar="NAME",
        help="body, speed, pressure or another output; default: pressure of fluids, or else von_mises if there.",
    ),
]
Limits = Annotated[
    tuple[float, float] | None,
    arg(metavar="LOW HIGH", help="Values of the first and the last colour, in SI units; default: as the run has them."),
]
Size = Annotated[
    tuple[int, int] | None, arg(metavar="W H", help="Width and height in pixels; default: fitted to the scene.")
]
View = Annotated[
    tuple[float, float, float] | None,
    arg(metavar="X Y Z", help="Direction from the scene to the camera; default: a plane's normal, or obliquely."),
]


def convert(
    folder: Positional[Folder],
    *,
    to: Annotated[
        Literal["pvd", "vtkhdf", "usd"],
        arg(help="Format: pvd or vtkhdf, for ParaView and VTK; usd, with colours of a quantity."),
    ] = "pvd",
    colour: Colour = None,
    limits: Limits = None,
    overwrite: Overwrite = False,
) -> int:
    """Convert the animation of a run: DIR/pvd/run.pvd, with a .vtp for each body, wall or fluid and frame.

    Times are in seconds. Positions, widths and velocities are in the stage's units, as in run.usdc (the files hold
    metersPerUnit); pressures and stresses are in Pa, strain energies in J/m^3. With --to vtkhdf (needs
    warp_mps[vtkhdf]): DIR/vtkhdf/NAME.vtkhdf, one file each with all frames. With --to usd: DIR/run_QUANTITY.usdc,
    the animation with displayColor set from the quantity --colour, for usdview, Blender, Houdini or Omniverse.
    """
    if to == "usd":
        from warp_mps.app.convert.coloured_usd import convert_to_usd

        return convert_to_usd(folder, colour, limits, overwrite=overwrite)
    if colour is not None or limits is not None:
        raise InputError("--colour and --limits", "", "are for --to usd; ParaView chooses its colours")
    if to == "vtkhdf":
        from warp_mps.app.convert.vtkhdf import convert_to_vtkhdf

        return convert_to_vtkhdf(folder, overwrite=overwrite)
    from warp_mps.app.convert.pvd import convert_to_pvd

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
    from warp_mps.app.view.plot import plot_history

    print(plot_history(folder, out, overwrite=overwrite))
    return 0


def picture(
    folder: Positional[Folder],
    *,
    out: Annotated[
        Path | None, arg(metavar="FILE", help="File to write: .png or .webp; default: DIR/picture.png.")
    ] = None,
    time: Annotated[float | None, arg(metavar="S", help="Moment to draw [s]; default: the last.")] = None,
    colour: Colour = None,
    limits: Limits = None,
    size: Size = None,
    view: View = None,
    overwrite: Overwrite = False,
) -> int:
    """Draw a moment of a run: particles as shaded spheres, coloured by a quantity, with a colour bar.

    In 3-D the nearer particles hide the farther ones, and walls that stand before the others are as if of glass.
    """
    from warp_mps.app.view.picture import PictureOptions, draw_picture

    options = PictureOptions(colour, limits, size, view)
    print(draw_picture(folder, out, time=time, options=options, overwrite=overwrite))
    return 0


def video(
    folder: Positional[Folder],
    *,
    out: Annotated[
        Path | None,
        arg(metavar="FILE", help="File to write: .mp4 (needs warp_mps[video]), .webp or .gif; default: DIR/video.*."),
    ] = None,
    seconds: Annotated[
        float | None,
        arg(metavar="S", help="How long it plays [s]; default: as the animation plays, at most 20 (mp4) or 10."),
    ] = None,
    colour: Colour = None,
    limits: Limits = None,
    size: Size = None,
    view: View = None,
    overwrite: Overwrite = False,
) -> int:
    """Make a video of a run, of pictures as `warp-mps picture` draws them, all from one place."""
    from warp_mps.app.view.picture import PictureOptions
    from warp_mps.app.view.video import make_video

    options = PictureOptions(colour, limits, size, view)
    path, pictures, length = make_video(folder, out, seconds=seconds, options=options, overwrite=overwrite)
    print(f"{path}: {pictures} pictures, {length:.3g} s")
    return 0


def report(
    folder: Positional[Folder],
    *,
    out: Annotated[Path | None, arg(metavar="FILE", help="File to write, .html; default: DIR/report.html.")] = None,
    overwrite: Overwrite = False,
    watch: Annotated[bool, arg(help="Regenerate the page until the run ends; an open page reloads.")] = False,
    interval: Annotated[float, arg(metavar="S", help="Seconds between two pages of --watch.")] = 5.0,
) -> int:
    """Write a run as one HTML page that opens from the disk: DIR/report.html.

    It plays the animation, and has the measurements beside their references, the probes and energies as diagrams,
    and the settings. Everything is in SI units. Of large animations some frames are left out, which the page says.
    """
    from warp_mps.app.report.watch import report_run

    report_run(folder, out, overwrite=overwrite, interval=interval if watch else None, announce=_print_at_once)
    return 0


def _print_at_once(line: str) -> None:
    print(line, flush=True)
