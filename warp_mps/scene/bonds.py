"""Bonds between bodies."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from warp_mps.scene.bodies import Body
    from warp_mps.scene.case import Scene


def bonded_bodies(body: Body, scene: Scene) -> list[Body]:
    """The bodies that a body is bonded to, directly or through others, and itself."""
    found = [body]
    for one in found:  # grows during the loop
        near = [other for other in scene.bodies if other.name in one.bonded_to or one.name in other.bonded_to]
        found += [other for other in near if other.name not in [known.name for known in found]]
    return found
