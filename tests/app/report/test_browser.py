"""The page in a real browser: it draws, plays, reacts, and logs nothing to the console."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.app.report.browser import Browser, find_browser
from tests.app.report.runs import write_run, write_tables, write_water
from tests.app.results import SPACE
from warp_mps.app.animation_reader import Animation
from warp_mps.app.cli import main

pytestmark = pytest.mark.skipif(find_browser() is None, reason="no browser is installed, such as Debian's chromium")
# parts of the picture's pixels that are of a colour of their own, and not the paper's
DRAWN = """(() => {
  const { gl } = report.scene, { width, height } = gl.canvas, pixels = new Uint8Array(4 * width * height);
  report.scene.draw();
  gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  let count = 0, colorful = 0;
  for (let i = 0; i < pixels.length; i += 4) {
    const [red, green, blue] = [pixels[i], pixels[i + 1], pixels[i + 2]];
    const least = Math.min(red, green, blue), most = Math.max(red, green, blue);
    count += most < 240;
    colorful += most - least > 40;
  }
  return [count / width / height, colorful / width / height];
})()"""


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    pytest.importorskip("websocket")
    with Browser(tmp_path_factory.mktemp("browser"), size=(900, 640)) as opened:
        yield opened


def show(browser: Browser, folder: Path) -> Browser:
    """Open the report of a folder, which has no complaint, and asks for nothing but itself."""
    assert main(["report", str(folder), "--overwrite"]) == 0
    browser.console.clear()
    browser.requests.clear()
    browser.open(folder / "report.html")
    assert browser.console == []
    assert browser.run("report.errors") == []
    assert browser.requests == [(folder / "report.html").resolve().as_uri()]
    return browser


def test_a_plane_is_drawn_and_played(browser: Browser, tmp_path: Path) -> None:
    write_run(tmp_path)
    page = show(browser, tmp_path)
    assert page.run("document.querySelector('h1').textContent") == "resting"
    assert page.run("report.camera.flat")
    covered, colorful = page.run(DRAWN)
    assert covered > 0.2
    assert colorful > 0.05
    # there are three frames, which last a second and a half
    assert page.run("report.scene.frame") == 0
    page.click("#forward")
    assert page.run("[report.scene.frame, report.player.playing]") == [1, False]
    page.click("#play")
    assert page.run("report.player.playing")
    page.run(
        "new Promise((done) => { const look = () => report.scene.frame !== 1 ? done()"
        " : requestAnimationFrame(look); look(); })"
    )
    page.click("#play")
    assert not page.run("report.player.playing")
    assert page.console == []


def test_the_page_unpacks_what_was_written(browser: Browser, tmp_path: Path) -> None:
    """Positions in the stage's centimetres become metres; pressures are 100 i + k."""
    write_run(tmp_path)
    page = show(browser, tmp_path)
    animation = Animation(tmp_path)
    page.run("report.controls.choose('pressure')")
    for frame in range(3):
        page.run(f"report.player.go({frame})")
        drawn = page.run("[...Array(8).keys()].map((i) => report.scene.place(report.scene.clouds[0], i).slice(0, 2))")
        assert np.array(drawn) == pytest.approx(0.01 * animation.points(0, frame)[:, [0, 2]], abs=1e-5)
        numbers = f"report.scene.clouds[0].numbers.slice({8 * frame}, {8 * frame + 8})"
        values = page.run(f"[...{numbers}].map((number) => report.colors.value(number))")
        assert values == pytest.approx(100.0 * np.arange(8) + frame, abs=0.01)
    assert page.run("document.querySelector('#colorbar .name').textContent") == "pressure [Pa]"
    assert page.run("document.querySelector('#stated').textContent") == "in the whole run 0 to 702 Pa"


