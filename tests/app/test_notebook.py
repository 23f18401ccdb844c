"""Pictures, diagrams, videos and reports from Python, and what a notebook shows of them."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

import warp_mps as mps
from tests.scenes import beam
from warp_mps.app.cli import main
from warp_mps.app.notebook import ResultFile

SIZE: dict[str, Any] = {"size": (360, 240)}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A short run with a probe."""
    path = tmp_path_factory.mktemp("run")
    tip = mps.Probe(name="tip", point=(0.15, 0.0))
    mps.run_scene(beam(2, duration=0.002, frame_rate=1000.0, probes=(tip,)), path, quiet=True)
    return path


def test_a_picture_is_that_of_the_command_line(folder: Path, tmp_path: Path) -> None:
    made = mps.picture(folder, time=0.001, colour="speed", **SIZE)
    assert os.fspath(made) == str(made) == str(folder / "picture.png")
    other = tmp_path / "other.png"
    assert (
        main(
            [
                "picture",
                str(folder),
                "--time",
                "0.001",
                "--colour",
                "speed",
                "--size",
                "360",
                "240",
                "--out",
                str(other),
            ]
        )
        == 0
    )
    assert Image.open(made).tobytes() == Image.open(other).tobytes()
    assert made._repr_png_() == other.read_bytes()
    assert made._repr_html_() is None


def test_a_picture_is_replaced_unless_that_is_forbidden(folder: Path) -> None:
    mps.picture(folder, **SIZE)
    mps.picture(str(folder), **SIZE)
    with pytest.raises(mps.InputError, match="use --overwrite"):
        mps.picture(folder, overwrite=False, **SIZE)


def test_diagrams_are_images(folder: Path, tmp_path: Path) -> None:
    assert (mps.plot(folder)._repr_png_() or b"").startswith(b"\x89PNG")
    shown = mps.plot(folder, tmp_path / "probes.svg")
    assert shown._repr_png_() is None
    assert (shown._repr_html_() or "").startswith('<img src="data:image/svg+xml;base64,')


def test_a_video_is_an_image_that_moves(folder: Path) -> None:
    made = mps.video(folder, folder / "video.webp", seconds=1.0, **SIZE)
    assert Image.open(made).n_frames == 3
    assert (made._repr_html_() or "").startswith('<img src="data:image/webp;base64,')


def test_a_report_is_framed(folder: Path) -> None:
    made = mps.report(folder)
    assert made.path.read_text(encoding="utf-8").lstrip().lower().startswith("<!doctype html>")
    assert f'<iframe src="{(folder / "report.html").as_posix()}"' in (made._repr_html_() or "")


def test_what_a_notebook_cannot_show_has_no_representation(tmp_path: Path) -> None:
    pdf = ResultFile(tmp_path / "probes.pdf")
    assert pdf._repr_png_() is None
    assert pdf._repr_html_() is None
