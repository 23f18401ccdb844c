"""Pictures and videos of a result all of whose values are known."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.app.results import SPACE, write_result
from tests.scenes import RUBBER
from warp_mps.app.animation_reader import Animation
from warp_mps.app.cli import main
from warp_mps.app.report.frames import make_frames
from warp_mps.app.report.quantities import quantities
from warp_mps.app.view.colours import WALL, choose_colouring, choose_colourings, robust_range
from warp_mps.app.view.picture import Painter, PictureOptions, find_frame
from warp_mps.app.view.video import pace
from warp_mps.particles.filling import fill_scene
from warp_mps.scene import Body, Fluid, Scene
from warp_mps.shapes import Box
from warp_mps.usd.animation.writer import AnimationWriter

SIZE = ("--size", "360", "240")


@pytest.fixture
def plane(tmp_path: Path) -> Path:
    write_result(tmp_path)
    return tmp_path


@pytest.fixture
def space(tmp_path: Path) -> Path:
    write_result(tmp_path, frame=SPACE)
    return tmp_path


def refusal(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert main(list(arguments)) == 2
    text = capsys.readouterr().err
    assert text.count("\n") == 1
    return text


def painted(folder: Path, frame: int = 0, **options: object) -> np.ndarray:
    return Painter(Animation(folder), PictureOptions(size=(360, 240), **options)).draw(frame).astype(int)  # type: ignore[arg-type]


def test_a_picture_is_a_file_of_the_size_that_was_asked_for(plane: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["picture", str(plane), *SIZE]) == 0
    assert capsys.readouterr().out == f"{plane / 'picture.png'}\n"
    picture = Image.open(plane / "picture.png")
    assert (picture.format, picture.size, picture.mode) == ("PNG", (360, 240), "RGB")
    assert "exists; use --overwrite" in refusal(capsys, "picture", str(plane), *SIZE)
    assert main(["picture", str(plane), *SIZE, "--overwrite", "--time", "0.01"]) == 0
    assert not np.array_equal(np.asarray(picture), np.asarray(Image.open(plane / "picture.png")))
    assert sorted(path.name for path in plane.iterdir()) == ["picture.png", "run.usdc"]


def test_the_headline_has_the_time_or_the_load_factor(plane: Path) -> None:
    animation = Animation(plane)
    painter = Painter(animation)
    assert [painter.time_label(frame) for frame in range(3)] == ["t = 0.00 s", "t = 0.01 s", "t = 0.02 s"]
    animation.provenance = {**animation.provenance, "analysis": "static"}
    assert painter.time_label(1) == "load factor 0.01"


def test_particles_are_where_the_camera_has_them_in_the_colours_of_their_values(plane: Path) -> None:
    animation = Animation(plane)
    painter = Painter(animation, PictureOptions(size=(720, 480)))
    image, seen = painter.draw(2) / 255.0, painter.spheres(2)
    middles = (seen.centres / 2.0).astype(int)
    assert painter.colourings[0].name == "von_mises"
    colors = np.concatenate([painter.colourings[0].colors(animation, cloud, 2) for cloud in (0, 1)])
    for (column, row), color in zip(middles, colors, strict=True):
        # light changes how bright a particle is, not its hue
        found = image[row, column] - image[row, column].min()
        assert found / max(found.max(), 0.1) == pytest.approx((color - color.min()) / max(np.ptp(color), 0.1), abs=0.15)
    assert np.array_equal(colors[8], WALL)
    # upright in a stage with Z up: the floor is below the block
    assert middles[8:, 1].min() > middles[:8, 1].max()


def test_frames_differ_by_what_moved(plane: Path) -> None:
    first, last = painted(plane, 0), painted(plane, 2)
    changed = np.abs(first - last).max(axis=2) > 8
    below = Painter(Animation(plane), PictureOptions(size=(360, 240))).spheres(0).centres[8:, 1].min() / 2.0
    # the block and the time change, the floor does not
    assert changed[: int(below) - 8].any()
    assert not changed[int(below) : 205].any()


def test_a_nearer_body_hides_a_farther_one_and_walls_before_it_are_of_glass(space: Path) -> None:
    """From below the floor stands before the block, which is seen through it; from above it is the other way."""

    def glass(view: tuple[float, float, float]) -> list[int]:
        return Painter(Animation(space), PictureOptions(size=(360, 240), view=view)).transparent_walls

    assert glass((0.3, -1.0, 0.2)) == [1]
    assert glass((0.3, 1.0, 0.2)) == []
    painter = Painter(Animation(space), PictureOptions(size=(360, 240), view=(0.0, 1.0, 1e-3), colour="body"))
    image, seen = painter.draw(0).astype(int), painter.spheres(0)
    assert seen.depths[16:].min() > seen.depths[:16].max()
    hues = {"hidden": set(), "seen": set()}  # type: ignore[var-annotated]
    for centre in seen.centres[16:]:
        column, row = (centre / 2.0).astype(int)
        apart = float((np.linalg.norm(seen.centres[:16] - centre, axis=1) / seen.radii[:16]).min())
        if not 0.8 < apart < 1.1:
            hues["hidden" if apart < 1.0 else "seen"].add(bool(np.ptp(image[row, column]) > 60))
    # where the block is above the floor its orange is seen, and elsewhere the floor's grey
    assert hues == {"hidden": {True}, "seen": {False}}


def test_the_direction_of_view_turns_the_picture(space: Path) -> None:
    assert not np.array_equal(painted(space), painted(space, view=(1.0, 0.2, 0.1)))
    assert np.array_equal(painted(space), painted(space))


@pytest.mark.parametrize("view", [None, (0.2, 0.9, 0.1)])
def test_everything_is_in_the_picture(space: Path, view: tuple[float, float, float] | None) -> None:
    painter = Painter(Animation(space), PictureOptions(size=(400, 300), view=view))
    for frame in range(3):
        seen = painter.spheres(frame)
        low, high = (seen.centres - seen.radii[:, None]).min(axis=0), (seen.centres + seen.radii[:, None]).max(axis=0)
        assert (low > 0).all()
        assert (high < [800, 600]).all()
    assert np.ptp(painter.spheres(0).centres[:, 0]) > 250 or np.ptp(painter.spheres(0).centres[:, 1]) > 250


def test_limits_of_colours() -> None:
    assert robust_range(np.linspace(0.0, 97.0, 1000)) == (0.0, 100.0)
    assert robust_range(np.linspace(-40.0, 97.0, 1000)) == (-100.0, 100.0)
    assert robust_range(np.linspace(-970.0, -3.0, 1000)) == (-1000.0, 0.0)
    assert robust_range(np.zeros(3)) == (0.0, 1.0)
    assert robust_range(np.full(3, 7.3)) == (0.0, 8.0)
    # single values do not stretch them
    assert robust_range(np.concatenate([np.linspace(0.0, 97.0, 10_000), [1e9]])) == (0.0, 100.0)


def test_labels_have_units(plane: Path) -> None:
    animation = Animation(plane)
    assert choose_colouring(animation).label == "von Mises stress [Pa]"
    assert choose_colouring(animation, "pressure", (0.0, 3e5)).label == "pressure [kPa]"
    speed = choose_colouring(animation, "speed")
    assert (speed.label, speed.low, speed.high) == ("speed [m/s]", 0.0, 2.0)
    beyond = choose_colouring(animation, "pressure", (100.0, 300.0))
    assert (beyond.below, beyond.above) == (True, True)


@pytest.fixture
def coupled(tmp_path: Path) -> Animation:
    water = Fluid(name="water", shape=Box((0.2, 0.2), center=(1.0, 0.0)), spacing=0.1)
    block = Body(name="block", shape=Box((0.2, 0.2)), material=RUBBER, spacing=0.1)
    scene = Scene(bodies=(block,), fluids=(water,), gravity=(0.0, -9.81), duration=1.0)
    particles = fill_scene(scene)
    writer = AnimationWriter(
        tmp_path / "run.usdc", particles, scene.frame, frame_rate=1.0, provenance={}, primvars=("pressure", "von_mises")
    )
    values = np.array([1e6] * 4 + [300.0, 200.0, 400.0, 0.0])
    writer.write(0.0, particles.positions, particles.velocities, pressure=values, von_mises=values)
    writer.close()
    return Animation(tmp_path)


def test_outputs_are_of_bodies(coupled: Animation) -> None:
    assert [cloud.scalars for cloud in coupled.clouds] == [("pressure", "von_mises"), ("pressure",)]
    names = [set(quantities(coupled, cloud, 0, axes="xy")) for cloud in (0, 1)]
    assert names == [{"speed", "displacement", "von_mises", "pressure in bodies"}, {"speed", "pressure"}]
    facts = make_frames(coupled).facts
    assert facts["first"] == "pressure"
    assert {item["name"]: item["greatest"] for item in facts["quantities"]}["pressure"] == 400.0


def test_in_coupled_runs_water_has_its_pressure_and_bodies_their_stress(coupled: Animation) -> None:
    animation, colouring = coupled, choose_colouring(coupled)
    assert (colouring.name, colouring.low, colouring.high) == ("pressure", 0.0, 400.0)
    assert np.array_equal(colouring.colors(animation, 0, 0), np.tile(animation.clouds[0].color, (4, 1)))
    assert len(np.unique(colouring.colors(animation, 1, 0), axis=0)) == 4
    water, bodies = choose_colourings(animation)
    assert water == colouring
    assert (bodies.name, bodies.low, bodies.high) == ("von_mises", 0.0, 1e6)
    assert (water.label, bodies.label) == ("pressure, fluid [Pa]", "von Mises stress, bodies [kPa]")
    assert bodies.colormap is not water.colormap
    both = Painter(animation)
    assert np.array_equal(both.colors(0, 0), bodies.colors(animation, 0, 0))
    assert np.array_equal(both.colors(1, 0), water.colors(animation, 1, 0))
    # whichever of the two is asked for, the limits are its own
    for name, own in (("pressure", 0), ("von_mises", 1)):
        found = choose_colourings(animation, name, (1.0, 2.0))
        assert [item.name for item in found] == ["pressure", "von_mises"]
        assert (found[own].low, found[own].high) == (1.0, 2.0)
        assert found[1 - own] == (water, bodies)[1 - own]
    assert [item.label for item in choose_colourings(animation, "speed")] == ["speed [m/s]"]


def test_find_frame(plane: Path) -> None:
    animation = Animation(plane)
    assert [find_frame(animation, time) for time in (0.0, 0.004, 0.006, 0.02, 0.0249)] == [0, 0, 1, 2, 2]


def test_what_cannot_be_drawn_is_refused(plane: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = str(plane)
    assert "--time: is 0.5, must be between 0 and 0.02 s" in refusal(capsys, "picture", folder, "--time", "0.5")
    assert "--time: is nan" in refusal(capsys, "picture", folder, "--time", "nan")
    text = refusal(capsys, "picture", folder, "--colour", "heat")
    assert "--colour: is heat, which is not in" in text
    assert "it has body, speed, pressure, von_mises" in text
    assert "smaller one first" in refusal(capsys, "picture", folder, "--limits", "3", "1")
    assert "must be at least" in refusal(capsys, "picture", folder, "--size", "20", "4000")
    assert "must be at most" in refusal(capsys, "picture", folder, "--size", "200", "40000")
    assert "must be a direction" in refusal(capsys, "picture", folder, "--view", "0", "0", "0")
    assert "must end in .png or .webp" in refusal(capsys, "picture", folder, "--out", "a.jpg")
    assert "must end in .mp4 or .webp or .gif" in refusal(capsys, "video", folder, "--out", "a.avi")
    assert "--seconds: is 0, must be" in refusal(capsys, "video", folder, "--seconds", "0")
    assert "is not a folder" in refusal(capsys, "picture", str(plane / "none"))
    write_result(plane, frames=0)
    (plane / "run.usdc").unlink()
    assert "does not contain a run" in refusal(capsys, "video", folder)
    assert not list(plane.glob("*.png"))


def test_a_result_without_frames_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from pxr import Usd, UsdGeom

    stage = Usd.Stage.CreateNew(str(tmp_path / "run.usdc"))
    UsdGeom.Points.Define(stage, "/Result/block")
    stage.Save()
    assert "has no frames" in refusal(capsys, "picture", str(tmp_path))


def test_pace() -> None:
    def shown(*arguments: float | None) -> tuple[int, float, int]:
        frames, rate = pace(*arguments, 20.0, 30.0)  # type: ignore[arg-type]
        assert frames[0] == 0
        assert (np.diff(frames) > 0).all()
        return len(frames), rate, int(frames[-1])

    assert shown(101, 30.0, None) == (101, 30.0, 100)
    assert shown(10, 5.0, None) == (10, 5.0, 9)
    assert shown(9000, 30.0, None) == (600, 30.0, 8999)
    assert shown(101, 30.0, 1.0) == (30, 30.0, 100)
    assert shown(101, 30.0, 202.0) == (101, 0.5, 100)
    assert pace(1, 30.0, None, 20.0, 30.0)[0].tolist() == [0]


@pytest.mark.parametrize("suffix", ["webp", pytest.param("gif", marks=pytest.mark.long)])
def test_videos_without_an_encoder(suffix: str, plane: Path) -> None:
    out = plane / f"new/run.{suffix}"
    assert main(["video", str(plane), "--out", str(out), *SIZE, "--seconds", "0.3"]) == 0
    video = Image.open(out)
    assert (video.size, video.n_frames, video.info["loop"]) == ((360, 240), 3, 0)  # type: ignore[attr-defined]
    pictures = []
    for number in range(3):
        video.seek(number)
        pictures.append(np.asarray(video.convert("RGB")).astype(int))
        assert np.abs(pictures[-1] - painted(plane, number)).mean() < 3.0
    assert np.abs(pictures[0] - pictures[2]).max() > 100


def test_videos_as_mp4(plane: Path) -> None:
    encoder = pytest.importorskip("imageio_ffmpeg")
    assert main(["video", str(plane), "--size", "361", "241"]) == 0
    frames = encoder.read_frames(str(plane / "video.mp4"))
    facts = next(frames)
    assert (facts["size"], facts["codec"], facts["fps"]) == ((360, 240), "h264", 30.0)
    pictures = [np.frombuffer(frame, dtype=np.uint8).reshape(240, 360, 3).astype(int) for frame in frames]
    assert len(pictures) == 3
    assert np.abs(pictures[2] - painted(plane, 2)).mean() < 4.0


def test_mp4_needs_an_encoder(plane: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("warp_mps.app.view.video.find_spec", lambda _: None)
    text = refusal(capsys, "video", str(plane), "--out", str(plane / "a.mp4"))
    assert "needs imageio-ffmpeg: pip install warp_mps[video], or choose .webp or .gif" in text
    assert main(["video", str(plane), *SIZE]) == 0
    assert (plane / "video.webp").exists()
