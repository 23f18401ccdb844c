"""Results in the formats of other programs."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from warp_mps.app.animation_reader import UNITS, Animation, refuse_existing, refuse_link
from warp_mps.app.convert.vtp import collection, polydata
from warp_mps.errors import InputError
from warp_mps.results.atomic_write import create_file, write_whole


def convert_to_pvd(folder: Path, *, overwrite: bool = False) -> int:
    """Write a run for ParaView, in `folder`/pvd: a ``.vtp`` for each body and frame, and ``run.pvd``, which lists them.

    A wall at rest has one file for all frames. Points, velocities and widths stay in the stage's units, the other
    quantities in SI units; the files say so.

    Args:
        folder: Folder of the run.
        overwrite: Whether to replace files that are there.

    Raises:
        InputError: There is no run in the folder, or the files exist, or they cannot be written.
    """
    animation = Animation(folder, finite=True)
    target = folder / "pvd"
    refuse_existing(target / "run.pvd", overwrite)
    refuse_link(target)
    try:
        files = _write(animation, target)
    except OSError as error:
        raise InputError(str(target), "", f"cannot be written: {error.strerror}") from error
    unit, count = animation.meters_per_unit, len({name for _, _, name in files})
    print(
        f"{count} files, {len(animation)} frames; open {target / 'run.pvd'} in ParaView. Positions are in the "
        f"stage's units of {unit:g} m, as in {animation.path.name}; pressures and stresses in Pa."
    )
    return 0


def _write(animation: Animation, target: Path) -> list[tuple[float, str, str]]:
    target.mkdir(exist_ok=True)
    # without the list the folder is no result, so that it goes first and comes last
    (target / "run.pvd").unlink(missing_ok=True)
    for cloud in animation.clouds:
        for old in target.glob(f"{cloud.name}_[0-9]*.vtp"):
            old.unlink()
    digits = max(4, len(str(len(animation) - 1)))
    files, last = [], dict[str, tuple[str, str]]()
    for frame, time in enumerate(animation.times):
        for number, cloud in enumerate(animation.clouds):
            content = _content(animation, number, frame)
            # walls at rest are the same in every frame, and stand in one file
            if last.get(cloud.name, ("", ""))[1] != content:
                name = f"{cloud.name}_{frame:0{digits}d}.vtp"
                with create_file(target / name) as file:
                    file.write(content.encode())
                last[cloud.name] = (name, content)
            files.append((float(time), cloud.name, last[cloud.name][0]))
    write_whole(target / "run.pvd", collection(files))
    return files


def _content(animation: Animation, number: int, frame: int) -> str:
    """The text of a file; only those of bodies and fluids state their time."""
    cloud = animation.clouds[number]
    quantities = animation.quantities(number, frame)
    arrays = {
        "id": cloud.ids,
        "width": cloud.widths,
        "velocity": animation.velocities(number, frame).astype(np.float32),
        **{name: values.astype(np.float32) for name, values in quantities.items()},
    }
    facts: dict[str, str | float] = {
        **({} if cloud.role == "wall" else {"TimeValue": float(animation.times[frame])}),
        "metersPerUnit": animation.meters_per_unit,
        "kilogramsPerUnit": animation.kilograms_per_unit,
        "upAxis": animation.up_axis,
        "role": cloud.role,
        **{name: value if isinstance(value, str) else float(value) for name, value in animation.provenance.items()},
    }
    points = animation.points(number, frame).astype(animation.point_type)
    return polydata(points, arrays, units=units_of(animation), facts=facts)


def units_of(animation: Animation) -> dict[str, str]:
    """Units of the arrays at the particles, by name."""
    length = _length_unit(animation.meters_per_unit)
    return {**UNITS, "width": length, "velocity": f"{length}/s"}


def _length_unit(meters: float) -> str:
    known = {1.0: "m", 0.01: "cm", 0.001: "mm", 1000.0: "km"}
    return next((name for size, name in known.items() if np.isclose(size, meters, rtol=1e-9)), f"{meters:g} m")
