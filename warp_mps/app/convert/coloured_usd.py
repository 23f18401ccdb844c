"""An animation with particles coloured by a quantity."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
from pxr import Gf, Tf, Usd, UsdGeom, Vt

from warp_mps.app.animation_reader import Animation, refuse_existing
from warp_mps.app.view import figures
from warp_mps.app.view.colours import choose_colouring, has_colour
from warp_mps.errors import InputError
from warp_mps.usd.animation.colours import srgb_to_linear


def convert_to_usd(
    folder: Path, colour: str | None, limits: tuple[float, float] | None, *, overwrite: bool = False
) -> int:
    """Write a copy of a run's animation with ``displayColor`` set from a quantity in every frame.

    The file is ``run_QUANTITY.usdc`` in the folder. The colours are those of pictures and videos, as amounts of light,
    which is what USD takes them for; walls keep theirs. customLayerData says what the ends of the colours stand for.

    Args:
        folder: Folder of the run.
        colour: ``speed`` or a quantity of the run; None is as for pictures.
        limits: Values of the first and the last colour [SI units]; None takes them from the run.
        overwrite: Whether to replace the file.

    Raises:
        InputError: There is no run in the folder, it has no such quantity, or the file cannot be written.
    """
    animation = Animation(folder, finite=True)
    colouring = choose_colouring(animation, colour, limits)
    if colouring.name == "body":
        raise InputError("--colour", "", f"is body, which is what {animation.path.name} has; give a quantity, or speed")
    path = folder / f"run_{colouring.name}.usdc"
    refuse_existing(path, overwrite)

    def write(temporary: Path) -> None:
        shutil.copyfile(animation.path, temporary)
        stage = Usd.Stage.Open(str(temporary))
        for cloud, points in enumerate(animation.prims(stage)):
            if has_colour(animation, cloud, colouring.name):
                primvar = points.GetDisplayColorPrimvar()
                primvar.GetAttr().Clear()
                primvar.SetInterpolation(UsdGeom.Tokens.vertex)
                for frame, code in enumerate(animation.codes):
                    light = srgb_to_linear(colouring.colors(animation, cloud, frame)).astype(np.float32)
                    primvar.Set(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(light)), code)
        data = dict(stage.GetRootLayer().customLayerData)
        data |= {"colours": colouring.label, "colours from and to [SI]": Gf.Vec2d(colouring.low, colouring.high)}
        stage.GetRootLayer().customLayerData = data
        try:
            stage.GetRootLayer().Save()
        except Tf.ErrorException as error:
            raise OSError(0, "the disk may be full") from error

    figures.write_file(path, write)
    factor, _ = colouring.prefix
    name, _, unit = colouring.label.rstrip("]").partition(" [")
    print(f"{path}: displayColor is the {name}, from {colouring.low / factor:g} to {colouring.high / factor:g} {unit}")
    return 0
