"""Boxes whose size is no whole number of spacings, and ready-made particles that are not a spacing apart."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from warp_mps.particles.met_faces import Fits
from warp_mps.scene import Body, Fluid, Scene, Wall
from warp_mps.scene.validation.rules import kind_of, place
from warp_mps.shapes import Box, Points, median_distance

# in spacings: offsets that are remarked; and changes of the distance between rows, of walls and of fluids, whose
# volume is kept
OFFSET, STRETCH, STRAIN = 0.01, 0.02, 0.05
# displacement of water at rest beside a wall, in spacings, per relative change of the distance of the wall's rows:
# -0.10 and -0.13 were measured in tanks with rows 1.225 spacings apart, 0.03 and 0.06 with 0.933
SETTLING = 0.5
# median distances between ready-made particles that are not remarked, in spacings
CLOSEST_POINTS, FARTHEST_POINTS = 0.85, 1.15


@dataclass(frozen=True, kw_only=True)
class Misfit:
    """How a box's lattice fits between two of its faces.

    Attributes:
        item: The body, wall or fluid.
        axis: The box's own axis, ``x``, ``y`` or ``z``.
        size: Distance between the faces, in spacings [-].
        count: Number of particles between them.
        step: Distance between these, in spacings [-].
        offsets: How far the particles reach beyond the low and the high face, in spacings; negative where they end
            before it [-].
        met: Whether something lies at these faces; both do for a body.
    """

    item: Body | Wall | Fluid
    axis: str
    size: float
    count: int
    step: float
    offsets: tuple[float, float]
    met: tuple[bool, bool]


def misfits(scene: Scene) -> list[Misfit]:
    """How the lattices of a scene's boxes fit, along the axes along which their sizes are no whole numbers of spacings.

    Raises:
        InputError: A box cannot be filled.
    """
    fits = Fits(scene)
    return [misfit for item in scene.filled if isinstance(item.shape, Box) for misfit in _misfits(item, fits)]


def remarks_on_misfits(scene: Scene) -> list[str]:
    """A line for each box with a face that lies off the drawn one, or whose particles are squeezed or stretched."""
    found: dict[str, list[str]] = {}
    for misfit in misfits(scene):
        text = _remark(misfit)
        if text:
            found.setdefault(place(misfit.item, kind_of(misfit.item)), []).append(text)
    lines = [f"{where}: {'; '.join(texts)}" for where, texts in found.items()]
    return [*lines, *(line for item in scene.filled for line in _of_points(item, scene.dimension))]


def _of_points(item: Body | Wall | Fluid, dimension: int) -> Iterator[str]:
    """A line about ready-made particles that are not about a spacing apart, from which their masses follow."""
    if not isinstance(item.shape, Points) or len(item.shape.positions) < 2:
        return
    median = median_distance(item.shape, item.spacing, dimension) / item.spacing
    if not CLOSEST_POINTS <= median <= FARTHEST_POINTS:
        where, apart = place(item, kind_of(item)), f"{median:.3g} spacings apart (median distance to the nearest one)"
        share = f"{median**-dimension:.2f} times those of a lattice with a spacing of {median * item.spacing:.4g} m"
        yield f"{where}: its points lie {apart}, so that their masses are {share}"


def _misfits(item: Body | Wall | Fluid, fits: Fits) -> Iterator[Misfit]:
    grid, fit = fits.grid(item), fits.of(item)
    extents = np.ptp(grid.intervals, axis=1) / item.spacing
    if np.all(np.abs(extents - np.round(extents)) <= OFFSET):
        return
    met = fit.ends(grid.axes, grid.intervals) if fit else np.ones(grid.intervals.shape, bool)
    for number, line, (low, high), size, on, faces in zip(
        grid.numbers, grid.lines, grid.intervals, extents, grid.nodes, met.tolist(), strict=True
    ):
        step = line.step / item.spacing
        # the particles' faces lie half a spacing beyond the outermost ones, or half a step where water's goes on
        half = 0.0 if on else 0.5 * (step if isinstance(item, Fluid) or not all(faces) else 1.0)
        x = line.coordinates()
        yield Misfit(
            item=item,
            axis="xyz"[number],
            size=float(size),
            count=line.count,
            step=step,
            offsets=(float((low - x[0]) / item.spacing + half), float((x[-1] - high) / item.spacing + half)),
            met=(faces[0], faces[1]),
        )


def _remark(misfit: Misfit) -> str:
    """What is wrong along an axis, as a clause; empty if nothing is."""
    item, axis = misfit.item, misfit.axis
    clauses = []
    # the faces of a fluid that meet nothing are its free surface; those of a wall are dry
    watched = misfit.met if isinstance(item, Wall) else (True, True)
    low, high = (offset if on else 0.0 for offset, on in zip(misfit.offsets, watched, strict=True))
    if abs(low) > OFFSET and abs(low - high) < OFFSET:
        clauses.append(f"both faces lie {_distance(low, item)} of the drawn ones")
    else:
        for end, offset in (("low", low), ("high", high)):
            if abs(offset) > OFFSET:
                clauses.append(f"the face at the {end} end lies {_distance(offset, item)} of the drawn one")
    change = misfit.step - 1.0
    if isinstance(item, Wall) and all(misfit.met) and misfit.count > 1 and abs(change) > STRETCH:
        effect = f"water at rest beside it settles by some {SETTLING * abs(change):.2f} spacings"
        clauses.append(f"its rows are {misfit.step:.3g} spacings apart, and {effect}")
    if isinstance(item, Fluid) and abs(change) > STRAIN:
        clauses.append(f"its particles are {misfit.step:.3g} spacings apart")
    if not clauses:
        return ""
    # the rows of a fluid with a free face keep their distance, which its size along other axes sets
    row = misfit.step if isinstance(item, Fluid) and not all(misfit.met) else 1.0
    whole = sorted({max(1, int(misfit.size / row)), int(misfit.size / row) + 1})
    sizes = " or ".join(f"{number * row * item.spacing:.6g}" for number in whole)
    taken = f"is {misfit.size:.4g} spacings along {axis} and takes {misfit.count}"
    return f"{taken}: {', '.join(clauses)}; {sizes} m would fit"


def _distance(offset: float, item: Body | Wall | Fluid) -> str:
    side = "outside" if offset > 0.0 else "inside"
    return f"{abs(offset):.2f} spacings ({abs(offset) * item.spacing:.3g} m) {side}"
