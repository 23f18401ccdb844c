"""A file of moving particles: a stage with one `UsdGeom.Points` a body."""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from pxr import Gf, Sdf, Tf, Usd, UsdGeom, UsdPhysics, Vt

from warp_mps.errors import InputError, RunError
from warp_mps.particles.particles import Particles
from warp_mps.scene import OUTPUTS
from warp_mps.usd.animation.local_origin import local_origin
from warp_mps.usd.animation.occlusion import occluding_walls
from warp_mps.usd.animation.scenery import SCENERY, Scenery, paint

if TYPE_CHECKING:
    from warp_mps.scene import StageFrame

ROOT = "/Result"
PLAYBACK_RATE = 30.0
# a file is rewritten when its waste exceeds this multiple of its content, and some bytes more
MOST_WASTE, LEAST_WASTE = 1.0, 2**20
# number of saves after which the layer is reloaded, because USD keeps data of each save in memory
SAVES_KEPT = 64
# sRGB
PALETTE = (
    (0.90, 0.38, 0.22),
    (0.16, 0.50, 0.73),
    (0.95, 0.71, 0.20),
    (0.20, 0.63, 0.53),
    (0.58, 0.40, 0.74),
    (0.55, 0.57, 0.60),
)
WALL_COLOR = (0.72, 0.72, 0.70)
LIQUID_COLOR = (0.16, 0.45, 0.75)


