"""Constraints on the fluids of a scene, and remarks on doubtful ones.

A velocity field is of bodies as well as of fluids; its check is here, beside the flows that most of its kinds are.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from warp_mps.scene.choices import (
    FLUID_QUANTITIES,
    MODAL_FIELDS,
    PROBE_QUANTITIES,
    VELOCITY_FIELD_PARTS,
    WALL_QUANTITIES,
)
from warp_mps.scene.numerics import SKIN, Flow
from warp_mps.scene.validation.coupling import remarks_on_bodies
from warp_mps.scene.validation.rules import SAME, named, place, require, vector
from warp_mps.shapes import Box

if TYPE_CHECKING:
    from warp_mps.scene import Fluid, Probe, Scene, VelocityField, Wall

# two directions are at right angles when the cosine between them is no larger
RIGHT_ANGLE = 1e-6
# how much longer than asked for a run may take without a remark
LONGER = 1.05
# root-mean-square speed of water that should rest, in the schemes that stir it, in sqrt(g l0): 0.1 to 0.29 was found
# in tanks of 10 and 20 rows, and 0.04 at most with equal and opposite forces
STIRRED = 0.2


def check_fluids(scene: Scene) -> None:
    """Check the fluids of a scene and how they are computed.

    Raises:
        InputError: Something is not allowed.
    """
    _flow(scene)
    if not scene.fluids:
        return
    _alike(scene)
    _no_bodies(scene)


def remarks(scene: Scene) -> list[str]:
    """Remarks, a line each, on parts that most scenes of fluids have and this one lacks."""
    if not scene.fluids:
        return []
    lines = [] if scene.walls else ["no walls: nothing holds the fluid"]
    if not any(scene.gravity) and not scene.body_forces:
        lines.append("no gravity: the fluid has no weight")
    lines += _stirring(scene)
    interval = 1.0 / (scene.sample_rate or scene.frame_rate)
    end = interval * math.ceil(scene.duration / interval - 1e-6)
    if end > LONGER * scene.duration:
        lines.append(f"ends at {end:g} s: a run of fluids takes whole intervals between two rows, of {interval:g} s")
    lines += [line for wall in scene.walls for line in _thin(wall, scene)]
    return [*lines, *remarks_on_bodies(scene)]


def _stirring(scene: Scene) -> list[str]:
    """A line about a scheme whose forces are not equal and opposite, in which water between walls does not rest."""
    usual = Flow().scheme
    if not scene.walls or not any(scene.gravity) or scene.flow.scheme == usual:
        return []
    speed = STIRRED * math.sqrt(math.hypot(*scene.gravity) * scene.fluids[0].spacing)
    effect = f"does not conserve momentum: water at rest below a free surface comes to move at some {speed:.2g} m/s"
    return [f"scheme '{scene.flow.scheme}' {effect}, and a run that gains energy in that way ends; take '{usual}'"]


def _thin(wall: Wall, scene: Scene) -> list[str]:
    """A line about a wall that keeps the pressures on its two sides apart only in part.

    Water sees water up to the effective radius away, and a wall of k rows of particles keeps it k + 1 spacings apart.
    """
    if not isinstance(wall.shape, Box):
        return []
    least = math.ceil(scene.flow.radius(scene.dimension)) - 1
    rows = max(1, round(min(wall.shape.size[: scene.dimension]) / wall.spacing))
    if rows >= least:
        return []
    effect = f"in impacts, water on one side interacts with that on the other; {least} separate them"
    reason = f"is {rows} particles thick: {effect}"
    return [f"{place(wall, 'wall')}: {reason}"]


def probe_quantities(probe: Probe, scene: Scene) -> tuple[str, ...]:
    """Quantities that a probe can record at its place."""
    if probe.body in [wall.name for wall in scene.walls]:
        return WALL_QUANTITIES
    if probe.body in [fluid.name for fluid in scene.fluids]:
        return FLUID_QUANTITIES["body"]
    if probe.body is not None or probe.support is not None or not scene.fluids:
        return PROBE_QUANTITIES[probe.where]
    fluid = FLUID_QUANTITIES[probe.where]
    return tuple(dict.fromkeys((*fluid, *PROBE_QUANTITIES[probe.where]))) if scene.bodies else fluid


def is_in_fluid(probe: Probe, scene: Scene) -> bool:
    """Whether a probe at a point or a region looks at the fluid there, or at the material of a body.

    Where a scene has both, what both have is the fluid's.
    """
    placed = probe.point is not None or probe.region is not None
    return bool(scene.fluids) and placed and (not scene.bodies or probe.quantity in FLUID_QUANTITIES[probe.where])


def check_probed_fluid(probe: Probe, scene: Scene, where: str) -> None:
    """Check what only probes in fluids have.

    Raises:
        InputError: Something is not allowed.
    """
    if probe.quantity == "elevation":
        require(any(scene.gravity), where, "quantity", "is 'elevation', which requires gravity")
    if probe.moves_with is None:
        return
    good = is_in_fluid(probe, scene) and probe.point is not None
    require(good, where, "moves_with", "is for a point in a scene of fluids")
    known = [wall.name for wall in scene.walls]
    named(probe.moves_with, known, where, "moves_with", "wall")


def check_velocity_field(field: VelocityField, scene: Scene, where: str) -> None:
    """Check that a velocity field has what its kind needs, and nothing else.

    Raises:
        InputError: It does not.
    """
    flat = scene.dimension == 2
    require(not (flat and field.kind == "twist"), where, "velocity_field.kind", "is 'twist', which needs a 3-D scene")
    needed = VELOCITY_FIELD_PARTS[field.kind]
    for name in ("amplitude", "rate", "length", "depth"):
        given, at = getattr(field, name) is not None, f"velocity_field.{name}"
        if name in needed:
            require(given, where, at, f"is missing: the velocity field {field.kind!r} needs it")
        own = ", ".join(part for part in needed if part not in ("axis", "origin"))
        require(
            not given or name in needed, where, at, f"is not used by the velocity field {field.kind!r}; it takes {own}"
        )
    for name in ("axis", "origin", *(["amplitude"] if "amplitude" in needed else [])):
        vector(getattr(field, name), scene.dimension, where, f"velocity_field.{name}")
    require(np.linalg.norm(field.axis) > 0.0, where, "velocity_field.axis", "has no length")
    _pattern(field, where)


def _pattern(field: VelocityField, where: str) -> None:
    """Modes of bodies count from 1; the flows have none, and those with an amplitude have it across the axis."""
    if field.kind in MODAL_FIELDS:
        return
    require(field.mode == 1, where, "velocity_field.mode", f"is not used by the velocity field {field.kind!r}")
    if field.amplitude is not None:
        amplitude, axis = np.asarray(field.amplitude, float), np.asarray(field.axis, float)
        product = float(np.linalg.norm(amplitude) * np.linalg.norm(axis))
        require(product > 0.0, where, "velocity_field.amplitude", "has no length")
        good = abs(float(amplitude @ axis)) <= RIGHT_ANGLE * product
        require(good, where, "velocity_field.amplitude", "must be at right angles to the axis")


def _flow(scene: Scene) -> None:
    flow, where = scene.flow, scene.path
    if flow.domain is not None:
        for corner, name in zip(flow.domain, ("low", "high"), strict=True):
            vector(corner, scene.dimension, where, f"flow.domain.{name}")
        good = bool(np.all(np.less(*flow.domain)))
        require(good, where, "flow.domain.high", "must be above the lowest corner along every axis")
    if flow.periodic:
        _periodic(scene)


def _periodic(scene: Scene) -> None:
    flow, where = scene.flow, scene.path
    good = all(axis in range(scene.dimension) for axis in flow.periodic) and len({*flow.periodic}) == len(flow.periodic)
    require(good, where, "flow.periodic", f"must be different axes of the scene's {scene.dimension} dimensions")
    require(not scene.bodies, where, "flow.periodic", "must be empty in a scene with elastic bodies")
    if flow.domain is None:
        require(False, where, "flow.periodic", "needs a domain: give its lowest and highest corner")
        return
    lengths = np.subtract(flow.domain[1], flow.domain[0])[list(flow.periodic)]
    for fluid in scene.fluids[:1]:
        # a particle must not see another one twice
        least = 3.0 * (flow.radius(scene.dimension) + SKIN) * fluid.spacing
        reason = f"makes a period of {lengths.min():.4g} m, must be at least {least:.4g} m"
        require(bool(np.all(lengths >= (1.0 - SAME) * least)), where, "flow.domain.high", reason)


def _alike(scene: Scene) -> None:
    """One liquid and one spacing for all fluids, and for the walls beside them."""
    first = scene.fluids[0]
    one = place(first, "fluid")
    for fluid in scene.fluids[1:]:
        other = place(fluid, "fluid")
        reason = f"is {fluid.spacing:g} m and that of {one} {first.spacing:g} m; all fluids must have the same"
        require(_same_spacing(fluid.spacing, first), other, "spacing", reason)
        for name, unit in (("density", "kg/m^3"), ("viscosity", "m^2/s")):
            own, that = getattr(fluid.liquid, name), getattr(first.liquid, name)
            reason = f"is {own:g} {unit} and that of {one} {that:g} {unit}; all fluids must be of one liquid"
            require(own == that, other, name, reason)
    for wall in scene.walls:
        reason = f"is {wall.spacing:g} m, must be that of {one}, {first.spacing:g} m"
        require(_same_spacing(wall.spacing, first), place(wall, "wall"), "spacing", reason)


def _same_spacing(spacing: float, fluid: Fluid) -> bool:
    return abs(spacing - fluid.spacing) <= SAME * fluid.spacing


def _no_bodies(scene: Scene) -> None:
    """Refuse settings of elastic bodies in a scene without them."""
    if scene.bodies:
        return
    for kind, items in (("support", scene.supports), ("load", scene.loads)):
        for item in items:
            require(False, place(item, kind), "region", f"a {kind} requires an elastic body")
    require(scene.damping == 0.0, scene.path, "damping", "requires an elastic body")
    require(not scene.outputs, scene.path, "outputs", "require an elastic body")
