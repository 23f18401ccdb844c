"""Shapes as prims with a geometry."""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, Vt

from warp_mps.errors import InputError
from warp_mps.shapes import Box, Cylinder, Mesh, Points, Shape, Sphere
from warp_mps.shapes.primitives import AXIS_NAMES
from warp_mps.usd.case.composites import BORE, operations
from warp_mps.usd.case.frame import Frame

# Depth of infinitely deep shapes in a 3-D scene, in units of its width.
DEEP = 1e6
# scope of the shapes that others are joined with
SHAPES = "/World/Shapes"


def save_shape(stage: Usd.Stage, path: str, shape: Shape, frame: Frame) -> Usd.Prim:
    """Define the prim of a shape, and those of the shapes that it is joined with.

    Args:
        stage: Stage that it is written to.
        path: Path of the prim; those that it is joined with stand in the scope `SHAPES`, as guides.
        shape: The shape, in the scene's coordinates.
        frame: Units and axes of the stage.

    Returns:
        The prim, with its extent and transform.

    Raises:
        InputError: The shape is of a kind that a stage cannot hold.
    """
    base, joined = operations(shape)
    prim = _save_leaf(stage, path, base, frame)
    for name, others in joined.items():
        if not others:
            continue
        UsdGeom.Scope.Define(stage, SHAPES)
        paths = []
        for other in others:
            paths.append(_free_path(stage, path))
            UsdGeom.Imageable(save_shape(stage, paths[-1], other, frame)).CreatePurposeAttr(UsdGeom.Tokens.guide)
        prim.CreateRelationship(name, custom=False).SetTargets(paths)
    return prim


def _free_path(stage: Usd.Stage, owner: str) -> str:
    """A path in the scope `SHAPES` that no prim has yet, named after the prim that is joined with it."""
    stem = re.sub(r"_shape_\d+$", "", owner.rpartition("/")[2])
    return next(path for n in itertools.count(1) if not stage.GetPrimAtPath(path := f"{SHAPES}/{stem}_shape_{n}"))


def _save_leaf(stage: Usd.Stage, path: str, shape: Shape, frame: Frame) -> Usd.Prim:
    turned = in_stage(shape, frame)
    save = _SAVERS.get(type(turned))
    if save is None:
        raise InputError(path, "", f"a {type(shape).__name__} cannot be saved")
    gprim = save(stage, path, turned, frame.stage.meters_per_unit)
    gprim.CreateExtentAttr(UsdGeom.Boundable.ComputeExtentFromPlugins(gprim, Usd.TimeCode.Default()))
    return gprim.GetPrim()


def in_stage(shape: Any, frame: Frame) -> Shape:
    """The shape in the stage's coordinates, still in metres, finite along every axis."""
    turn = frame.rotation.T
    if isinstance(shape, Points):
        positions = shape.to_scene(shape.positions) @ turn.T
        return Points(positions, None if shape.velocities is None else shape.velocities @ turn.T)
    shape = _finite(shape, frame.dimension)
    if shape.placement is not None or isinstance(shape, Mesh):
        placement = np.eye(4)
        placement[:3] = turn @ (np.eye(4) if shape.placement is None else shape.placement)[:3]
        return replace(shape, placement=None if np.array_equal(placement, np.eye(4)) else placement)
    # The turn swaps axes and signs: boxes, spheres and cylinders need no transform to follow it.
    center = tuple((turn @ np.asarray(shape.center)).tolist())
    if isinstance(shape, Box):
        return Box(tuple((np.abs(turn) @ np.asarray(shape.size)).tolist()), center)
    if isinstance(shape, Cylinder):
        return replace(shape, center=center, axis=AXIS_NAMES[_turned(turn, AXIS_NAMES.index(shape.axis))])
    return replace(shape, center=center)


def lattice_axes(shape: Shape, axes: Sequence[int], frame: Frame) -> str:
    """Names of axes of a shape, or of the first of those that it is made of, once it is in the stage."""
    shape = shape.leaves()[0]
    own = shape.placement is not None or isinstance(shape, Mesh)
    return "".join("xyz"[axis if own else _turned(frame.rotation.T, axis)] for axis in axes)


