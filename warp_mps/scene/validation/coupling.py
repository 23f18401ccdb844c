"""Constraints on elastic bodies in fluids, and remarks on doubtful ones."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from warp_mps.scene.validation.rules import SAME, place, require
from warp_mps.shapes import Box

if TYPE_CHECKING:
    from warp_mps.scene import Body, Scene


# density of a body over that of the water from which on the passes of the coupling were found to converge
LEAST_DENSITY = 0.05


def check_coupling(scene: Scene) -> None:
    """Check a scene with elastic bodies and fluids.

    Raises:
        InputError: Something is not allowed.
    """
    if not (scene.bodies and scene.fluids):
        return
    clipped = scene.flow.negative_pressure == "clipped"
    reason = f"is {scene.flow.negative_pressure!r}, must be 'clipped' in a scene with elastic bodies"
    require(clipped, scene.path, "flow.negative_pressure", reason)
    fluid = scene.fluids[0]
    for body in scene.bodies:
        ratio = fluid.spacing / body.spacing
        good = round(ratio) >= 1 and abs(ratio - round(ratio)) <= SAME * ratio
        other = f"{place(fluid, 'fluid')}, {fluid.spacing:g} m"
        reason = f"is {body.spacing:g} m, must be that of {other}, or a whole fraction of it"
        require(good, place(body, "body"), "spacing", reason)


def remarks_on_bodies(scene: Scene) -> list[str]:
    """Remarks on the bodies in the fluids of a scene, a line each."""
    return [
        line for body in scene.bodies for line in (*_light(body, scene), *_thin(body, scene), *_uneven(body, scene))
    ]


def _light(body: Body, scene: Scene) -> list[str]:
    """A line about a body that is too light for the coupling: the water's added mass exceeds its own too far."""
    ratio = body.material.density / scene.fluids[0].liquid.density
    if ratio >= LEAST_DENSITY:
        return []
    reason = f"is {ratio:.2g} times as dense as the water: the forces between them may not converge"
    return [f"{place(body, 'body')}: {reason}; they do from {LEAST_DENSITY:g} on"]


def _thin(body: Body, scene: Scene) -> list[str]:
    """A line about a body of which the water sees fewer rows than it can look through."""
    if not isinstance(body.shape, Box):
        return []
    spacing, thinnest = scene.fluids[0].spacing, float(np.min(body.shape.size[: scene.dimension]))
    rows = max(1, round(thinnest / spacing))
    where = place(body, "body")
    if round(thinnest / body.spacing) <= 1:
        return [f"{where}: is one particle thick: it stretches, but has no stiffness in bending"]
    least = math.ceil(scene.flow.radius(scene.dimension)) - 1
    if rows >= least:
        return []
    thick = f"is {rows} spacing{'s' if rows > 1 else ''} of the water thick"
    return [f"{where}: {thick}: in impacts, water on one side interacts with that on the other; {least} separate them"]


def _uneven(body: Body, scene: Scene) -> list[str]:
    """A remark on a body whose thickness is not a whole number of the water's spacings, so that it repels the water."""
    if not isinstance(body.shape, Box):
        return []
    ratio = round(scene.fluids[0].spacing / body.spacing)
    rows = [
        max(1, round(size / body.spacing)) + (axis in body.node_axes)
        for axis, size in enumerate(body.shape.size[: scene.dimension])
    ]
    if all(count % ratio == 0 for count in rows):
        return []
    shown = " x ".join(f"{count}" for count in rows)
    reason = (
        f"is {shown} particles, should be a multiple of {ratio} along each axis: the water groups so many into one, and"
    )
    return [f"{place(body, 'body')}: {reason} a remainder pushes it at the start"]
