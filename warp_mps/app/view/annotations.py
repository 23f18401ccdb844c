"""The annotations of a picture: headline, colour bars or names, and a scale bar."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from warp_mps.app.view import figures
from warp_mps.app.view.colours import Colouring

# strips around the scene in a picture that is large enough [px]: left, top, right, bottom
STRIPS = (28.0, 58.0, 132.0, 52.0)
# width of a letter [px], of a point of its size
PIXELS_OF_LETTER = 0.84
LARGEST, SMALLEST, LEAST_FIELD = (1280, 800), (160, 120), (460.0, 200.0)


def scale(size: tuple[int, int]) -> float:
    """Scale of the text in a picture of that width and height [px]; 1 in a large picture."""
    return min(1.0, size[0] / 600.0, size[1] / 340.0)


def field(size: tuple[int, int]) -> tuple[float, float, float, float]:
    """Left, top, right and bottom of the part of a picture that is the scene's [px]."""
    left, top, right, bottom = (scale(size) * strip for strip in STRIPS)
    return left, top, size[0] - right, size[1] - bottom


def fitted_size(local: np.ndarray, width: float) -> tuple[int, int]:
    """Width and height of a picture that suits particles [px], even as videos need them.

    Args:
        local: Positions along the picture's right, its top and towards the viewer, shape [n, 3].
        width: Width of a particle, in the same unit.
    """
    extent = np.ptp(local[:, :2], axis=0) + width
    left, top, right, bottom = STRIPS
    most = np.array([LARGEST[0] - left - right, LARGEST[1] - top - bottom])
    room = np.maximum(extent * np.min(most / extent), LEAST_FIELD)
    return 2 * math.ceil((room[0] + left + right) / 2.0), 2 * math.ceil((room[1] + top + bottom) / 2.0)


class Annotations:
    """A picture without its scene.

    Args:
        size: Width and height [px].
        colourings: Meanings of the colours, one or several.
        names: Names of the bodies, walls and fluids and their own colours.
        meters: Length that a pixel shows [m]; None where that varies.
    """

    def __init__(
        self,
        size: tuple[int, int],
        colourings: Sequence[Colouring],
        names: Mapping[str, tuple[float, ...]],
        meters: float | None,
    ) -> None:
        self._size, self._scale = size, scale(size)
        with figures.style():
            self._figure = Figure(figsize=(size[0] / 100.0, size[1] / 100.0), dpi=100)
            self._canvas = FigureCanvasAgg(self._figure)
            axes = self._figure.add_axes((0.0, 0.0, 1.0, 1.0))
            axes.set_axis_off()
            # a pixel of the image is one of the figure
            self._image = axes.imshow(np.ones((size[1], size[0], 3)), aspect="auto", interpolation="nearest")
            self._headline = self._write(STRIPS[0], 20.0, "", size=13.0, weight="bold", va="top")
            if meters is not None:
                self._draw_length(meters)
            if colourings[0].name == "body":
                self._list(names)
            else:
                for number, colouring in enumerate(colourings):
                    self._draw_bar(colouring, number, len(colourings))

    def fill(self, pixels: np.ndarray, headline: str) -> np.ndarray:
        """The whole picture, as bytes, shape [height, width, 3].

        Args:
            pixels: Colours of the scene from 0 to 1, shape [height, width, 3].
            headline: Text above the scene.
        """
        self._image.set_data(pixels)
        self._headline.set_text(headline)
        self._canvas.draw()
        return np.asarray(self._canvas.buffer_rgba())[:, :, :3].copy()

    def _write(self, across: float, down: float, text: str, *, size: float, **more: Any) -> Any:
        """Text at a place counted from the upper left, in units of `scale`."""
        place = across * self._scale / self._size[0], 1.0 - down * self._scale / self._size[1]
        more = {"color": figures.INK, **more}
        return self._figure.text(*place, text, fontsize=size * self._scale, parse_math=False, **more)

    def _draw_bar(self, colouring: Colouring, number: int, count: int) -> None:
        """A colour bar beside the scene, one of some above each other."""
        (width, height), unit = self._size, self._scale
        _, top, _, bottom = field(self._size)
        middle, tall = 0.5 * (top + bottom), min(bottom - top, 420.0 * unit if count == 1 else 640.0 * unit)
        # from the top of the picture to the bottom of this bar
        down = middle - 0.5 * tall + tall * (number + 1) / count
        tall *= 0.94 / count if count == 1 else 0.86 / count
        box = ((width - 106.0 * unit) / width, (height - down) / height, 16.0 * unit / width, tall / height)
        ends = {(True, True): "both", (True, False): "min", (False, True): "max"}
        factor, _ = colouring.prefix
        mappable = ScalarMappable(Normalize(colouring.low / factor, colouring.high / factor), colouring.colormap)
        extend = ends.get((colouring.below, colouring.above), "neither")
        bar = self._figure.colorbar(mappable, cax=self._figure.add_axes(box), extend=extend, extendfrac=0.03)
        bar.outline.set_visible(False)
        bar.ax.tick_params(labelsize=10.0 * unit, length=3.0 * unit, width=0.8 * unit, pad=3.0 * unit)
        bar.ax.grid(False)
        label = colouring.label if count == 1 else colouring.label.replace(", ", ",\n")
        # along the bar, and no longer than it is
        fits = tall / (PIXELS_OF_LETTER * max(len(line) for line in label.splitlines()))
        bar.set_label(label, fontsize=min(11.0 * unit, fits), labelpad=6.0 * unit)

    def _list(self, names: Mapping[str, tuple[float, ...]]) -> None:
        """The bodies beside the scene, each with its colour."""
        height, across = self._size[1] / self._scale, self._size[0] / self._scale - 120.0
        step = min(24.0, (height - STRIPS[1] - STRIPS[3]) / max(1, len(names)))
        for number, (name, color) in enumerate(names.items()):
            down = STRIPS[1] + step * (number + 0.5)
            self._write(across, down, "\N{BLACK CIRCLE}", size=min(14.0, 0.6 * step), va="center", color=color)
            self._write(across + 18.0, down, name, size=min(10.0, 0.45 * step), va="center")

    def _draw_length(self, meters: float) -> None:
        """A length in the lower left."""
        length = _round_down(0.2 * self._size[0] * meters)
        start, share = STRIPS[0] * self._scale / self._size[0], length / meters / self._size[0]
        height = 18.0 * self._scale / self._size[1]
        line = Line2D([start, start + share], [height, height], color=figures.INK, linewidth=2.0 * self._scale)
        line.set_solid_capstyle("butt")
        self._figure.add_artist(line)
        self._write(STRIPS[0], self._size[1] / self._scale - 22.0, _length(length), size=10.0, va="bottom")


def _round_down(value: float) -> float:
    """The last of 1, 2 and 5 times a power of ten that is no greater."""
    power = 10.0 ** math.floor(math.log10(value))
    return max(step for step in (1.0, 2.0, 5.0) if step * power <= value * (1.0 + 1e-9)) * power


def _length(meters: float) -> str:
    for unit, size in (("km", 1e3), ("m", 1.0), ("cm", 0.01), ("mm", 1e-3)):
        if meters >= 0.999 * size:
            return f"{meters / size:.4g} {unit}"
    return f"{meters:.3g} m"
