"""Bonds between bodies."""

from __future__ import annotations

from collections.abc import Sequence

from warp_mps.scene.bodies import Body


def bonded_bodies(body: Body, bodies: Sequence[Body]) -> list[Body]:
    """The bodies of a scene that a body is bonded to, directly or through others, and itself."""
    found = [body]
    for one in found:  # grows during the loop
        near = [other for other in bodies if other.name in one.bonded_to or one.name in other.bonded_to]
        found += [other for other in near if other.name not in [known.name for known in found]]
    return found
