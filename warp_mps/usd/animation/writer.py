"""Results as an animation: one `UsdGeom.Points` a body in one ``.usdc`` file, readable after every frame."""

from __future__ import annotations

import contextlib
import os
import shutil
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from pxr import Sdf, Tf

from warp_mps.errors import InputError, RunError
from warp_mps.particles.particles import Particles
from warp_mps.usd.animation.frame_digest import FrameDigest, digest_of
from warp_mps.usd.animation.local_origin import local_origin
from warp_mps.usd.animation.points_file import ROOT, PointsFile, first_error, open_until
from warp_mps.usd.case.isolated_open import open_isolated
from warp_mps.usd.case.open_stage import quiet, refuse_damage

if TYPE_CHECKING:
    from warp_mps.scene import StageFrame


def to_stage_axes(values: np.ndarray, frame: StageFrame, origin: np.ndarray | None = None) -> np.ndarray:
    """Turn vectors of the scene [n, dimension] into vectors along the stage's axes, float32, shape [n, 3].

    Args:
        values: The vectors.
        frame: How the scene lies in its stage.
        origin: What is subtracted from them before they are rounded, along the stage's axes, shape [3].
    """
    columns = ["xyz".index(axis) for axis in frame.axes]
    mapped = np.zeros((len(values), 3), dtype=np.float32)
    mapped[:, columns] = values if origin is None else values - origin[columns]
    return mapped


def tensors_to_stage_axes(values: np.ndarray, frame: StageFrame) -> np.ndarray:
    """Turn symmetric tensors [n, 3, 3] along the scene's axes, the third a plane's normal, to those of the stage.

    Which way the normal points does not matter: there is no shear across the plane.
    """
    axes = ["xyz".index(axis) for axis in frame.axes]
    axes += [axis for axis in range(3) if axis not in axes]
    mapped = np.zeros_like(values)
    mapped[:, np.array(axes)[:, None], axes] = values
    return mapped


@contextlib.contextmanager
def _writable(path: Path) -> Iterator[None]:
    """Say in one line that an animation cannot be begun or continued, as on a full disk, and leave no copies.

    Raises:
        InputError: It cannot.
    """
    try:
        with quiet(path):
            yield
    except (Tf.ErrorException, RunError) as error:
        cause = error if isinstance(error, Tf.ErrorException) else error.__cause__ or error
        for name in copies_of(path):
            name.unlink(missing_ok=True)
        raise InputError(str(path), "", f"cannot be written: {first_error(cause)}") from error


def copies_of(path: Path) -> list[Path]:
    """The hidden copies of an animation that take turns."""
    return [path.with_name(f".{path.stem}.{letter}.usdc") for letter in "ab"]


