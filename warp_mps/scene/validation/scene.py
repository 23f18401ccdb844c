"""Constraints on a scene: numbers in range, unique names, references to existing items.

Every check raises `InputError` with the place, the field and the constraint. What needs the particles (overlaps, a
support that holds nothing, a probe outside every body) is checked where they are known.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from warp_mps.scene.choices import PLANES
from warp_mps.scene.motions import HarmonicMotion, HarmonicRotation, TableMotion, TableRotation
from warp_mps.scene.spline import table_values
from warp_mps.scene.validation.body_forces import check_body_forces
from warp_mps.scene.validation.coupling import check_coupling
from warp_mps.scene.validation.fluids import check_fluids, check_velocity_field
from warp_mps.scene.validation.implicit import check_implicit
from warp_mps.scene.validation.meshes import check_regions
from warp_mps.scene.validation.probes import check_measurement, check_probe, names_of_bodies
from warp_mps.scene.validation.rules import choice, place, require, vector

if TYPE_CHECKING:
    from warp_mps.scene import Body, Fluid, Load, Material, Scene, Support, Wall

__all__ = ["check_scene", "place"]


def check_scene(scene: Scene) -> None:
    """Check everything about a scene that can be known without its particles, and not of its records alone.

    Raises:
        InputError: The first thing found that is not allowed.
    """
    _scene_fields(scene)
    _frame(scene)
    require(bool(scene.bodies or scene.fluids), scene.path, "bodies", "is empty: a scene needs a body or a fluid")
    _unique(scene)
    for body in scene.bodies:
        _body(scene, body)
    for wall in scene.walls:
        _wall(scene, wall)
    for fluid in scene.fluids:
        _filled(fluid, place(fluid, "fluid"))
        _start(scene, fluid, place(fluid, "fluid"))
    check_fluids(scene)
    check_coupling(scene)
    check_implicit(scene)
    check_regions(scene)
    for support in scene.supports:
        _support(scene, support)
    for load in scene.loads:
        _load(scene, load)
    check_body_forces(scene)
    for probe in scene.probes:
        check_probe(scene, probe)
    for measurement in scene.measurements:
        check_measurement(scene, measurement)


def _scene_fields(scene: Scene) -> None:
    where = scene.path
    require(len({*scene.outputs}) == len(scene.outputs), where, "outputs", "names a quantity twice")
    if scene.sample_rate is not None:
        ratio = scene.sample_rate / scene.frame_rate
        good = ratio > 0.5 and abs(ratio - round(ratio)) < 1e-6 * ratio
        reason = f"is {scene.sample_rate:g}, must be a whole multiple of the frame rate, {scene.frame_rate:g}"
        require(good, where, "sample_rate", reason)
    if len(scene.gravity):
        vector(scene.gravity, scene.dimension, where, "gravity")


def _frame(scene: Scene) -> None:
    frame = scene.frame
    choice(frame.axes, ("xyz",) if scene.dimension == 3 else PLANES, scene.path, "stage.axes")
    choice(frame.up_axis, ("Y", "Z"), scene.path, "stage.up_axis")


def _unique(scene: Scene) -> None:
    groups: dict[str, Sequence[Any]] = {
        "body": scene.bodies,
        "part": [part for body in scene.bodies for part in body.parts],
        "wall": scene.walls,
        "fluid": scene.fluids,
        "support": scene.supports,
        "load": scene.loads,
        "body force": scene.body_forces,
        "probe": scene.probes,
        "measurement": scene.measurements,
    }
    for kind, items in groups.items():
        seen: set[str] = set()
        for item in items:
            require(item.name not in seen, place(item, kind), "name", f"{item.name!r} is used twice")
            seen.add(item.name)
    kinds: dict[str, str] = {}
    for kind in ("body", "wall", "fluid"):
        for item in groups[kind]:
            other = kinds.setdefault(item.name, kind)
            require(other == kind, place(item, kind), "name", f"{item.name!r} is also that of a {other}")


def _body(scene: Scene, body: Body) -> None:
    where = place(body, "body")
    _filled(body, where)
    _material(body.material, scene, where)
    for part in body.parts:
        _material(part.material, scene, place(part, "part"))
    _start(scene, body, where)
    names_of_bodies(body.bonded_to, scene, where, "bonded_to")


def _start(scene: Scene, item: Body | Fluid, where: str) -> None:
    """The initial velocity of a body or a fluid."""
    if item.velocity is not None:
        vector(item.velocity, scene.dimension, where, "velocity")
    if item.angular_velocity is not None:
        vector(np.atleast_1d(item.angular_velocity), 1 if scene.dimension == 2 else 3, where, "angular_velocity")
    if item.velocity_field is not None:
        check_velocity_field(item.velocity_field, scene, where)


def _filled(item: Body | Wall | Fluid, where: str) -> None:
    """Checks that bodies, walls and fluids share."""
    require(all(axis in (0, 1, 2) for axis in item.node_axes), where, "node_axes", "must be axes among x, y and z")


def _wall(scene: Scene, wall: Wall) -> None:
    where = place(wall, "wall")
    _filled(wall, where)
    _motion(wall.motion, scene, where)
    _rotation(wall.rotation, scene, where)


def _material(material: Material, scene: Scene, body: str) -> None:
    own = material.path != "material"
    where, prefix = (material.path, "") if own else (body, "material.")
    good = material.retardation_time == 0.0 or scene.elasticity.model != "springs"
    reason = "is for the hamiltonian model: springs takes the scene's damping only"
    require(good, where, f"{prefix}retardation_time", reason)
    linear = material.law == "st_venant_kirchhoff"
    good = linear or scene.elasticity.model != "springs"
    reason = f"is {material.law!r}, which the springs model does not have; use hamiltonian"
    require(good, where, f"{prefix}law", reason)
    plane_stress = scene.dimension == 2 and scene.plane == "stress" and linear
    upper = 1.0 if plane_stress else 0.5
    good = -1.0 < material.poissons_ratio < upper
    kind = "plane stress" if plane_stress else "plane strain" if scene.dimension == 2 else "3-D"
    reason = f"is {material.poissons_ratio:g}, must lie between -1 and {upper:g} (both excluded) in {kind}"
    require(good, where, f"{prefix}poissons_ratio", reason)


def _support(scene: Scene, support: Support) -> None:
    where = place(support, "support")
    good = all(axis in range(scene.dimension) for axis in support.axes) and len({*support.axes}) == len(support.axes)
    require(good, where, "axes", f"must be different axes of the scene's {scene.dimension} dimensions")
    names_of_bodies(support.bodies, scene, where, "bodies")
    _motion(support.motion, scene, where)


def _motion(motion: HarmonicMotion | TableMotion | None, scene: Scene, where: str) -> None:
    if isinstance(motion, HarmonicMotion):
        vector(motion.amplitude, scene.dimension, where, "motion.amplitude")
    elif isinstance(motion, TableMotion):
        rows = np.asarray(motion.displacements, float)
        _table(motion.times, rows, (scene.dimension,), motion.interpolation, where, ("motion", "displacements"))


def _rotation(rotation: HarmonicRotation | TableRotation | None, scene: Scene, where: str) -> None:
    if rotation is None:
        return
    vector(rotation.pivot, scene.dimension, where, "rotation.pivot")
    if scene.dimension == 3:
        vector(rotation.axis, 3, where, "rotation.axis")
        require(np.linalg.norm(rotation.axis) > 0.0, where, "rotation.axis", "has no length")
    if isinstance(rotation, TableRotation):
        rows = np.asarray(rotation.angles, float)
        _table(rotation.times, rows, (), rotation.interpolation, where, ("rotation", "angles"))


def _table(
    instants: np.ndarray, rows: np.ndarray, shape: tuple[int, ...], kind: str, where: str, names: tuple[str, str]
) -> None:
    """Check a table whose rows have a shape; `names` are those of the motion and of its rows."""
    times, at, of_rows = np.asarray(instants, float), f"{names[0]}.times", f"{names[0]}.{names[1]}"
    require(times.ndim == 1 and len(times) >= 2, where, at, "must hold at least two times")
    good = np.isfinite(times) & (times > np.roll(times, 1))
    good[0] = np.isfinite(times[0])
    worst = int(np.argmin(good))
    reason = f"has {times[worst]:g} s after {times[max(worst - 1, 0)]:g} s, must be finite and increase"
    require(bool(good.all()), where, at, reason)
    reason = (
        f"has shape {rows.shape}, must have one {'vector' if shape else 'number'} for each of the {len(times)} times"
    )
    require(rows.shape == (len(times), *shape), where, of_rows, reason)
    require(bool(np.all(np.isfinite(rows))), where, of_rows, "must be finite")
    start = table_values(times, rows.reshape(len(times), -1), kind, 0.0)
    require(not np.any(start), where, of_rows, "must be 0 at t = 0")


def _load(scene: Scene, load: Load) -> None:
    where = place(load, "load")
    given = load.force is not None or load.acceleration is not None
    require(given, where, "force", "neither a force nor an acceleration is given")
    for name in ("force", "acceleration"):
        if getattr(load, name) is not None:
            vector(getattr(load, name), scene.dimension, where, name)
    names_of_bodies(load.bodies, scene, where, "bodies")