class PointsFile:
    """A stage of particles that is saved in place, frame by frame.

    Every save appends the tables of all frames and leaves the previous tables as waste: the waste grows with the
    square of the number of frames, and USD keeps data of each save in memory. When the waste exceeds the content, the
    file is rewritten without it.

    Args:
        path: The file, which exists (:meth:`create` makes one).
        particles: Particles of the scene.
        frame: How the scene lies in the stage.
    """

    def __init__(self, path: Path, particles: Particles, frame: StageFrame) -> None:
        self.path = path
        self._stage = Usd.Stage.Open(str(path))
        self._content, self._saves = path.stat().st_size, 0
        self._ranges = [(int(first), int(last)) for first, last in particles.ranges]
        self._elastic = particles.elastic_bodies
        self._widths = [_width(particles, bounds, frame) for bounds in self._ranges]
        self._scenery = Scenery(self._stage, frame)
        self._points = [UsdGeom.Points(self._stage.GetPrimAtPath(f"{ROOT}/{name}")) for name in particles.names]
        for points, (first, last) in zip(self._points, self._ranges, strict=True):
            for code in points.GetExtentAttr().GetTimeSamples() if last > first else ():
                self._scenery.extend_view(np.array(points.GetExtentAttr().Get(code)))

    @classmethod
    def create(cls, path: Path, particles: Particles, frame: StageFrame, *, frame_rate: float) -> PointsFile:
        """Make a file without frames; `frame_rate` is in frames per simulated second [1/s]."""
        stage = Usd.Stage.CreateNew(str(path))
        origin = local_origin(particles, frame)
        _define_stage(stage, frame, frame_rate, origin)
        for index in range(len(particles.names)):
            points = _define_body(stage, particles, index, frame)
            if origin.any():
                # not on the prim above: a stage that references the result and moves it would override it
                points.AddTranslateOp().Set(Gf.Vec3d(*origin.tolist()))
        for name in occluding_walls(particles, frame):
            # programs show a guide on request only: the wall would hide the content
            UsdGeom.Imageable(stage.GetPrimAtPath(f"{ROOT}/{name}")).CreatePurposeAttr(UsdGeom.Tokens.guide)
        stage.GetRootLayer().Save()
        return cls(path, particles, frame)

    def describe(self, provenance: Mapping[str, str | float | int]) -> None:
        """Write the provenance of the result to the layer's customLayerData."""
        self._stage.GetRootLayer().customLayerData = dict(provenance)

    def write(self, code: float, values: Mapping[str, np.ndarray]) -> None:
        """Set the quantities at a time code; all particles, float32, shape [n] or [n, 3], or float64, [n, 3, 3].

        The outputs are of elastic bodies: walls and fluids have no stress of their own.
        """
        for index in range(len(self._ranges)):
            own = self._own(index, values)
            self._write_body(index, code, own)
            self._content += sum(value.nbytes for value in own.values())
        if not self._stage.HasAuthoredTimeCodeRange():
            self._stage.SetStartTimeCode(code)
        self._stage.SetEndTimeCode(code)

    def save(self) -> None:
        """Save in place.

        Raises:
            RunError: The file cannot be written.
        """
        try:
            saved = self._stage.GetRootLayer().Save()
        except Tf.ErrorException as error:
            # USD recreates a folder that was removed during the run: delete it if it is empty
            with contextlib.suppress(OSError):
                self.path.parent.rmdir()
            raise RunError(f"{self.path}: cannot be written: {first_error(error)}") from error
        if not saved:
            raise RunError(f"{self.path}: cannot be written")
        self._saves += 1
        if self.path.stat().st_size > (1.0 + MOST_WASTE) * self._content + LEAST_WASTE:
            self.compact()
        elif self._saves % SAVES_KEPT == 0:
            self._stage.GetRootLayer().Reload(True)

    def compact(self) -> None:
        """Rewrite the file without the waste of earlier saves; if that fails, the file is unchanged."""
        layer, temporary = self._stage.GetRootLayer(), self.path.with_suffix(".whole.usdc")
        temporary.unlink(missing_ok=True)
        try:
            if layer.Export(str(temporary)):
                os.replace(temporary, self.path)
                layer.Reload(True)
        except (OSError, Tf.ErrorException):
            # as on a full disk; the next save will say so
            pass
        temporary.unlink(missing_ok=True)
        self._content = self.path.stat().st_size

    def parts(self, values: Mapping[str, np.ndarray]) -> list[tuple[str, dict[str, np.ndarray]]]:
        """The name of each body and what it has of the quantities, by the names of its attributes."""
        found = []
        for index, points in enumerate(self._points):
            own = {_attribute(name): value for name, value in self._own(index, values).items()}
            own["extent"] = extent(own["points"], self._widths[index])
            found.append((points.GetPrim().GetName(), own))
        return found

    def _own(self, index: int, values: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        first, last = self._ranges[index]
        return {name: value[first:last] for name, value in values.items() if self._has(index, name)}

    def _has(self, index: int, name: str) -> bool:
        """Whether a body, wall or fluid has a quantity."""
        return index < self._elastic or name not in OUTPUTS

    def _write_body(self, index: int, code: float, values: Mapping[str, np.ndarray]) -> None:
        points = self._points[index]
        points.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(values["points"]), code)
        points.GetVelocitiesAttr().Set(Vt.Vec3fArray.FromNumpy(values["velocities"]), code)
        box = extent(values["points"], self._widths[index])
        points.GetExtentAttr().Set(Vt.Vec3fArray.FromNumpy(box), code)
        if len(values["points"]):
            self._scenery.extend_view(box)
        for name, value in values.items():
            if name not in ("points", "velocities"):
                _set_primvar(points, name, value, code)


def _attribute(name: str) -> str:
    """Name of the attribute of a quantity."""
    return name if name in ("points", "velocities") else f"primvars:{name}"


def first_error(error: BaseException) -> str:
    """Text of the first error; the others follow from it, and all carry locations in USD's source."""
    text = " ".join(str(error).split())
    found = re.search(r" : '(.*?)'( Error in '|$)", text)
    return found[1] if found else text


def extent(points: np.ndarray, width: float) -> np.ndarray:
    """Corners of the box around points [n, 3] that are `width` wide, shape [2, 3]."""
    if len(points) == 0:
        return np.zeros((2, 3), dtype=np.float32)
    return np.stack([points.min(axis=0) - width / 2, points.max(axis=0) + width / 2]).astype(np.float32)


def open_until(path: Path, particles: Particles, last_code: float) -> Any:
    """Open an earlier result as a layer detached from its file, without the samples after a time code.

    Raises:
        InputError: There is no such file, it is not a result of these particles, or it has no sample at that time code.
    """
    if not os.path.isfile(path):
        raise InputError(str(path), "", "is missing, so the run cannot be continued; start a new run")
    try:
        layer = Sdf.Layer.OpenAsAnonymous(str(path))
    except Tf.ErrorException:
        layer = None
    if layer is None or not layer.GetPrimAtPath(ROOT):
        raise InputError(str(path), "", "is not a result that can be continued; start a new run")
    if not _holds(layer, particles):
        raise InputError(str(path), "", "holds other particles than this case; start a new run")
    codes = layer.ListAllTimeSamples()
    kept = [code for code in codes if code <= last_code]
    if last_code not in kept:
        raise InputError(str(path), "", f"lacks the frame at time code {last_code:g} to continue from; start a new run")
    for code in codes[len(kept) :]:
        _erase_time_sample(layer, code)
    layer.endTimeCode = last_code
    return layer