def _turned(turn: np.ndarray, axis: int) -> int:
    return int(np.argmax(np.abs(turn[:, axis])))


def _finite(shape: Any, dimension: int) -> Any:
    """The shape, with a finite depth if it is infinitely deep: a 2-D scene uses its section alone."""
    if isinstance(shape, Box) and not np.isfinite(shape.size).all():
        largest = max((length for length in shape.size if np.isfinite(length)), default=1.0)
        depth = min(*shape.size, largest) if dimension == 2 else DEEP * largest
        return replace(shape, size=tuple(length if np.isfinite(length) else depth for length in shape.size))
    if isinstance(shape, Cylinder) and not np.isfinite(shape.height):
        return replace(shape, height=2 * shape.radius if dimension == 2 else DEEP * shape.radius)
    return shape


def _box(stage: Usd.Stage, path: str, shape: Box, unit: float) -> UsdGeom.Gprim:
    cube = UsdGeom.Cube.Define(stage, path)
    cube.CreateSizeAttr(1.0)
    _place(cube, shape.placement, unit, shape.center)
    scale = Gf.Vec3d(*(np.asarray(shape.size) / unit).tolist())
    cube.AddScaleOp(UsdGeom.XformOp.PrecisionDouble).Set(scale)
    return cube


def _sphere(stage: Usd.Stage, path: str, shape: Sphere, unit: float) -> UsdGeom.Gprim:
    sphere = UsdGeom.Sphere.Define(stage, path)
    sphere.CreateRadiusAttr(shape.radius / unit)
    _place(sphere, shape.placement, unit, shape.center)
    return sphere


def _cylinder(stage: Usd.Stage, path: str, shape: Cylinder, unit: float) -> UsdGeom.Gprim:
    cylinder = UsdGeom.Cylinder.Define(stage, path)
    cylinder.CreateRadiusAttr(shape.radius / unit)
    cylinder.CreateHeightAttr(shape.height / unit)
    cylinder.CreateAxisAttr(shape.axis.upper())
    _place(cylinder, shape.placement, unit, shape.center)
    if shape.inner_radius > 0:
        bore = cylinder.GetPrim().CreateAttribute(BORE, Sdf.ValueTypeNames.Double, custom=False)
        bore.Set(shape.inner_radius / unit)
    return cylinder


def _mesh(stage: Usd.Stage, path: str, shape: Mesh, unit: float) -> UsdGeom.Gprim:
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr(_vectors(shape.points / unit))
    mesh.CreateFaceVertexCountsAttr([3] * len(shape.triangles))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(shape.triangles.astype(np.int32).ravel()))
    mesh.CreateSubdivisionSchemeAttr("none")
    _place(mesh, shape.placement, unit)
    return mesh


def _points(stage: Usd.Stage, path: str, shape: Points, unit: float) -> UsdGeom.Gprim:
    points = UsdGeom.Points.Define(stage, path)
    points.CreatePointsAttr(_vectors(shape.positions / unit))
    if shape.velocities is not None:
        points.CreateVelocitiesAttr(_vectors(shape.velocities / unit))
    return points


def _place(
    gprim: UsdGeom.Gprim, placement: np.ndarray | None, unit: float, center: Sequence[float] = (0.0, 0.0, 0.0)
) -> None:
    if placement is not None:
        matrix = placement.copy()
        matrix[:3, 3] /= unit
        gprim.AddTransformOp().Set(Gf.Matrix4d(matrix.T.tolist()))
    if any(center):
        gprim.AddTranslateOp().Set(Gf.Vec3d(*(np.asarray(center) / unit).tolist()))


def _vectors(rows: np.ndarray) -> Vt.Vec3fArray:
    return Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(rows, np.float32))


_SAVERS: dict[type, Callable[..., UsdGeom.Gprim]] = {
    Box: _box,
    Sphere: _sphere,
    Cylinder: _cylinder,
    Mesh: _mesh,
    Points: _points,
}
