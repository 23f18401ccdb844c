"""Videos of a run: pictures of its frames one after the other."""

from __future__ import annotations

import math
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from PIL import Image
from rich.console import Console
from rich.progress import track

from warp_mps.app.animation_reader import Animation, refuse_existing
from warp_mps.app.view import figures
from warp_mps.app.view.picture import DEFAULT_OPTIONS, Painter, PictureOptions
from warp_mps.errors import InputError

# how long each plays at most unless it is asked to [s], and how many pictures a second it shows at most [1/s]: the
# pictures of WebP and GIF are all held at a time
LIMITS = {"mp4": (20.0, 30.0), "webp": (10.0, 20.0), "gif": (10.0, 20.0)}
FORMATS = tuple(LIMITS)
# pause on the last picture of a looped animation [ms]
REST = 900


def make_video(
    folder: Path,
    out: Path | None = None,
    *,
    seconds: float | None = None,
    options: PictureOptions = DEFAULT_OPTIONS,
    overwrite: bool = False,
) -> tuple[Path, int, float]:
    """Make a video of a run.

    Args:
        folder: Folder of the run.
        out: File to write, ending in .mp4, .webp or .gif; None is video.mp4 in the folder, or video.webp where there is
            no imageio-ffmpeg.
        seconds: How long it plays [s]; None is as the animation plays, at most as `LIMITS`
            says.
        options: Options of the pictures.
        overwrite: Whether to replace the file.

    Returns:
        The file, its number of pictures, and how long it plays [s].

    Raises:
        InputError: There is no run in the folder, an option is invalid, or the file cannot be written.
    """
    encodes = find_spec("imageio_ffmpeg") is not None
    path = out or folder / ("video.mp4" if encodes else "video.webp")
    figures.require_format(path, FORMATS)
    if path.suffix.lower() == ".mp4" and not encodes:
        raise InputError(str(path), "", "needs imageio-ffmpeg: pip install warp_mps[video], or choose .webp or .gif")
    if seconds is not None and not (math.isfinite(seconds) and seconds > 0.0):
        raise InputError("--seconds", "", f"is {seconds:g}, must be above 0")
    animation = Animation(folder, finite=True)
    refuse_existing(path, overwrite)
    painter = Painter(animation, _even(options))
    frames, rate = pace(len(animation), animation.playback_rate, seconds, *LIMITS[path.suffix.lower()[1:]])
    console = Console(stderr=True)
    shown = track(frames, "drawing", console=console, transient=True, disable=not console.is_terminal)
    pictures = (painter.draw(int(frame)) for frame in shown)
    write = _write_mp4 if path.suffix.lower() == ".mp4" else _write_images
    figures.write_file(path, lambda temporary: write(temporary, pictures, rate, painter.size))
    return path, len(frames), len(frames) / rate


def pace(
    count: int, playback_rate: float, seconds: float | None, longest: float, fastest: float
) -> tuple[np.ndarray, float]:
    """Which frames are shown, and how many a second.

    Args:
        count: Frames of the animation.
        playback_rate: Frames that a player shows in a second [1/s].
        seconds: How long the video plays [s]; None is as long as the animation, at most `longest`.
        longest: See there [s].
        fastest: Pictures a second at most [1/s].

    Returns:
        Numbers of the frames, and pictures per second [1/s].
    """
    seconds = min(count / playback_rate, longest) if seconds is None else seconds
    shown = int(np.clip(round(seconds * fastest), 1, count))
    return np.linspace(0, count - 1, shown).round().astype(int), shown / seconds


def _even(options: PictureOptions) -> PictureOptions:
    """Sides of even length, which is what the usual coding of videos needs."""
    if options.size is None:
        return options
    return PictureOptions(
        options.colour, options.limits, (options.size[0] // 2 * 2, options.size[1] // 2 * 2), options.view
    )


def _write_mp4(path: Path, pictures: Iterator[np.ndarray], rate: float, size: tuple[int, int]) -> None:
    """H.264 that every player shows."""
    import imageio_ffmpeg

    settings = ["-crf", "18", "-preset", "medium", "-movflags", "+faststart"]
    writer = imageio_ffmpeg.write_frames(
        str(path), size, fps=rate, codec="libx264", macro_block_size=2, quality=None, output_params=settings
    )
    writer.send(None)
    try:
        for picture in pictures:
            writer.send(np.ascontiguousarray(picture))
    finally:
        writer.close()


def _write_images(path: Path, pictures: Iterator[np.ndarray], rate: float, size: tuple[int, int]) -> None:
    """WebP or GIF, played over and over."""
    images = [Image.fromarray(picture) for picture in pictures]
    durations = [round(1000.0 / rate)] * len(images)
    durations[-1] += REST
    settings = {"quality": 85, "method": 4} if path.suffix.lower() == ".webp" else {"optimize": True}
    images[0].save(path, save_all=True, append_images=images[1:], duration=durations, loop=0, **settings)
