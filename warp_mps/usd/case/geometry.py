"""Prims with a geometry, as shapes in the scene's coordinates."""

from __future__ import annotations

import numpy as np
from pxr import Usd, UsdGeom

from warp_mps.errors import InputError
from warp_mps.shapes import Box, Cylinder, Mesh, Points, Shape, Sphere
from warp_mps.shapes.lattice import rigid_axes
from warp_mps.usd.case.attributes import ROLE
from warp_mps.usd.case.authored import is_given
from warp_mps.usd.case.frame import Frame
from warp_mps.usd.case.prim_values import typed
from warp_mps.usd.case.stage_errors import stage_error
from warp_mps.usd.case.transforms import world_matrix

KINDS = ("Cube", "Sphere", "Cylinder", "Mesh", "Points")


def has_shape(prim: Usd.Prim) -> bool:
    """Whether a prim is a geometry, one that can be read or not."""
    return bool(prim.IsA(UsdGeom.Gprim))


def geometry_of(prim: Usd.Prim) -> Usd.Prim:
    """The geometry that a prim stands for: itself, or the only one below an Xform, as programs export their objects.

    Geometries that have a role of their own, or lie below a prim that has one, are not meant.

    Raises:
        InputError: There are several below it, or a PointInstancer.
    """
    if prim.GetTypeName() not in ("Xform", ""):
        return prim
    found = []
    below = iter(Usd.PrimRange(prim, Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)))
    for other in below:
        if other != prim and is_given(other, ROLE):
            below.PruneChildren()
        elif other.IsA(UsdGeom.PointInstancer):
            reason = (
                f"stands above the PointInstancer {other.GetPath()}, whose copies are not read: make a prim of each"
            )
            raise InputError(str(prim.GetPath()), ROLE, reason)
        elif has_shape(other):
            found.append(other)
    if len(found) > 1:
        paths = f"{found[0].GetPath()} and {found[1].GetPath()}"
        reason = f"has {len(found)} geometries below it, such as {paths}: give each a role, or join them by mps:plus"
        raise InputError(str(prim.GetPath()), "", reason)
    return found[0] if found else prim


def read_shape(prim: Usd.Prim, frame: Frame, inner_radius: float | None = None) -> Shape:
    """Shape of a prim.

    Args:
        prim: A prim of one of `KINDS`.
        frame: Units and axes.
        inner_radius: Radius of the bore of a cylinder [m], None if it is not given.

    Returns:
        The shape, in metres and in the scene's coordinates.

    Raises:
        InputError: It is of another type, or its numbers are impossible.
    """
    path, kind = str(prim.GetPath()), str(prim.GetTypeName())
    if kind not in KINDS:
        allowed = f"must be one of: {', '.join(KINDS)}, or an Xform above one of them"
        raise InputError(path, "", f"is {kind or 'a prim without a type'}, {allowed}")
    placement = frame.placement(world_matrix(prim))
    if not np.isfinite(placement).all() or abs(np.linalg.det(placement[:3, :3])) < 1e-300:
        raise InputError(path, "xformOpOrder", "the transform flattens the shape: no scale may be zero")
    try:
        if kind == "Cylinder":
            return _cylinder(UsdGeom.Cylinder(prim), frame, placement, inner_radius or 0.0)
        if inner_radius is not None:
            raise InputError(path, "mps:innerRadius", f"is of a Cylinder, not of a {kind}")
        return _READERS[kind](prim, frame, placement)
    except InputError as error:
        said = stage_error(error, frame.stage)
        raise InputError(path, said.attribute, said.reason) from None


def _box(prim: Usd.Prim, frame: Frame, placement: np.ndarray) -> Shape:
    size = typed(UsdGeom.Cube(prim).GetSizeAttr(), "double") * frame.stage.meters_per_unit
    axes = rigid_axes(placement[:3, :3])
    if axes is None:
        return Box((size, size, size), placement=placement)
    lengths = tuple((size * np.linalg.norm(placement[:3, :3], axis=0)).tolist())
    center, rest = _rigid(axes, placement)
    return Box(lengths, center, placement=rest)


def _sphere(prim: Usd.Prim, frame: Frame, placement: np.ndarray) -> Shape:
    radius = typed(UsdGeom.Sphere(prim).GetRadiusAttr(), "double") * frame.stage.meters_per_unit
    axes, scales = rigid_axes(placement[:3, :3]), np.linalg.norm(placement[:3, :3], axis=0)
    if axes is None or not np.allclose(scales, scales[0], rtol=1e-9):
        return Sphere(radius, placement=placement)
    center, rest = _rigid(axes, placement)
    return Sphere(radius * scales[0].item(), center, placement=rest)


