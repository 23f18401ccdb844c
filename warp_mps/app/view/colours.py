"""Colour maps: the quantity that colours the particles of a picture, and its range."""

from __future__ import annotations

import math
from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
from matplotlib.colors import Colormap, LinearSegmentedColormap

from warp_mps.app.animation_reader import UNITS, Animation
from warp_mps.errors import InputError

# for values of one sign, lighter from one end to the other, and light enough for shaded spheres
SEQUENTIAL = LinearSegmentedColormap.from_list(
    "water", ["#3159ad", "#2487cb", "#2fb1bb", "#7dce84", "#d3e051", "#ffe11f"]
)
# beside the first
SECOND = LinearSegmentedColormap.from_list("warm", ["#f7dfb0", "#f2a65a", "#d9532c", "#8c1c3a"])
# for values of both signs
DIVERGING = mpl.colormaps["coolwarm"]
NAMES = {"von_mises": "von Mises stress", "strain_energy": "strain energy"}
WALL = np.array([0.78, 0.79, 0.80])
# percentage of the values beyond the range of the colours at either end
BEYOND = 0.3
PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"))


@dataclass(frozen=True)
class Colouring:
    """How particles are coloured.

    Attributes:
        name: ``body``, ``speed`` or the name of a quantity of the animation.
        low: Value of the first colour [SI units].
        high: Value of the last colour [SI units].
        below: Whether there are lower values.
        above: Whether there are higher values.
        of: ``fluid`` or ``bodies`` where it is theirs alone in a run of both; that of bodies takes other colours.
    """

    name: str
    low: float = 0.0
    high: float = 1.0
    below: bool = False
    above: bool = False
    of: str = ""

    @property
    def colormap(self) -> Colormap:
        """The colours from the low end to the high one."""
        if self.low < 0.0 < self.high:
            return DIVERGING
        return SECOND if self.of == "bodies" else SEQUENTIAL

    @property
    def prefix(self) -> tuple[float, str]:
        """Factor and prefix of the unit that makes its values short."""
        unit, size = UNITS.get(self.name, "m/s"), max(abs(self.low), abs(self.high))
        if unit not in ("Pa", "J/m^3"):
            return 1.0, ""
        return next(((factor, text) for factor, text in PREFIXES if size >= 2.0 * factor), PREFIXES[-1])

    @property
    def label(self) -> str:
        """Label of the colour bar: quantity, owner and unit."""
        owner_of = f", {self.of}" if self.of else ""
        return f"{NAMES.get(self.name, self.name)}{owner_of} [{self.prefix[1]}{UNITS.get(self.name, 'm/s')}]"

    def colors(self, animation: Animation, cloud: int, frame: int) -> np.ndarray:
        """Colours of a cloud, from 0 to 1 as a screen shows them, shape [n, 3]."""
        item = animation.clouds[cloud]
        if self.name == "body":
            return np.tile(item.color, (len(item.ids), 1))
        if not has_colour(animation, cloud, self.name):
            return np.tile(WALL if item.role == "wall" else item.color, (len(item.ids), 1))
        share = (values(animation, cloud, frame, self.name) - self.low) / (self.high - self.low)
        return np.asarray(self.colormap(np.clip(share, 0.0, 1.0))[:, :3])


Colourings = tuple[Colouring, ...]


