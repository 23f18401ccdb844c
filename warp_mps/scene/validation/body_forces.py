"""Constraints on the body forces of a scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

from warp_mps.scene.validation.rules import named, place, require

if TYPE_CHECKING:
    from warp_mps.scene import Scene


def check_body_forces(scene: Scene) -> None:
    """Check where the body forces of a scene act.

    Raises:
        InputError: Something is not allowed.
    """
    fluids = {fluid.name for fluid in scene.fluids}
    known = [*(body.name for body in scene.bodies), *(fluid.name for fluid in scene.fluids)]
    for force in scene.body_forces:
        where = place(force, "body force")
        for name in force.acts_on:
            named(name, known, where, "acts_on", "body or fluid")
        left_out = sorted(fluids.difference(force.acts_on))
        good = not left_out or len(left_out) == len(fluids) or not fluids
        reason = f"leaves out {', '.join(left_out)}: the fluids are one liquid, name all of them or none"
        require(good, where, "acts_on", reason)
        reason = "is a function of place and time; a static analysis takes loads and gravity only"
        require(scene.analysis != "static", where, "acceleration", reason)
