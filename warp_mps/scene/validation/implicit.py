"""Constraints on scenes with a static analysis or implicit steps."""

from __future__ import annotations

from typing import TYPE_CHECKING

from warp_mps.scene.bonds import bonded_bodies
from warp_mps.scene.motions import TableMotion
from warp_mps.scene.validation.rules import place, require

if TYPE_CHECKING:
    from warp_mps.scene import Scene


def check_implicit(scene: Scene) -> None:
    """Check how the elastic bodies of a scene are advanced, or their equilibrium is found.

    Raises:
        InputError: Something is not allowed.
    """
    where = scene.path
    if scene.analysis == "static":
        require(not scene.fluids, where, "analysis", "is 'static', which requires a scene without fluids")
        _at_rest(scene)
    if not scene.implicit:
        return
    require(bool(scene.bodies), where, "integrator", "is 'implicit', which requires elastic bodies")
    word, attribute = (scene.analysis, "analysis") if scene.analysis == "static" else (scene.integrator, "integrator")
    model = scene.elasticity.model
    reason = f"is {model!r}, which has no tangent; {word!r} needs hamiltonian"
    require(model == "hamiltonian", where, "elasticity.model", reason)
    if not scene.fluids:  # which have walls of their own
        require(not scene.walls, where, attribute, f"is {word!r}, which cannot be used with walls: use supports")
    require(
        not touches(scene),
        where,
        "contact.between",
        f"is {scene.contact.between!r}, must be 'none': {word!r} cannot be used with contact",
    )
    if scene.analysis == "dynamic":
        _in_steps(scene)


def touches(scene: Scene) -> bool:
    """Whether elastic bodies can touch each other, themselves or walls."""
    several = len(bonded_bodies(scene.bodies[0], scene.bodies)) < len(scene.bodies) or bool(scene.walls)
    return scene.contact.between == "all" or (scene.contact.between == "bodies" and several)


def _at_rest(scene: Scene) -> None:
    """In a static analysis nothing moves, and loads do not depend on time."""
    for body in scene.bodies:
        for name in ("velocity", "angular_velocity", "velocity_field"):
            reason = "is given, but nothing moves in a static analysis"
            require(getattr(body, name) is None, place(body, "body"), name, reason)
    for load in scene.loads:
        reason = f"is {load.frequency:g} Hz, must be 0 in a static analysis"
        require(load.frequency == 0.0, place(load, "load"), "frequency", reason)
    for support in scene.supports:
        good = support.motion is None or isinstance(support.motion, TableMotion)
        reason = "must be a table in a static analysis, which ends where the table does"
        require(good, place(support, "support"), "motion", reason)


def _in_steps(scene: Scene) -> None:
    if not scene.fluids:  # whose steps are those of the bodies
        reason = "is missing: implicit steps need a given time step"
        require(scene.time_step is not None, scene.path, "time_step", reason)
    for body in scene.bodies:
        for material in body.materials:
            own = material.path != "material"
            where, prefix = (material.path, "") if own else (place(body, "body"), "material.")
            reason = "must be 0 with implicit steps, which damp by theta"
            require(material.retardation_time == 0.0, where, f"{prefix}retardation_time", reason)
