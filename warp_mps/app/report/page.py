"""The page: the template, its style and its scripts, with a run's data in them, in one file."""

from __future__ import annotations

import json
from functools import cache
from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any

import matplotlib as mpl
import numpy as np

from warp_mps.app.report import tables
from warp_mps.app.report.diagrams import make_diagrams
from warp_mps.app.report.frames import Frames, make_frames
from warp_mps.app.report.run_data import Run, read_run
from warp_mps.app.view.colours import DIVERGING, SEQUENTIAL
from warp_mps.errors import InputError
from warp_mps.results.atomic_write import write_whole
from warp_mps.version import __version__

# in the order in which they need each other
SCRIPTS = ("data", "colors", "camera", "shaders", "scene", "pick", "plots", "controls", "player", "main")
# beside the two of pictures, which come first
MORE_MAPS = ("viridis", "cividis", "turbo")


def write_report(folder: Path, path: Path, *, reload: float | None = None) -> tuple[str, tuple[str, ...]]:
    """Write the page of a run.

    Args:
        folder: Folder of the run.
        path: File to write.
        reload: Seconds after which an open page reloads while the run goes on; None disables it.

    Returns:
        State of the run and the remarks of `Run`. The animation is closed: some systems cannot replace an open file.

    Raises:
        InputError: There is no run in the folder, or the file cannot be written.
    """
    run = read_run(folder)
    text = page(run, reload=reload)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, text)
    except OSError as error:
        raise InputError(str(path), "", f"cannot be written: {error.strerror}") from error
    return run.state, run.remarks


def page(run: Run, *, reload: float | None = None) -> str:
    """The text of the page of a run; see :func:`write_report`."""
    frames = make_frames(run.animation) if run.animation else None
    remarks = [*run.summary.remarks, *run.remarks, *(frames.remarks if frames else [])]
    data = {
        "frames": frames.facts if frames else None,
        "diagrams": make_diagrams(run),
        "timeLabel": "load factor" if tables.is_static(run) else "time",
        "timeUnit": "" if tables.is_static(run) else "s",
        "maps": _color_maps(),
        "reload": reload if run.state == "running" else None,
    }
    description = str(run.summary.settings.get("description") or "")
    return Template(_resource("report.html")).substitute(
        title=escape(run.summary.case),
        state=run.state,
        state_text=escape(tables.state_text(run)),
        description="".join(f"<p>{escape(part)}</p>" for part in description.split("\n\n") if part.strip()),
        remarks="".join(f"<li>{escape(text)}</li>" for text in remarks),
        cards=tables.cards(run),
        measurements=tables.measurements(run),
        accounts=tables.accounts(run),
        settings=tables.settings(run),
        program=escape(f"warp_mps {__version__}"),
        style=_resource("report.css"),
        data=_json(data),
        blocks=_blocks(frames),
        script="\n".join(_resource(f"{name}.js") for name in SCRIPTS),
    )


def _blocks(frames: Frames | None) -> str:
    texts = frames.blocks if frames else []
    return "\n".join(f'<script type="text/plain" id="block{k}">{text}</script>' for k, text in enumerate(texts))


def _json(data: Any) -> str:
    """JSON that can stand in a script element: nothing in it can end the element."""
    text = json.dumps(data, separators=(",", ":"), allow_nan=False)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _color_maps() -> dict[str, list[int]]:
    """Red, green and blue from 0 to 255 of 256 steps of each map; the first for one sign, the second for both."""
    maps = (SEQUENTIAL, DIVERGING, *(mpl.colormaps[name] for name in MORE_MAPS))
    steps = np.linspace(0.0, 1.0, 256)
    return {item.name: (255.0 * item(steps)[:, :3]).round().astype(int).ravel().tolist() for item in maps}


@cache
def _resource(name: str) -> str:
    return (files("warp_mps.app.report") / "page" / name).read_text(encoding="utf-8")
