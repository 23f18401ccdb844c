"""Where a prim is: the transforms of it and of the prims above it, which must be the same at every time."""

from __future__ import annotations

import numpy as np
from pxr import Sdf, Tf, Usd, UsdGeom, Vt

from warp_mps.errors import InputError
from warp_mps.scene.validation.rules import LARGEST
from warp_mps.usd.case.authored import ANY_TIME, check_kind, constant
from warp_mps.usd.case.diagnostics import reason_of

ORDER, RESET = "xformOpOrder", "!resetXformStack!"
INVERSE = "!invert!"


def world_matrix(prim: Usd.Prim) -> np.ndarray:
    """Matrix from a prim's coordinates to the stage's, columns are the images of its axes, shape [4, 4].

    Raises:
        InputError: It cannot be read, or varies in time, which a case does by motions, not by transforms.
    """
    ancestor = prim
    while ancestor:
        _check_transform(ancestor)
        ancestor = ancestor.GetParent()
    return np.array(UsdGeom.XformCache(ANY_TIME).GetLocalToWorldTransform(prim)).T


def _check_transform(prim: Usd.Prim) -> None:
    """Refuse the transform of one prim if it varies in time, or cannot be read."""
    transform, path = UsdGeom.Xformable(prim), str(prim.GetPath())
    if not transform:
        return
    try:
        check_kind(prim, ORDER, Sdf.AttributeSpec)
        attribute = transform.GetXformOpOrderAttr()
        order = constant(attribute)
        # USD asks for its default only
        if attribute.GetNumTimeSamples() or not isinstance(order, Vt.TokenArray | None):
            raise InputError(path, ORDER, "must be a token[] without time samples")
        # an order may name an operation many times
        for name in sorted({name.removeprefix(INVERSE) for name in order or ()}):
            _check_operation(prim, name)
        matrix = np.array(transform.GetLocalTransformation(ANY_TIME))
    except Tf.ErrorException as error:
        raise InputError(path, ORDER, f"cannot be read: {reason_of(error)}") from None
    if not np.abs(matrix).max() <= LARGEST:
        raise InputError(path, ORDER, f"makes a matrix that is not finite, or above {LARGEST:g}")


def _check_operation(prim: Usd.Prim, name: str) -> None:
    """Refuse an operation of a transform that varies in time, or that has no value, which USD would leave out."""
    if name == RESET:
        return
    path, attribute = str(prim.GetPath()), prim.GetAttribute(name)
    check_kind(prim, name, Sdf.AttributeSpec)
    if attribute and attribute.ValueMightBeTimeVarying():
        reason = "varies in time; a support or a wall moves by mps:motion:amplitude or mps:motion:times"
        raise InputError(path, name, reason)
    if not attribute or constant(attribute) is None:
        raise InputError(path, name, f"has no value, but {ORDER} names it")
