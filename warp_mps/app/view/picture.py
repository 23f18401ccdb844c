"""Pictures of a run: its particles as shaded spheres, with what their colours mean."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from warp_mps.app.animation_reader import Animation, refuse_existing
from warp_mps.app.view import figures
from warp_mps.app.view.annotations import SMALLEST, Annotations, field, fitted_size
from warp_mps.app.view.camera import frame_points
from warp_mps.app.view.colours import choose_colourings, has_colour
from warp_mps.app.view.spheres import Spheres, Surface, ambient_occlusion, nearest, shade
from warp_mps.errors import InputError
from warp_mps.usd.animation.viewpoint import plane_axes, space_axes

FORMATS = ("png", "webp")
SETTINGS: dict[str, dict[str, Any]] = {".png": {"optimize": True}, ".webp": {"quality": 90, "method": 6}}
# pixels that each pixel of a picture is the mean of, along either side
FINE = 2
# pixels of a side at most, for the memory
MOST = 8192
# how much of a wall shows that stands before the scene, the share of the scene that it may hide before it
# does, and the pixels of a picture for that
GLASS, HIDDEN, COARSE = 0.10, 0.02, 8
# percentage of a fluid's particles that may leave the picture at either side
FAR = 0.05


@dataclass(frozen=True)
class PictureOptions:
    """Options of a picture; None chooses by the run.

    Attributes:
        colour: ``body``, ``speed`` or a quantity of the run.
        limits: Values of the first and the last colour [SI units].
        size: Width and height [px].
        view: Direction from the scene to the camera, along the stage's axes, shape [3].
    """

    colour: str | None = None
    limits: tuple[float, float] | None = None
    size: tuple[int, int] | None = None
    view: tuple[float, float, float] | None = None


DEFAULT_OPTIONS = PictureOptions()


class Painter:
    """Draws the frames of a run, all from one place and in the same colours.

    Args:
        animation: The run.
        options: Options of the user.

    Attributes:
        colourings: The colour maps of the quantities that are shown.
        size: Width and height of the picture [px].
        camera: The view that all frames share.
        transparent_walls: Numbers of the clouds that are blended, since they hide others.

    Raises:
        InputError: The run has no such quantity, or the size or the direction cannot be.
    """

    def __init__(self, animation: Animation, options: PictureOptions = DEFAULT_OPTIONS) -> None:
        self.animation = animation
        self.colourings = choose_colourings(animation, options.colour, options.limits)
        self._frames = animation.sample_frames()
        points, widths = self._extent()
        axes, self._flat = _axes(points, animation.up_axis, options.view)
        self.size = options.size or fitted_size(points @ axes.T, float(widths.max()))
        _check_size(self.size)
        left, top, right, bottom = (FINE * edge for edge in field(self.size))
        self.camera = frame_points(axes, points, widths, (left, top, right, bottom), flat=self._flat)
        self.transparent_walls = self._occluding_walls()

    def draw(self, frame: int) -> np.ndarray:
        """The picture of a frame, shape [height, width, 3], as bytes."""
        width, height = self.size
        pixels = self._particles(frame).reshape(height, FINE, width, FINE, 3).mean(axis=(1, 3))
        return self._annotations.fill(pixels, f"{self._case}   {self.time_label(frame)}")

    def _particles(self, frame: int) -> np.ndarray:
        """The scene alone, on white, finely; shape [FINE height, FINE width, 3]."""
        width, height = FINE * self.size[0], FINE * self.size[1]
        spheres, owners = self.spheres(frame), self._owners
        clouds = range(len(self.animation.clouds))
        colors = np.concatenate([self.colors(cloud, frame) for cloud in clouds]).astype(np.float32)
        image, surface = self._layer(spheres, ~np.isin(owners, self.transparent_walls), colors, width, height)
        image[~surface.covered] = 1.0
        for cloud in self.transparent_walls:
            glass, before = self._layer(spheres, owners == cloud, colors, width, height)
            clear = before.covered & (before.depths < surface.depths)
            image[clear] += GLASS * (glass[clear] - image[clear])
        return image

    def colors(self, cloud: int, frame: int) -> np.ndarray:
        """Colours of a cloud, shape [n, 3]."""
        own = [item for item in self.colourings if has_colour(self.animation, cloud, item.name)]
        return [*own, self.colourings[0]][0].colors(self.animation, cloud, frame)

    def _layer(
        self, spheres: Spheres, kept: np.ndarray, colors: np.ndarray, width: int, height: int
    ) -> tuple[np.ndarray, Surface]:
        some = _only(spheres, kept)
        surface = nearest(some, width, height)
        image = shade(some, surface, colors[kept])
        if not self._flat and kept.any():
            radius, unit = float(np.median(some.radii)), float(np.median(some.bulges))
            for reach in (radius, 3.0 * radius):
                image *= ambient_occlusion(surface.depths, max(1, round(reach)), unit * reach / radius)[:, :, None]
        return image, surface

    def _occluding_walls(self) -> list[int]:
        """Walls that hide what they hold, in any of some frames."""
        walls = [number for number, cloud in enumerate(self.animation.clouds) if cloud.role == "wall"]
        if self._flat or len(walls) == len(self.animation.clouds):
            return []
        found = set[int]()
        for frame in self._frames[:: max(1, len(self._frames) // 4)]:
            spheres = self.spheres(frame)
            # coarsely is enough
            small = Spheres(spheres.centres / COARSE, spheres.depths, spheres.radii / COARSE, spheres.bulges)
            size = (FINE * self.size[0] // COARSE, FINE * self.size[1] // COARSE)
            alone = nearest(_only(small, ~np.isin(self._owners, walls)), *size)
            for wall in walls:
                before = nearest(_only(small, self._owners == wall), *size)
                if np.sum(before.depths < alone.depths, where=alone.covered) > HIDDEN * alone.covered.sum():
                    found.add(wall)
        return sorted(found)

    def _extent(self) -> tuple[np.ndarray, np.ndarray]:
        """Where particles are at any time, shape [n, 3], and their widths, without single drops that fly far."""
        kept = []
        for cloud, item in enumerate(self.animation.clouds):
            points = np.concatenate([self.animation.points(cloud, frame) for frame in self._frames])
            if item.role == "fluid" and len(points):
                low, high = np.percentile(points, [FAR, 100.0 - FAR], axis=0)
                points = np.clip(points, low, high)
            kept.append((points, np.tile(item.widths.astype(float), len(self._frames))))
        points, widths = (np.concatenate(parts) for parts in zip(*kept, strict=True))
        if len(points) == 0 or not np.isfinite(points).all():
            raise InputError(str(self.animation.path), "", "cannot be drawn: it needs particles, all at finite places")
        return points, widths

    def _points(self, frame: int) -> np.ndarray:
        return np.concatenate([self.animation.points(cloud, frame) for cloud in range(len(self.animation.clouds))])

    @cached_property
    def _widths(self) -> np.ndarray:
        return np.concatenate([cloud.widths for cloud in self.animation.clouds]).astype(float)

    @cached_property
    def _owners(self) -> np.ndarray:
        return np.repeat(np.arange(len(self.animation.clouds)), [len(cloud.ids) for cloud in self.animation.clouds])

    def spheres(self, frame: int) -> Spheres:
        """The particles of a frame as the camera sees them, cloud by cloud."""
        return self.camera.see(self._points(frame), self._widths)

    @property
    def _case(self) -> str:
        return str(self.animation.provenance.get("case", self.animation.path.parent.name))

    def time_label(self, frame: int) -> str:
        """The time of a frame, with the same digits in all frames; of a static run its load factor."""
        times = self.animation.times
        if self.animation.provenance.get("analysis") == "static":
            return f"load factor {times[frame]:.4g}"
        step = float(np.diff(times).min()) if len(times) > 1 else float(times[0])
        digits = int(np.clip(np.ceil(-np.log10(step)), 0, 9)) if step > 0.0 else 1
        return f"t = {times[frame]:.{digits}f} s"

    @cached_property
    def _annotations(self) -> Annotations:
        clouds = self.animation.clouds
        # a view from near has no one scale
        meters = self.animation.meters_per_unit * FINE / self.camera.scale if self._flat else None
        names = {cloud.name: tuple(cloud.color) for cloud in clouds}
        return Annotations(self.size, self.colourings, names, meters)


def draw_picture(
    folder: Path,
    out: Path | None = None,
    *,
    time: float | None = None,
    options: PictureOptions = DEFAULT_OPTIONS,
    overwrite: bool = False,
) -> Path:
    """Draw one moment of a run.

    Args:
        folder: Folder of the run.
        out: File to write, ending in .png or .webp; None is picture.png in the folder.
        time: The moment [s], of which the nearest frame is drawn; None is the last.
        options: Options of the picture.
        overwrite: Whether to replace the file.

    Returns:
        The file.

    Raises:
        InputError: The folder has no run, the run has no frame, an option is invalid, or the file cannot be written.
    """
    from PIL import Image

    path = out or folder / "picture.png"
    figures.require_format(path, FORMATS)
    animation = Animation(folder, finite=True)
    refuse_existing(path, overwrite)
    frame = len(animation) - 1 if time is None else find_frame(animation, time)
    picture = Image.fromarray(Painter(animation, options).draw(frame))
    figures.write_file(path, lambda temporary: picture.save(temporary, **SETTINGS[path.suffix.lower()]))
    return path


def _axes(points: np.ndarray, up_axis: str, view: tuple[float, float, float] | None) -> tuple[np.ndarray, bool]:
    """The camera's axes, and whether the particles lie in a plane, which is then seen from straight ahead."""
    up = "XYZ".index(up_axis)
    if view is not None:
        if not np.isfinite(view).all() or not np.any(view):
            raise InputError("--view", "", f"is {' '.join(f'{part:g}' for part in view)}, must be a direction")
        return space_axes(up, np.array(view, dtype=float)), False
    flat = np.ptp(points, axis=0) == 0.0
    if flat.sum() == 1:
        return plane_axes(int(flat.argmax()), up), True
    return space_axes(up), False


def _check_size(size: tuple[int, int]) -> None:
    said = f"is {size[0]} {size[1]}, must be at"
    if any(side < least for side, least in zip(size, SMALLEST, strict=True)):
        raise InputError("--size", "", f"{said} least {SMALLEST[0]} {SMALLEST[1]}")
    if max(size) > MOST:
        raise InputError("--size", "", f"{said} most {MOST} {MOST}")


def _only(spheres: Spheres, kept: np.ndarray) -> Spheres:
    return Spheres(spheres.centres[kept], spheres.depths[kept], spheres.radii[kept], spheres.bulges[kept])


def find_frame(animation: Animation, time: float) -> int:
    """The frame nearest to a moment [s].

    Raises:
        InputError: The run has nothing at that time.
    """
    first, last = float(animation.times[0]), float(animation.times[-1])
    slack = 0.51 * (last - first) / max(1, len(animation) - 1)
    if not first - slack <= time <= last + slack:
        raise InputError(
            "--time", "", f"is {time:g}, must be between {first:.4g} and {last:.4g} s, where the frames are"
        )
    return int(np.abs(animation.times - time).argmin())