class AnimationWriter:
    """Writes the particles of a run, frame by frame, so that the file can be opened whenever the process ends.

    `Save` of a ``.usdc`` layer works in place: it overwrites the tables at the end of the file before it points the
    header at the new ones, and a process killed in between leaves a file that does not open. So two hidden copies
    beside the file take turns, and the file's own name is a hard link to the one that was completed last. A frame
    costs two saves, whatever the number of frames before it.

    Points, velocities, extents and widths are in the stage's axes and units; primvars are in SI units. The points of a
    scene far from the origin are relative to a local one, whose place is the translation of their prims.

    Args:
        path: File to write, ending in ``.usdc``; the first frame replaces an existing one.
        particles: Particles of the scene.
        frame: How the scene lies in its stage.
        frame_rate: Frames per simulated second [1/s].
        provenance: Origin of the result, for the layer's customLayerData.
        primvars: Names of further quantities that :meth:`write` is given.

    Raises:
        InputError: The path does not end in ``.usdc``.
    """

    def __init__(
        self,
        path: str | Path,
        particles: Particles,
        frame: StageFrame,
        *,
        frame_rate: float,
        provenance: Mapping[str, str | float | int],
        primvars: Sequence[str] = (),
    ) -> None:
        self._setup(path, particles, frame, frame_rate, primvars)
        with _writable(self._path):
            self._copies = [PointsFile.create(name, particles, frame, frame_rate=frame_rate) for name in self._names]
        for copy in self._copies:
            copy.describe(provenance)

    @classmethod
    def resume(
        cls,
        path: str | Path,
        particles: Particles,
        frame: StageFrame,
        *,
        frame_rate: float,
        provenance: Mapping[str, str | float | int],
        primvars: Sequence[str] = (),
        after: float,
        mark: Mapping[str, Any] | None = None,
    ) -> AnimationWriter:
        """Continue the file of an earlier run, without its samples later than `after` [s].

        If `mark` is given, it is what the method of that name gave at that time.

        Raises:
            InputError: There is no such file, or it holds other particles or frames.
        """
        writer = cls.__new__(cls)
        writer._setup(path, particles, frame, frame_rate, primvars)
        if os.path.isfile(path):
            open_isolated(path, allow_external=False)
        with quiet(writer._path), refuse_damage(writer._path):
            layer = open_until(writer._path, particles, writer._code(after))
            prims = [layer.GetPrimAtPath(f"{ROOT}/{name}") for name in particles.names]
            writer._digest = digest_of(prims, layer, layer.ListAllTimeSamples())
        if mark is not None and writer.mark() != mark:
            reason = "has other frames than those that the run wrote before its checkpoint; start a new run"
            raise InputError(str(path), "", reason)
        with _writable(writer._path):
            for name in writer._names:
                layer.Export(str(name))
            writer._copies = [PointsFile(name, particles, frame) for name in writer._names]
            for copy in writer._copies:
                copy.describe(provenance)
                copy.save()
        for copy in writer._copies:
            writer._publish(copy.path)
        return writer

    def _setup(
        self, path: str | Path, particles: Particles, frame: StageFrame, frame_rate: float, primvars: Sequence[str]
    ) -> None:
        self._path = Path(path)
        if self._path.suffix != ".usdc":
            raise InputError(str(path), "", "an animation is written as .usdc; give a name that ends so")
        self._frame, self._rate, self._primvars = frame, frame_rate, tuple(primvars)
        origin = local_origin(particles, frame)
        self._origin = origin if origin.any() else None
        self._names = copies_of(self._path)
        self._digest = FrameDigest()
        self._path.parent.mkdir(parents=True, exist_ok=True)
        self._remove_copies()

    def mark(self) -> dict[str, Any]:
        """Number and digest of the frames that a continued run keeps."""
        return self._digest.mark()

    def write(
        self, time: float, positions: np.ndarray, velocities: np.ndarray, *, kept: bool = True, **primvars: np.ndarray
    ) -> None:
        """Add a frame and save it.

        Args:
            time: Simulated time [s].
            positions: Positions [m], shape [n, dimension].
            velocities: Velocities [m/s], shape [n, dimension].
            kept: Whether a continued run keeps the frame.
            primvars: The quantities named at construction, shape [n], [n, 1], [n, dimension] or [n, 3, 3].

        Raises:
            RunError: The file cannot be written.
        """
        if set(primvars) != set(self._primvars):
            raise ValueError(f"primvars are {sorted(self._primvars)}, not {sorted(primvars)}")
        unit = self._frame.meters_per_unit
        values = {name: self._primvar(value) for name, value in primvars.items()}
        values["points"] = to_stage_axes(positions / unit, self._frame, self._origin)
        values["velocities"] = to_stage_axes(velocities / unit, self._frame)
        if kept:
            self._digest.add(self._code(time), self._copies[0].parts(values))
        for copy in self._copies:
            copy.write(self._code(time), values)
            copy.save()
            self._publish(copy.path)

    def close(self) -> None:
        """Remove the hidden copies; the file itself is complete after every frame."""
        self._copies = []
        self._remove_copies()
        # where this process has the file that it replaced open, USD would show its old frames on
        layer = Sdf.Layer.Find(str(self._path))
        if layer and not layer.dirty:
            layer.Reload(True)

    def _code(self, time: float) -> float:
        # Rounding puts frame k at time code k exactly where the steps of the clock add up to k / frame_rate.
        return round(time * self._rate, 6)

    def _primvar(self, value: np.ndarray) -> np.ndarray:
        if value.ndim == 3:
            return tensors_to_stage_axes(value, self._frame)
        if value.ndim == 2 and value.shape[1] > 1:
            return to_stage_axes(value, self._frame)
        return value.reshape(-1).astype(np.float32)

    def _publish(self, source: Path) -> None:
        """Give the file's own name to a complete copy, in one atomic step."""
        temporary = source.with_suffix(".new")
        temporary.unlink(missing_ok=True)
        try:
            os.link(source, temporary)
        except OSError:  # a file system without hard links
            shutil.copyfile(source, temporary)
        os.replace(temporary, self._path)

    def _remove_copies(self) -> None:
        for name in self._names:
            name.unlink(missing_ok=True)
            name.with_suffix(".new").unlink(missing_ok=True)
            name.with_suffix(".whole.usdc").unlink(missing_ok=True)
