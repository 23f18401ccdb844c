"""Pictures, diagrams, videos and reports of a run from Python, shown in a notebook; as the command line makes them."""

from __future__ import annotations

import base64
import html
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

# media types of what a notebook shows, by suffix
IMAGES = {".png": "image/png", ".webp": "image/webp", ".gif": "image/gif", ".svg": "image/svg+xml"}
VIDEOS = {".mp4": "video/mp4"}
REPORT_HEIGHT = 600


@dataclass(frozen=True)
class ResultFile(os.PathLike):
    """A file that was made of a run: its path wherever one is expected, and its content in a notebook.

    Attributes:
        path: The file.
    """

    path: Path

    def __fspath__(self) -> str:
        return str(self.path)

    def __str__(self) -> str:
        return str(self.path)

    def _repr_png_(self) -> bytes | None:
        return self.path.read_bytes() if self.path.suffix.lower() == ".png" else None

    def _repr_html_(self) -> str | None:
        suffix = self.path.suffix.lower()
        if suffix == ".html":
            source = html.escape(self.path.as_posix())
            link = f'<a href="{source}" target="_blank">{source}</a>'
            return f'{link}<br><iframe src="{source}" width="100%" height="{REPORT_HEIGHT}"></iframe>'
        if suffix in VIDEOS:
            return f'<video controls loop src="{self._data(VIDEOS)}"></video>'
        return f'<img src="{self._data(IMAGES)}">' if suffix in IMAGES and suffix != ".png" else None

    def _data(self, types: Mapping[str, str]) -> str:
        content = base64.b64encode(self.path.read_bytes()).decode()
        return f"data:{types[self.path.suffix.lower()]};base64,{content}"


def picture(
    folder: str | Path,
    out: str | Path | None = None,
    *,
    time: float | None = None,
    overwrite: bool = True,
    **options: Any,
) -> ResultFile:
    """Draw a moment of a run: particles as shaded spheres, coloured by a quantity, with a colour bar.

    Args:
        folder: Folder of the run.
        out: File to write, ending in .png or .webp; None is picture.png in the folder.
        time: The moment [s], of which the nearest frame is drawn; None is the last.
        overwrite: Whether to replace the file.
        options: ``colour``, ``limits``, ``size`` and ``view``, see `warp_mps.app.view.picture.PictureOptions`.

    Returns:
        The file.

    Raises:
        InputError: The folder has no run, the run has no frame, an option is invalid, or the file cannot be written.
    """
    from warp_mps.app.view.picture import PictureOptions, draw_picture

    chosen = PictureOptions(**options)
    return ResultFile(draw_picture(Path(folder), _path(out), time=time, options=chosen, overwrite=overwrite))


def plot(folder: str | Path, out: str | Path | None = None, *, overwrite: bool = True) -> ResultFile:
    """Draw every probe and the energies of a run against time, with the references of the case.

    Args:
        folder: Folder of the run.
        out: File to write, ending in .png, .svg or .pdf; None is probes.png in the folder.
        overwrite: Whether to replace the file.

    Returns:
        The file.

    Raises:
        InputError: The folder has no run, the run has no rows, or the file cannot be written.
    """
    from warp_mps.app.view.plot import plot_history

    return ResultFile(plot_history(Path(folder), _path(out), overwrite=overwrite))


def video(
    folder: str | Path,
    out: str | Path | None = None,
    *,
    seconds: float | None = None,
    overwrite: bool = True,
    **options: Any,
) -> ResultFile:
    """Make a video of a run, of pictures as `picture` draws them, all from one place.

    Args:
        folder: Folder of the run.
        out: File to write, ending in .mp4 (needs warp_mps[video]), .webp or .gif; None is video.mp4 in the folder, or
            video.webp without imageio-ffmpeg.
        seconds: How long it plays [s]; None is as the animation plays, at most 20 (.mp4) or 10.
        overwrite: Whether to replace the file.
        options: As of `picture`.

    Returns:
        The file.

    Raises:
        InputError: The folder has no run, an option is invalid, or the file cannot be written.
    """
    from warp_mps.app.view.picture import PictureOptions
    from warp_mps.app.view.video import make_video

    chosen = PictureOptions(**options)
    path, _, _ = make_video(Path(folder), _path(out), seconds=seconds, options=chosen, overwrite=overwrite)
    return ResultFile(path)


def report(folder: str | Path, out: str | Path | None = None, *, overwrite: bool = True) -> ResultFile:
    """Write a run as one HTML page: the animation, the measurements beside their references, diagrams and settings.

    Args:
        folder: Folder of the run.
        out: File to write, ending in .html; None is report.html in the folder.
        overwrite: Whether to replace the file.

    Returns:
        The file.

    Raises:
        InputError: The folder has no run, or the file cannot be written.
    """
    from warp_mps.app.report.watch import report_run

    return ResultFile(report_run(Path(folder), _path(out), overwrite=overwrite, announce=lambda _: None))


def _path(out: str | Path | None) -> Path | None:
    return None if out is None else Path(out)