def test_particles_and_diagrams_are_read_by_pointing(browser: Browser, tmp_path: Path) -> None:
    write_run(tmp_path)
    page = show(browser, tmp_path)
    page.run("Promise.all([report.controls.choose('pressure'), report.player.go(2)])")
    box = page.run(
        "(() => { const b = report.scene.canvas.getBoundingClientRect(); return [b.x, b.y, b.width, b.height] })()"
    )
    # where the camera sees particle 5
    place = page.run(
        "(() => { const x = report.scene.place(report.scene.clouds[0], 5), c = report.camera, t = c.target;"
        "return [(x[0] - t[0]) / c.half / c.aspect, (x[1] - t[1]) / c.half] })()"
    )
    page.mouse(box[0] + 0.5 * box[2] * (1 + place[0]), box[1] + 0.5 * box[3] * (1 - place[1]))
    page.run("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    words = page.run("document.querySelector('#hover').textContent").splitlines()
    assert words[0] == "block, particle 5"
    assert words[-1] == "pressure = 502 Pa"
    page.click(".diagram svg")
    assert page.run("report.animation.times[report.scene.frame]") == pytest.approx(0.01)
    read = page.run("[...document.querySelectorAll('.diagram .read text')].map((item) => item.textContent)")
    assert read == ["time 0.01 s", "x 0", "y 0.02"]
    assert page.console == []


def test_space_is_turned_cut_and_stretched(browser: Browser, tmp_path: Path) -> None:
    write_run(tmp_path, frame=SPACE)
    page = show(browser, tmp_path)
    assert not page.run("report.camera.flat")
    whole = page.run(DRAWN)
    assert whole[1] > 0.02
    views = page.run("[...document.querySelectorAll('#views button')].map((item) => item.textContent)")
    assert views == ["oblique", "front", "side", "top"]
    for number in range(1, 5):
        page.click(f"#views button:nth-child({number})")
        assert page.run(DRAWN)[1] > 0.01
    page.run("(() => { report.scene.cut = { axis: 0, part: 0.4 } })()")
    page.click("#views button:nth-child(1)")
    assert page.run(DRAWN)[1] < 0.8 * whole[1]
    page.run("report.player.go(2)")
    page.run("(() => { document.querySelector('#stretch').value = '3' })()")
    page.run("document.querySelector('#stretch').dispatchEvent(new Event('change'))")
    # three times the 0.04 m that the block has risen, above its centre's 0
    heights = page.run("[...Array(16).keys()].map((i) => report.scene.place(report.scene.clouds[0], i)[1])")
    assert np.mean(heights) == pytest.approx(0.12, abs=1e-4)
    assert page.console == []


def test_the_mouse_turns_moves_and_zooms(browser: Browser, tmp_path: Path) -> None:
    write_run(tmp_path, frame=SPACE)
    page = show(browser, tmp_path)
    page.run("report.scene.canvas.scrollIntoView({ block: 'center' })")
    x, y = page.run("(() => { const b = report.scene.canvas.getBoundingClientRect(); return [b.x + 90, b.y + 90] })()")
    start = camera(page)
    page.drag(x, y, 60, 30)
    turned = camera(page)
    assert turned["azimuth"] < start["azimuth"] - 0.1
    assert turned["elevation"] > start["elevation"] + 0.05
    assert turned["target"] == start["target"]
    page.drag(x, y, 60, 0, button="right")
    moved = camera(page)
    assert moved["azimuth"] == turned["azimuth"]
    assert np.linalg.norm(np.subtract(moved["target"], turned["target"])) > 0.01
    page.wheel(x, y, -240)
    assert camera(page)["distance"] < 0.9 * moved["distance"]
    page.call("Input.dispatchMouseEvent", type="mousePressed", x=x, y=y, button="left", clickCount=2)
    page.call("Input.dispatchMouseEvent", type="mouseReleased", x=x, y=y, button="left", clickCount=2)
    again = camera(page)
    assert again["distance"] == pytest.approx(start["distance"], rel=0.3)
    assert again["azimuth"] == turned["azimuth"]
    assert page.console == []


def camera(page: Browser) -> dict[str, Any]:
    """The camera, after all that the page was told has been heard."""
    page.run("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    return page.run(
        "(({ azimuth, elevation, distance, target }) => ({ azimuth, elevation, distance, target }))(report.camera)"
    )


def test_colours_stand_for_what_is_asked(browser: Browser, tmp_path: Path) -> None:
    write_run(tmp_path)
    page = show(browser, tmp_path)
    page.run("report.controls.choose('pressure')")
    marks = "[...document.querySelectorAll('#colorbar text')].map((item) => item.textContent)"
    assert page.run(marks) == ["0", "200", "400", "600", "800"]
    page.click("#now")
    assert page.run("report.colors.range") == pytest.approx([0.0, 700.0], abs=0.02)
    for field, value in (("lowest", "100"), ("highest", "5e2")):
        page.run(f"(() => {{ document.querySelector('#{field}').value = '{value}' }})()")
        page.run(f"document.querySelector('#{field}').dispatchEvent(new Event('change'))")
    assert page.run("report.colors.range") == [100.0, 500.0]
    assert page.run(marks) == ["\u2264 100", "200", "300", "400", "\u2265 500"]
    # the ends of the range are the ends of the map
    scaled = "((number) => number * report.colors.scaling()[0] + report.colors.scaling()[1])"
    assert page.run(f"{scaled}(65535 * 100 / 702)") == pytest.approx(0.0, abs=1e-6)
    assert page.run(f"{scaled}(65535 * 500 / 702)") == pytest.approx(1.0, abs=1e-6)
    page.run("(() => { document.querySelector('#lowest').value = 'much' })()")
    page.run("document.querySelector('#lowest').dispatchEvent(new Event('change'))")
    assert page.run("report.colors.range") == [100.0, 500.0]
    assert page.run("document.querySelector('#lowest').classList.contains('wrong')")
    page.run("report.controls.choose('')")
    assert page.run("document.querySelector('#colorbar').textContent") == ""
    assert page.console == []


def test_water_is_coloured_and_walls_can_be_hidden(browser: Browser, tmp_path: Path) -> None:
    write_water(tmp_path)
    page = show(browser, tmp_path)
    whole = page.run(DRAWN)
    assert page.run("document.querySelector('#quantity').value") == "pressure"
    assert page.run("document.querySelector('#history').hidden")
    page.click("#bodies label:nth-child(1) input")
    without = page.run(DRAWN)
    assert without[0] < whole[0] - 0.05
    assert without[1] == pytest.approx(whole[1], rel=0.05)
    # the lost particle is not drawn
    assert page.run("report.scene.place(report.scene.clouds[1], 47)") is not None
    page.run("report.player.go(3)")
    assert page.run("report.scene.place(report.scene.clouds[1], 47)") is None


def test_a_page_without_frames_has_its_diagrams(browser: Browser, tmp_path: Path) -> None:
    write_tables(tmp_path)
    page = show(browser, tmp_path)
    assert page.run("document.querySelector('#animation').hidden")
    assert page.run("document.querySelectorAll('.diagram').length") == 2
    page.click(".diagram svg")
    assert page.run("document.querySelectorAll('.diagram .read text').length") == 3
    assert page.console == []