def _cylinder(prim: UsdGeom.Cylinder, frame: Frame, placement: np.ndarray, inner_radius: float) -> Shape:
    unit, axis = frame.stage.meters_per_unit, typed(prim.GetAxisAttr(), "token").lower()
    if axis not in ("x", "y", "z"):
        raise InputError("", "axis", f"is {axis!r}, must be X, Y or Z")
    radius, height = (typed(item, "double") * unit for item in (prim.GetRadiusAttr(), prim.GetHeightAttr()))
    axes, scales = rigid_axes(placement[:3, :3]), np.linalg.norm(placement[:3, :3], axis=0)
    along = "xyz".index(axis)
    across = np.delete(scales, along)
    if axes is None or not np.allclose(across, across[0], rtol=1e-9):
        return Cylinder(radius, height, axis, inner_radius=inner_radius, placement=placement)
    center, rest = _rigid(axes, placement)
    wide, long = across[0].item(), scales[along].item()
    return Cylinder(radius * wide, height * long, axis, center, inner_radius * wide, placement=rest)


def _mesh(prim: Usd.Prim, frame: Frame, placement: np.ndarray) -> Shape:
    mesh, path = UsdGeom.Mesh(prim), str(prim.GetPath())
    points, counts, indices = (
        _array(attribute, kind)
        for attribute, kind in (
            (mesh.GetPointsAttr(), "point3f[]"),
            (mesh.GetFaceVertexCountsAttr(), "int[]"),
            (mesh.GetFaceVertexIndicesAttr(), "int[]"),
        )
    )
    if not len(points) or not len(counts):
        raise InputError(path, "points" if not len(points) else "faceVertexCounts", "is empty")
    if counts.min() < 3 or counts.sum() != len(indices):
        reason = f"must be at least 3 a face and {len(indices)} in sum, the length of faceVertexIndices"
        raise InputError(path, "faceVertexCounts", reason)
    if indices.min() < 0 or indices.max() >= len(points):
        raise InputError(path, "faceVertexIndices", f"must be from 0 to {len(points) - 1}, the last of the points")
    metres = points * frame.stage.meters_per_unit
    return Mesh(
        metres,
        _fans(counts.astype(int), indices.astype(int)),
        placement=None if np.array_equal(placement, np.eye(4)) else placement,
    )


def _points(prim: Usd.Prim, frame: Frame, placement: np.ndarray) -> Shape:
    points = UsdGeom.Points(prim)
    positions, velocities = (
        _array(attribute, kind).reshape(-1, 3) * frame.stage.meters_per_unit
        for attribute, kind in ((points.GetPointsAttr(), "point3f[]"), (points.GetVelocitiesAttr(), "vector3f[]"))
    )
    if not len(positions):
        raise InputError(str(prim.GetPath()), "points", "is empty")
    turned = velocities @ placement[:3, :3].T
    if frame.dimension == 2 and len(turned) and abs(turned[:, 2]).max() > 1e-6 * abs(turned).max():
        reason = f"must lie in the plane {frame.stage.axes} of this 2-D scene"
        raise InputError(str(prim.GetPath()), "velocities", reason)
    return Points(positions @ placement[:3, :3].T + placement[:3, 3], turned if len(turned) else None)


def _array(attribute: Usd.Attribute, kind: str) -> np.ndarray:
    """An array, empty if it is not given."""
    return typed(attribute, kind) if is_given(attribute.GetPrim(), attribute.GetName()) else np.zeros(0)


def _rigid(axes: np.ndarray, placement: np.ndarray) -> tuple[tuple[float, ...], np.ndarray | None]:
    """Centre and placement of a shape that is symmetric about its axes, once its scale is in its lengths."""
    if np.allclose(np.abs(axes), np.eye(3), atol=1e-12):
        return tuple(placement[:3, 3].tolist()), None
    rest = np.eye(4)
    rest[:3, :3], rest[:3, 3] = axes, placement[:3, 3]
    return (0.0, 0.0, 0.0), rest


def _fans(counts: np.ndarray, indices: np.ndarray) -> np.ndarray:
    """Triangles of polygons, each a fan about its first vertex, shape [m, 3]."""
    firsts = np.repeat(np.cumsum(counts) - counts, counts - 2)
    within = np.arange(len(firsts)) - np.repeat(np.cumsum(counts - 2) - (counts - 2), counts - 2)
    return indices[np.stack([firsts, firsts + within + 1, firsts + within + 2], axis=1)]


_READERS = {"Cube": _box, "Sphere": _sphere, "Mesh": _mesh, "Points": _points}