def choose_colouring(
    animation: Animation, name: str | None = None, limits: tuple[float, float] | None = None
) -> Colouring:
    """Quantity that gives the colours, the same for all frames.

    Args:
        animation: The run.
        name: ``body``, ``speed`` or a quantity of the run; None is the pressure of fluids, and without any
            the von Mises stress or else the pressure.
        limits: Values of the first and the last colour [SI units]; None takes them from the run.

    Raises:
        InputError: The run has no such quantity, or the limits are no range.
    """
    known = ["body", "speed", *sorted({scalar for cloud in animation.clouds for scalar in cloud.scalars})]
    if name is None:
        choices = ("pressure", "speed") if _has_fluid(animation) else ("von_mises", "pressure", "speed")
        name = next(word for word in choices if word in known)
    if name not in known:
        raise InputError("--colour", "", f"is {name}, which is not in {animation.path}: it has {', '.join(known)}")
    if limits is not None and not (math.isfinite(limits[1] - limits[0]) and limits[0] < limits[1]):
        raise InputError("--limits", "", f"is {limits[0]:g} {limits[1]:g}, must be two numbers, the smaller one first")
    if name == "body":
        return Colouring(name)
    clouds = [number for number in range(len(animation.clouds)) if has_colour(animation, number, name)]
    found = [values(animation, cloud, frame, name) for frame in animation.sample_frames() for cloud in clouds]
    everything = np.concatenate([*found, np.zeros(0)])
    everything = everything[np.isfinite(everything)] if np.isfinite(everything).any() else np.zeros(1)
    low, high = limits or robust_range(everything)
    return Colouring(
        name, low, high, bool(everything.min() < low), bool(everything.max() > high), owner_of(animation, name)
    )


def choose_colourings(
    animation: Animation, name: str | None = None, limits: tuple[float, float] | None = None
) -> Colourings:
    """Quantities that give the colours, fluids first: in runs of fluids and bodies also one of the other side.

    A quantity of the bodies is shown with the pressure of the fluid, and the pressure of the fluid with the von Mises
    stress of the bodies if the run has it. Arguments and errors are those of :func:`choose_colouring`;
    the limits belong to the chosen quantity.
    """
    chosen = choose_colouring(animation, name, limits)
    if chosen.of == "bodies":
        return choose_colouring(animation, "pressure"), chosen
    stressed = any(cloud.role == "body" and "von_mises" in cloud.scalars for cloud in animation.clouds)
    return (chosen, choose_colouring(animation, "von_mises")) if chosen.of == "fluid" and stressed else (chosen,)


def owner_of(animation: Animation, name: str) -> str:
    """Owner of a quantity in a run of fluids and bodies: ``fluid``, ``bodies``, or empty for both.

    The pressure is that of the fluid, for in bodies it is another thing, and often of another size.
    """
    if {"fluid", "body"} - {cloud.role for cloud in animation.clouds} or name in ("body", "speed"):
        return ""
    return "fluid" if name == "pressure" else "bodies"


def has_colour(animation: Animation, cloud: int, name: str) -> bool:
    """Whether the particles of a cloud are coloured by a quantity.

    Walls are the background, and stay grey.
    """
    item = animation.clouds[cloud]
    others = {"fluid": "body", "bodies": "fluid"}
    if item.role in ("wall", others.get(owner_of(animation, name))):
        return False
    return name == "speed" or name in item.scalars


def _has_fluid(animation: Animation) -> bool:
    return any(cloud.role == "fluid" for cloud in animation.clouds)


def values(animation: Animation, cloud: int, frame: int, name: str) -> np.ndarray:
    """Values of a quantity or of the speed [SI units], shape [n]."""
    if name == "speed":
        return np.linalg.norm(animation.velocities(cloud, frame), axis=1) * animation.meters_per_unit
    return animation.scalar(cloud, frame, name)


def robust_range(found: np.ndarray) -> tuple[float, float]:
    """Round numbers around nearly all values: from zero on, or as far below it as above if there are both signs."""
    low, high = (float(value) for value in np.percentile(found, [BEYOND, 100.0 - BEYOND]))
    size = max(abs(low), abs(high))
    if size == 0.0:
        return 0.0, 1.0
    if min(-low, high) > 0.08 * size:
        size = _round_up(size)
        return -size, size
    if high - low < 0.2 * size:
        # hardly any change: shown as what it is, not stretched over all colours
        low, high = (0.0, size) if high > 0.0 else (-size, 0.0)
    elif high > -low:
        low = 0.0
    else:
        high = 0.0
    return 0.0 - _round_up(-low), _round_up(high)


def _round_up(value: float) -> float:
    """The next of 1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8 times a power of ten."""
    if value <= 0.0:
        return 0.0
    power = 10.0 ** math.floor(math.log10(value))
    steps = (1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
    return next(step for step in steps if step * power >= value * (1.0 - 1e-9)) * power