def _holds(layer: Any, particles: Particles) -> bool:
    """Whether a layer has the bodies and ids of the particles."""
    for name, (first, last) in zip(particles.names, particles.ranges, strict=True):
        ids = layer.GetAttributeAtPath(f"{ROOT}/{name}.ids")
        if ids is None or not np.array_equal(np.asarray(ids.default), particles.ids[first:last]):
            return False
    return len(layer.GetPrimAtPath(ROOT).nameChildren) == len(particles.names)


def _erase_time_sample(layer: Any, code: float) -> None:
    for body in layer.GetPrimAtPath(ROOT).nameChildren:
        for attribute in body.attributes:
            layer.EraseTimeSample(attribute.path, code)


def _define_stage(stage: Any, frame: StageFrame, frame_rate: float, origin: np.ndarray) -> None:
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, ROOT).GetPrim())
    if origin.any():
        UsdGeom.Xform.Define(stage, SCENERY).AddTranslateOp().Set(Gf.Vec3d(*origin.tolist()))
    UsdGeom.SetStageUpAxis(stage, frame.up_axis)
    UsdGeom.SetStageMetersPerUnit(stage, frame.meters_per_unit)
    UsdPhysics.SetStageKilogramsPerUnit(stage, frame.kilograms_per_unit)
    # Velocities are per second of stage time, so a second of stage time must be a second of the simulation:
    # timeCodesPerSecond ties the two. framesPerSecond only says how fast a player steps through the time codes;
    # at no more than 30 a second, the thousands of frames of a fast event are seen in slow motion.
    stage.SetTimeCodesPerSecond(frame_rate)
    stage.SetFramesPerSecond(min(frame_rate, PLAYBACK_RATE))


def _define_body(stage: Any, particles: Particles, index: int, frame: StageFrame) -> Any:
    first, last = (int(bound) for bound in particles.ranges[index])
    points = UsdGeom.Points.Define(stage, f"{ROOT}/{particles.names[index]}")
    points.CreateIdsAttr(Vt.Int64Array.FromNumpy(particles.ids[first:last].astype(np.int64)))
    width = _width(particles, (first, last), frame)
    points.CreateWidthsAttr(Vt.FloatArray.FromNumpy(np.full(last - first, width, dtype=np.float32)))
    points.SetWidthsInterpolation(UsdGeom.Tokens.vertex)
    role = "body"
    if index >= particles.elastic_bodies:
        role = "fluid" if first >= particles.count - particles.liquid else "wall"
    color = {"body": PALETTE[index % len(PALETTE)], "fluid": LIQUID_COLOR, "wall": WALL_COLOR}[role]
    points.GetPrim().SetCustomDataByKey("role", role)
    paint(points, role, color)
    for create in (points.CreatePointsAttr, points.CreateVelocitiesAttr, points.CreateExtentAttr):
        create()
    return points


def _width(particles: Particles, bounds: tuple[int, int], frame: StageFrame) -> float:
    """Width of the particles of a body in the stage's units: their spacing."""
    first, last = bounds
    return float(particles.spacings[first] / frame.meters_per_unit) if last > first else 0.0


def _set_primvar(points: Any, name: str, value: np.ndarray, code: float) -> None:
    types = Sdf.ValueTypeNames
    kinds = {1: (types.FloatArray, Vt.FloatArray), 2: (types.Vector3fArray, Vt.Vec3fArray)}
    # USD has no matrix of single precision
    kind, arrays = kinds.get(value.ndim, (types.Matrix3dArray, Vt.Matrix3dArray))
    array = arrays.FromNumpy(value)
    UsdGeom.PrimvarsAPI(points).CreatePrimvar(name, kind, UsdGeom.Tokens.vertex).Set(array, code)
