"""Boxes whose size is no whole number of spacings, and ready-made particles that are not a spacing apart."""

from __future__ import annotations

from collections.abc import Iterator

from warp_mps.particles.lattice_fit import LatticeFit, lattice_fit
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


def remarks_on_misfits(scene: Scene) -> list[str]:
    """A line for each box with a face that lies off the drawn one, or whose particles are squeezed or stretched."""
    fits, lines = Fits(scene), []
    for item in scene.filled:
        fit = lattice_fit(item, fits) if isinstance(item.shape, Box) else None
        texts = list(_of_box(item, fit)) if fit else []
        if texts:
            lines.append(f"{place(item, kind_of(item))}: {'; '.join(texts)}")
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


def _of_box(item: Body | Wall | Fluid, fit: LatticeFit) -> Iterator[str]:
    """A clause for each axis of a box along which something is wrong, if its size is no whole number of spacings."""
    if all(abs(size - round(size)) <= OFFSET for size in fit.sizes):
        return
    for number, axis in enumerate(fit.axes):
        clauses = list(_clauses(item, fit, number))
        if not clauses:
            continue
        size, step = fit.sizes[number], fit.steps[number]
        # the rows of a fluid with a free face keep their distance, which its size along other axes sets
        row = step if isinstance(item, Fluid) and not all(fit.met[number]) else 1.0
        whole = sorted({max(1, int(size / row)), int(size / row) + 1})
        sizes = " or ".join(f"{number * row * item.spacing:.6g}" for number in whole)
        taken = f"is {size:.4g} spacings along {axis} and takes {fit.across[number]}"
        yield f"{taken}: {', '.join(clauses)}; {sizes} m would fit"


def _clauses(item: Body | Wall | Fluid, fit: LatticeFit, number: int) -> Iterator[str]:
    """What is wrong along an axis."""
    axis, step = fit.axes[number], fit.steps[number]
    low, high = (fit.offsets.get(f"{sign}{axis}", 0.0) for sign in "-+")
    if abs(low) > OFFSET and abs(low - high) < OFFSET:
        yield f"both faces lie {_distance(low, item)} of the drawn ones"
    else:
        for end, offset in (("low", low), ("high", high)):
            if abs(offset) > OFFSET:
                yield f"the face at the {end} end lies {_distance(offset, item)} of the drawn one"
    change = step - 1.0
    if isinstance(item, Wall) and all(fit.met[number]) and fit.across[number] > 1 and abs(change) > STRETCH:
        effect = f"water at rest beside it settles by some {SETTLING * abs(change):.2f} spacings"
        yield f"its rows are {step:.3g} spacings apart, and {effect}"
    if isinstance(item, Fluid) and abs(change) > STRAIN:
        yield f"its particles are {step:.3g} spacings apart"


def _distance(offset: float, item: Body | Wall | Fluid) -> str:
    side = "outside" if offset > 0.0 else "inside"
    return f"{abs(offset):.2f} spacings ({abs(offset) * item.spacing:.3g} m) {side}"
