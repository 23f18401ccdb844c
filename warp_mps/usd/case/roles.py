"""The prims of a stage by their roles, and the names that they take in the scene."""

from __future__ import annotations

from pxr import Usd, UsdGeom, UsdPhysics, UsdShade

from warp_mps.errors import InputError
from warp_mps.usd.case.attributes import ROLE, ROLES, TABLE
from warp_mps.usd.case.authored import constant, is_given
from warp_mps.usd.case.geometry import has_shape
from warp_mps.usd.case.stage_attribute import SHAPE

# the schemas that describe prims without a role
_SCHEMAS = ("MpsSceneAPI", "MpsMaterialAPI", "MpsLiquidAPI")


def by_role(prims: list[Usd.Prim]) -> dict[str, list[Usd.Prim]]:
    """The prims of each role.

    Raises:
        InputError: A prim has a role that is not known, or has none and attributes that mean nothing without one; or a
            PointInstancer makes copies of a prim with a role, which are not read.
    """
    parts: dict[str, list[Usd.Prim]] = {role: [] for role in ROLES}
    for prim in prims:
        if not is_given(prim, ROLE):
            _check_without_role(prim)
            continue
        role = constant(prim.GetAttribute(ROLE))
        if role not in parts:
            raise InputError(str(prim.GetPath()), ROLE, f"is {role!r}, must be one of: {', '.join(ROLES)}")
        parts[role].append(prim)
    _check_copies(prims, [prim for found in parts.values() for prim in found])
    return parts


def unique_names(prims: list[Usd.Prim]) -> dict[str, str]:
    """Name of each path: the prim's, or where two are equal, the whole path's."""
    short = [prim.GetName() for prim in prims]
    names: dict[str, str] = {}
    for prim in prims:
        path = str(prim.GetPath())
        name = prim.GetName() if short.count(prim.GetName()) == 1 else path.strip("/").replace("/", "_")
        while name in names.values() or (name != prim.GetName() and name in short):
            name += "_"
        names[path] = name
    return names


def measurement_names(prims: list[Usd.Prim]) -> dict[str, str]:
    """Name of each path: the prim's display name or else its name, with the path where two are equal."""
    shown = [prim.GetDisplayName() or prim.GetName() for prim in prims]
    paths = [str(prim.GetPath()) for prim in prims]
    return {
        path: name if shown.count(name) == 1 else f"{name} ({path})" for path, name in zip(paths, shown, strict=True)
    }


def _check_copies(prims: list[Usd.Prim], parts: list[Usd.Prim]) -> None:
    """Refuse prims with a role that a PointInstancer draws, many times and elsewhere."""
    for prim in prims:
        if not prim.IsA(UsdGeom.PointInstancer):
            continue
        drawn = [prim.GetPath(), *UsdGeom.PointInstancer(prim).GetPrototypesRel().GetTargets()]
        for part in parts:
            if any(part.GetPath().HasPrefix(path) for path in drawn):
                reason = (
                    f"is drawn by the PointInstancer {prim.GetPath()}, whose copies are not read: make a prim of each"
                )
                raise InputError(str(part.GetPath()), ROLE, reason)


def _check_without_role(prim: Usd.Prim) -> None:
    """Refuse what would have no effect on a prim without a role: most likely the role is missing or misspelt."""
    path, names = str(prim.GetPath()), prim.GetAuthoredPropertyNames()
    # as they are written: USD itself leaves out those that it does not know
    applied = prim.GetMetadata("apiSchemas")
    written = applied.GetAddedOrExplicitItems() if applied else []
    schemas = [name for name in written if name.startswith("Mps") and name not in _SCHEMAS]
    # a role that a stronger layer blocks is switched off on purpose
    if ROLE in names:
        return
    if schemas:
        raise InputError(path, "apiSchemas", f"has no effect: {schemas[0]} is for a prim that has {ROLE}")
    known = _known_without_role(prim)
    for name in names:
        if name.startswith("mps:") and name not in known:
            allowed = f"; without one, it may have {', '.join(known)}" if known else ""
            raise InputError(path, name, f"has no effect: the prim has no {ROLE}{allowed}")


def _known_without_role(prim: Usd.Prim) -> tuple[str, ...]:
    """The attributes that a prim may have without a role."""
    if prim.IsA(UsdPhysics.Scene):
        return tuple(TABLE["scene"])
    if prim.IsA(UsdShade.Material):
        return (*TABLE["material"], *TABLE["liquid"])
    # geometries that others are joined with
    return tuple(row.name for row in SHAPE) if has_shape(prim) else ()
