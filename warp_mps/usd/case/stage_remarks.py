"""What is doubtful about a stage, though it can be read: its units, those of its assets, and transforms without effect.

USD converts no units: what a layer of another unit holds is read in the unit of the stage.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np
from pxr import Pcp, Sdf, Usd, UsdGeom, UsdPhysics

from warp_mps.shapes import Shape
from warp_mps.usd.case.attributes import ROLE, TABLE
from warp_mps.usd.case.authored import ANY_TIME
from warp_mps.usd.case.frame import Frame
from warp_mps.usd.case.transforms import ORDER, world_matrix

# relative difference up to which units, or the scales that convert them, are the same
SAME = 1e-6
LENGTH, MASS, UP = "metersPerUnit", "kilogramsPerUnit", "upAxis"


def stage_remarks(stage: Usd.Stage, parts: Sequence[Usd.Prim], shapes: Sequence[Shape], frame: Frame) -> list[str]:
    """Remarks on a stage, a line each: the prim or the file, the number, the remedy.

    Args:
        stage: The stage.
        parts: The prims that take part in the case.
        shapes: What its bodies, walls and fluids fill, in metres.
        frame: Units and axes.
    """
    chain = _with_ancestors(parts)
    found = [*_unit_of_stage(stage, shapes, frame), *_unsaved(stage), *_sublayers(stage)]
    for prim in chain:
        found.extend(_without_effect(prim))
        found.extend(_assets(prim, stage))
    return [*found, *_lengths_of_assets(parts, stage)]


def _with_ancestors(prims: Iterable[Usd.Prim]) -> list[Usd.Prim]:
    """Prims and those above them, each once, the upper ones first."""
    chain = {}
    for prim in prims:
        for path in prim.GetPath().GetPrefixes():
            chain[path] = prim.GetStage().GetPrimAtPath(path)
    return [chain[path] for path in sorted(chain)]


def _unit_of_stage(stage: Usd.Stage, shapes: Sequence[Shape], frame: Frame) -> Iterator[str]:
    if UsdGeom.StageHasAuthoredMetersPerUnit(stage) or not shapes:
        return
    bounds = [[shape.interval(axis) for axis in np.eye(3)[: frame.dimension]] for shape in shapes]
    finite = np.array(bounds)[np.isfinite(bounds).all(axis=(1, 2))]
    if not len(finite):
        return
    size = finite[:, :, 1].max(axis=0) - finite[:, :, 0].min(axis=0)
    yield (
        f"{LENGTH}: is not given, so that it is USD's {frame.stage.meters_per_unit:g} m: the case is "
        f"{' x '.join(f'{length:.4g}' for length in size)} m; give {LENGTH} = 1 if its numbers are metres"
    )


def _unsaved(stage: Usd.Stage) -> Iterator[str]:
    for layer in stage.GetUsedLayers():
        if layer.dirty and not layer.anonymous:
            yield f"{layer.GetDisplayName()}: has changes in this process that are not saved; they are read, too"


def _sublayers(stage: Usd.Stage) -> Iterator[str]:
    for layer in stage.GetLayerStack(includeSessionLayers=False)[1:]:
        for name, own, other in _differences(layer, stage):
            yield (
                f"{layer.GetDisplayName()}: says {name} = {own}, which USD ignores in a sublayer: its numbers count "
                f"with {other}; give it the same {name}, or refer to it below a prim that converts it"
            )


def _without_effect(prim: Usd.Prim) -> Iterator[str]:
    """Operations of a transform that its order does not name."""
    order = UsdGeom.Xformable(prim).GetXformOpOrderAttr() if prim.IsA(UsdGeom.Xformable) else None
    named = (order.Get() or ()) if order else ()
    for name in prim.GetAuthoredPropertyNames():
        if name.startswith("xformOp:") and not {name, f"!invert!{name}"} & {*named}:
            yield f"{prim.GetPath()} {name}: has no effect, for {ORDER} does not name it; add it there"


def _assets(prim: Usd.Prim, stage: Usd.Stage) -> Iterator[str]:
    """Units and axes of what a prim refers to, unless a transform converts them."""
    for layer in _referenced(prim):
        for name, own, other in _differences(layer, stage):
            if name == LENGTH and not _scaled(prim, own / other):
                remedy = f"give the prim xformOp:scale = {own / other:g} along every axis"
                yield f"{_of(prim, layer)}, whose unit is {own:g} m, but 1 in it is read as {other:g} m: {remedy}"
            if name == UP and not _turned(prim, own, other):
                remedy = f"turn the prim so that its {own} axis points along {other}"
                yield f"{_of(prim, layer)}, whose up axis is {own}, but that of the stage is {other}: {remedy}"
            if name == MASS:
                remedy = "give its masses and densities in the unit of the stage"
                said = f"whose unit of mass is {own:g} kg, but 1 in it is read as {other:g} kg"
                yield f"{_of(prim, layer)}, {said}: {remedy}"


def _lengths_of_assets(parts: Sequence[Usd.Prim], stage: Usd.Stage) -> Iterator[str]:
    """Attributes with a unit of length that layers of another unit give: no transform converts them."""
    for prim in parts:
        rows = TABLE[prim.GetAttribute(ROLE).Get(ANY_TIME)]
        for name in prim.GetAuthoredPropertyNames():
            layer = prim.GetProperty(name).GetPropertyStack()[0].layer
            units = [(own, other) for kind, own, other in _differences(layer, stage) if kind == LENGTH]
            if name in rows and rows[name].length and units:
                said = f"comes from {layer.GetDisplayName()}, whose unit is {units[0][0]:g} m"
                read = f"but is read in units of {units[0][1]:g} m"
                yield f"{prim.GetPath()} {name}: {said}, {read}: give it in the stage"


def _of(prim: Usd.Prim, layer: Sdf.Layer) -> str:
    return f"{prim.GetPath()}: refers to {layer.GetDisplayName()}"


def _referenced(prim: Usd.Prim) -> list[Sdf.Layer]:
    """The layers that a prim itself, not one above it, refers to."""
    kinds = (Pcp.ArcTypeReference, Pcp.ArcTypePayload)
    arcs = Usd.PrimCompositionQuery(prim).GetCompositionArcs()
    return [arc.GetTargetLayer() for arc in arcs if arc.GetArcType() in kinds and not arc.IsAncestral()]


def _differences(layer: Sdf.Layer, stage: Usd.Stage) -> Iterator[tuple[str, Any, Any]]:
    """Units and axis that a layer states and the stage has otherwise: name, that of the layer, that of the stage."""
    of_stage = {LENGTH: UsdGeom.GetStageMetersPerUnit(stage), MASS: UsdPhysics.GetStageKilogramsPerUnit(stage)}
    for name, other in {**of_stage, UP: str(UsdGeom.GetStageUpAxis(stage))}.items():
        if layer.pseudoRoot.HasInfo(name):
            own = layer.pseudoRoot.GetInfo(name)
            if own != other and (name == UP or not np.isclose(own, other, rtol=SAME, atol=0.0)):
                yield name, own, other


def _scaled(prim: Usd.Prim, ratio: float) -> bool:
    """Whether an operation on a prim or on one above it scales by a ratio along every axis, or all of them together."""
    scales = [_mean_scale(world_matrix(prim))]
    while prim:
        for operation in UsdGeom.Xformable(prim).GetOrderedXformOps() if prim.IsA(UsdGeom.Xformable) else ():
            scales.append(_mean_scale(np.array(operation.GetOpTransform(ANY_TIME))))
        prim = prim.GetParent()
    return bool(np.isclose(scales, ratio, rtol=1e-3, atol=0.0).any())


def _mean_scale(matrix: np.ndarray) -> float:
    return float(abs(np.linalg.det(matrix[:3, :3])) ** (1 / 3))


def _turned(prim: Usd.Prim, own: str, other: str) -> bool:
    """Whether an axis of a prim points along one of the stage."""
    along = world_matrix(prim)[:3, "XYZ".index(own)]
    return bool(along["XYZ".index(other)] >= (1.0 - SAME) * np.linalg.norm(along))
