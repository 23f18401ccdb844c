"""The animation of a run, read from run.usdc by every command that shows results."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdPhysics

from warp_mps.app.run_folder import ANIMATION, require_run
from warp_mps.errors import InputError
from warp_mps.usd.animation.colours import linear_to_srgb
from warp_mps.usd.case.open_stage import open_stage, quiet, refuse_damage

# SI units of the quantities that a result may hold; points, velocities and widths are in the stage's units
UNITS = {"pressure": "Pa", "stress": "Pa", "strain": "1", "von_mises": "Pa", "strain_energy": "J/m^3"}

# number of frames sampled from a run, and the largest number of particles in them
SAMPLE_FRAMES, SAMPLE = 24, 4_000_000
# linear RGB of prims without a colour
PLAIN = (0.3, 0.3, 0.3)
# numbers of a file that can be computed with in single precision
SMALLEST, LARGEST = 1e-15, 1e18


def find_animation(folder: Path) -> Path:
    """The animation in the folder of a run.

    Raises:
        InputError: There is no such folder, or no run in it.
    """
    require_run(folder, ANIMATION)
    return folder / ANIMATION


def refuse_existing(path: Path, overwrite: bool) -> None:
    """Refuse to replace an existing file, unless that is allowed.

    Raises:
        InputError: The file exists and may not be replaced.
    """
    if os.path.lexists(path) and not overwrite:
        raise InputError(str(path), "", "exists; use --overwrite to replace it (in Python overwrite=True)")


def refuse_link(folder: Path) -> None:
    """Refuse to write many files into a folder that is elsewhere, where the same names may belong to others.

    Raises:
        InputError: The folder is a link.
    """
    if folder.is_symlink():
        raise InputError(str(folder), "", "is a link to another folder, must be a folder; remove the link")


@dataclass(frozen=True)
class Cloud:
    """The particles of one body, wall or fluid: the data that is the same in every frame.

    Attributes:
        name: Name of the body.
        role: ``body``, ``wall`` or ``fluid``.
        ids: Ids, shape [n].
        widths: Widths [stage units], shape [n].
        color: sRGB colour from 0 to 1, shape [3].
        scalars: Names of the quantities with one number a particle.
    """

    name: str
    role: str
    ids: np.ndarray
    widths: np.ndarray
    color: np.ndarray
    scalars: tuple[str, ...]


class Animation:
    """The frames of a run.

    Attributes:
        path: File that was read.
        clouds: Bodies, walls and fluids, in the order of the file.
        codes: Time codes of the frames.
        times: Times of the frames [s], shape [frames].
        playback_rate: Frames that a player shows in a second [1/s].
        meters_per_unit: Length of the stage's unit [m].
        kilograms_per_unit: Mass of the stage's unit [kg].
        up_axis: ``Y`` or ``Z``.
        provenance: Where the result comes from.

    Args:
        folder: Folder of the run.
        finite: Whether numbers that are not finite, or too large to compute with, are refused.

    Raises:
        InputError: There is no run in the folder, or its animation cannot be read or has no frames. The methods that
            give values raise it where these are not one a particle.
    """

    def __init__(self, folder: Path, *, finite: bool = False) -> None:
        self.path, self._finite = find_animation(folder), finite
        self._stage = open_stage(self.path)
        points = [UsdGeom.Points(prim) for prim in self._stage.Traverse() if prim.IsA(UsdGeom.Points)]
        self.codes = sorted({code for item in points for code in item.GetPointsAttr().GetTimeSamples()})
        if not self.codes:
            raise InputError(str(self.path), "", "has no frames")
        self._points = points
        self._require_units()
        with quiet(self.path), refuse_damage(self.path):
            self.clouds = tuple(_cloud(item, self.path) for item in points)
            self._origins = [_origin(item, self.path) for item in points]
        self.times = np.array(self.codes) / self._stage.GetTimeCodesPerSecond()
        self.playback_rate = float(self._stage.GetFramesPerSecond())
        self.meters_per_unit = float(UsdGeom.GetStageMetersPerUnit(self._stage))
        self.kilograms_per_unit = float(UsdPhysics.GetStageKilogramsPerUnit(self._stage))
        self.up_axis = str(UsdGeom.GetStageUpAxis(self._stage))
        data = dict(self._stage.GetRootLayer().customLayerData)
        self.provenance: Mapping[str, Any] = {name: item for name, item in data.items() if _is_plain(item)}

    def _require_units(self) -> None:
        """Refuse units and rates outside their range, and times that are not finite.

        Raises:
            InputError: One of them is.
        """
        stage = self._stage
        units = {
            "timeCodesPerSecond": stage.GetTimeCodesPerSecond(),
            "framesPerSecond": stage.GetFramesPerSecond(),
            "metersPerUnit": UsdGeom.GetStageMetersPerUnit(stage),
            "kilogramsPerUnit": UsdPhysics.GetStageKilogramsPerUnit(stage),
        }
        for name, value in units.items():
            if not SMALLEST <= value <= LARGEST:
                raise InputError(str(self.path), name, f"is {value:g}, must be from {SMALLEST:g} to {LARGEST:g}")
        if not all(abs(code) <= LARGEST for code in self.codes):
            raise InputError(str(self.path), "", "has a frame at a time that is not finite")

    @property
    def point_type(self) -> type[np.floating[Any]]:
        """Precision that positions need: double where the coordinates of a cloud begin far from the stage's origin."""
        return np.float64 if any(origin.any() for origin in self._origins) else np.float32

    def __len__(self) -> int:
        """Number of frames."""
        return len(self.codes)

    def prims(self, stage: Usd.Stage) -> list[UsdGeom.Points]:
        """The clouds in another stage of the same layout."""
        return [UsdGeom.Points(stage.GetPrimAtPath(item.GetPath())) for item in self._points]

    def sample_frames(self) -> list[int]:
        """A sample of the frames with the first and the last, as many as fit in memory."""
        most = int(np.clip(SAMPLE // max(1, sum(len(cloud.ids) for cloud in self.clouds)), 2, SAMPLE_FRAMES))
        return [int(frame) for frame in np.unique(np.linspace(0, len(self) - 1, most).astype(int))]

    def points(self, cloud: int, frame: int) -> np.ndarray:
        """Positions of a cloud [stage units], shape [n, 3]."""
        values = self._sound(cloud, frame, "points", self._get(self._points[cloud].GetPointsAttr(), frame), (3,))
        return values + self._origins[cloud]

    def velocities(self, cloud: int, frame: int) -> np.ndarray:
        """Velocities of a cloud [stage units/s], shape [n, 3]."""
        values = self._get(self._points[cloud].GetVelocitiesAttr(), frame)
        return self._sound(cloud, frame, "velocities", values, (3,))

    def scalar(self, cloud: int, frame: int, name: str) -> np.ndarray:
        """A scalar quantity of a cloud [SI units], shape [n]."""
        primvar = UsdGeom.PrimvarsAPI(self._points[cloud]).GetPrimvar(name)
        return self._sound(cloud, frame, name, self._get(primvar, frame), ())

    def quantities(self, cloud: int, frame: int) -> dict[str, np.ndarray]:
        """The further quantities of a cloud [SI units], by name, shape [n], [n, 3] or [n, 3, 3]."""
        values = {}
        for primvar in UsdGeom.PrimvarsAPI(self._points[cloud]).GetPrimvars():
            if primvar.GetInterpolation() == UsdGeom.Tokens.vertex:
                value = self._get(primvar, frame)
                if value is not None:
                    name = str(primvar.GetPrimvarName())
                    self._sound(cloud, frame, name, value, None)
                    values[name] = np.array(value)
        return values

    def _get(self, values: Any, frame: int) -> Any:
        """What an attribute or a primvar holds in a frame.

        Raises:
            InputError: USD cannot read it.
        """
        with quiet(self.path), refuse_damage(self.path):
            return values.Get(self.codes[frame])

    def _sound(self, cloud: int, frame: int, name: str, value: Any, shape: tuple[int, ...] | None) -> np.ndarray:
        """The values of a quantity; `shape` is that of one particle, None any.

        Raises:
            InputError: There are more or fewer than particles, or one is not finite though it must be.
        """
        array = _numbers(value)
        count, time = len(self.clouds[cloud].ids), self.times[frame]
        if array is None or len(array) != count or (shape is not None and array.shape[1:] != shape):
            found = "none" if array is None else f"values of shape {array.shape}"
            reason = f"has {found} at {time:.6g} s, must have {count}, one a particle"
            raise InputError(str(self.path), f"{self.clouds[cloud].name}.{name}", reason)
        if self._finite and not (np.abs(array) <= LARGEST).all():
            reason = f"has a value at {time:.6g} s that is not finite, or above {LARGEST:g}"
            raise InputError(str(self.path), f"{self.clouds[cloud].name}.{name}", reason)
        return array


def _numbers(value: Any) -> np.ndarray | None:
    """Values as an array of numbers; None where they are not numbers."""
    try:
        return None if value is None else np.array(value, dtype=float)
    except (TypeError, ValueError):
        return None


def _is_plain(value: Any) -> bool:
    """Whether a note on the origin of a result is a text, or a number that can be shown."""
    return isinstance(value, str | bool) or (isinstance(value, int | float) and abs(value) <= LARGEST)


def _per_particle(path: Path, prim: Usd.Prim, name: str, value: Any, count: int | None) -> np.ndarray:
    array = _numbers([] if value is None else value)
    if array is None or array.ndim != 1 or not (np.abs(array) <= LARGEST).all() or len(array) != (count or len(array)):
        wanted = "" if count is None else f", {count} of them"
        raise InputError(str(path), f"{prim.GetName()}.{name}", f"must be finite numbers, one a particle{wanted}")
    return array


def _origin(item: UsdGeom.Points, path: Path) -> np.ndarray:
    """Where the coordinates of a cloud begin [stage units], shape [3].

    Raises:
        InputError: The cloud is turned or scaled, which no result is, or the place is not finite.
    """
    matrix = np.array(UsdGeom.Xformable(item).ComputeLocalToWorldTransform(Usd.TimeCode.Default()))
    if not (np.array_equal(matrix[:, :3][:3], np.eye(3)) and (np.abs(matrix[3, :3]) <= LARGEST).all()):
        reason = "is turned, scaled or nowhere, must be moved only: as warp_mps writes a scene far from the origin"
        raise InputError(str(path), item.GetPrim().GetName(), reason)
    return matrix[3, :3]


def _cloud(item: UsdGeom.Points, path: Path) -> Cloud:
    prim: Usd.Prim = item.GetPrim()
    ids = _per_particle(path, prim, "ids", item.GetIdsAttr().Get(), None).astype(np.int64)
    widths = _per_particle(path, prim, "widths", item.GetWidthsAttr().Get(), len(ids)).astype(np.float32)
    if not (widths > 0.0).all() or len(widths) != len(ids):
        raise InputError(str(path), f"{prim.GetName()}.widths", f"must be {len(ids)} numbers above 0, one a particle")
    colors = item.GetDisplayColorAttr().Get()
    vertex = [var for var in UsdGeom.PrimvarsAPI(item).GetPrimvars() if var.GetInterpolation() == UsdGeom.Tokens.vertex]
    return Cloud(
        name=prim.GetName(),
        role=str(prim.GetCustomDataByKey("role") or "body"),
        ids=ids,
        widths=widths,
        color=linear_to_srgb(colors[0] if colors and np.isfinite(np.array(colors)).all() else PLAIN),
        scalars=tuple(
            str(var.GetPrimvarName()) for var in vertex if var.GetTypeName() == Sdf.ValueTypeNames.FloatArray
        ),
    )
