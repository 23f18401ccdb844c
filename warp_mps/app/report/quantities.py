"""The scalar quantities of the frames that can colour particles."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial

import numpy as np

from warp_mps.app.animation_reader import UNITS, Animation
from warp_mps.app.view.colours import NAMES, owner_of, robust_range
from warp_mps.scene.components import TENSORS, tensor_places

Values = Callable[[], np.ndarray]

# numbers from which the usual range is taken
SAMPLES = 200_000
# in runs of both, as its size and its meaning are others than those of the fluid's
IN_BODIES = "pressure in bodies"


@dataclass(frozen=True)
class Range:
    """The values of a quantity in a run.

    Attributes:
        least: The least.
        greatest: The greatest.
        shown: Those that the colours stand for at first; see `warp_mps.app.view.colours.robust_range`.
    """

    least: float
    greatest: float
    shown: tuple[float, float]

    @property
    def signed(self) -> bool:
        """Whether the colours have a middle, at 0."""
        return self.shown[0] < 0.0 < self.shown[1]


def unit_of(name: str) -> str:
    """Unit of a quantity."""
    own = {"speed": "m/s", "displacement": "m"}
    return own.get(name) or UNITS.get(name.partition(" ")[0], "")


def title_of(name: str) -> str:
    """Label of a quantity."""
    return NAMES.get(name, name.replace("_", " "))


def quantities(animation: Animation, cloud: int, frame: int, *, axes: str) -> dict[str, Values]:
    """The quantities that can colour a cloud in a frame, the most used first, each with a function for its values.

    Args:
        animation: The frames.
        cloud: Number of the cloud.
        frame: Number of the frame.
        axes: The stage's axes along which the scene lies, such as ``xz``.
    """
    unit, found = animation.meters_per_unit, animation.quantities(cloud, frame)
    made: dict[str, Values] = {"speed": lambda: unit * _size(animation.velocities(cloud, frame))}
    made |= {
        name: partial(np.asarray, found[name]) for name in ("pressure", "von_mises", "strain_energy") if name in found
    }
    if animation.clouds[cloud].role == "body":
        if "pressure" in made and owner_of(animation, "pressure") == "fluid":
            made[IN_BODIES] = made.pop("pressure")
            found[IN_BODIES] = found.pop("pressure")
        made["displacement"] = lambda: unit * _size(animation.points(cloud, frame) - animation.points(cloud, 0))
    for name in TENSORS:
        if name in found:
            made |= _of_tensor(name, found[name], axes)
    rest = {name: values for name, values in found.items() if name not in made and name not in TENSORS}
    made |= {name: partial(np.asarray, values) for name, values in rest.items() if values.ndim == 1}
    return made | {name: partial(_size, values) for name, values in rest.items() if values.ndim == 2}


def _size(vectors: np.ndarray) -> np.ndarray:
    return np.linalg.norm(vectors, axis=1)


def _of_tensor(name: str, values: np.ndarray, axes: str) -> dict[str, Values]:
    """Principal values, then components, of symmetric tensors [n, 3, 3]; no shear across a plane."""

    @cache
    def principal() -> np.ndarray:
        return np.linalg.eigvalsh(np.nan_to_num(values))

    made: dict[str, Values] = {
        f"{name} greatest principal": lambda: principal()[:, 2],
        f"{name} least principal": lambda: principal()[:, 0],
    }
    for row, column in tensor_places(3):
        names = "xyz"[row] + "xyz"[column]
        if row == column or set(names) <= set(axes):
            made[f"{name} {names}"] = partial(np.asarray, values[:, row, column])
    return made


def range_of(values: np.ndarray) -> Range:
    """The range of a quantity, and the part of it that colours stand for at first."""
    finite = values[np.isfinite(values)]
    if not len(finite):
        return Range(0.0, 0.0, (0.0, 1.0))
    shown = robust_range(finite[:: max(1, len(finite) // SAMPLES)])
    return Range(float(finite.min()), float(finite.max()), shown)
