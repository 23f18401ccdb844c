"""Meshes in a scene: whether they have an inside, and remarks on doubtful ones."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from warp_mps.scene.validation.rules import place, require
from warp_mps.shapes import Mesh, Shape

if TYPE_CHECKING:
    from warp_mps.scene import Load, Part, Probe, Scene, Support


def check_regions(scene: Scene) -> None:
    """Check the meshes of supports, loads, probes and parts; those of bodies, walls and fluids as they are filled.

    Raises:
        InputError: One is not closed, or its shells contradict each other.
    """
    for where, field, shape in _regions(scene):
        for leaf in shape.leaves() if field == "region" else ():
            require(not isinstance(leaf, Mesh) or not leaf.fault, where, field, getattr(leaf, "fault", ""))


def remarks_on_meshes(scene: Scene) -> list[str]:
    """Remarks on meshes: read from a file without a unit, and with shells that add nothing."""
    lines = []
    for where, _, shape in _regions(scene):
        for leaf in shape.leaves():
            if not isinstance(leaf, Mesh) or leaf.fault:
                continue
            if leaf.unscaled_file:
                size = [np.subtract(*leaf.interval(axis)[::-1]) for axis in np.eye(3)]
                lines.append(
                    f"{where}: {leaf.unscaled_file} has no unit and is read in metres, {_by(size)} m; give "
                    f"Mesh.from_file a scale, such as 0.001 for millimetres or 1"
                )
            if len(leaf.idle_shells):
                spot = ", ".join(f"{c:.4g}" for c in leaf.idle_shells[0])
                lines.append(
                    f"{where}: {len(leaf.idle_shells)} of the shells of its mesh, such as that at ({spot}) m, lie in "
                    f"another that is turned alike, and add nothing; turn their faces inward to make cavities of them"
                )
    return lines


def _by(size: list[float]) -> str:
    return " x ".join(f"{length:.4g}" for length in size)


def _regions(scene: Scene) -> Iterator[tuple[str, str, Shape]]:
    """The shapes of a scene, each with the name of its owner in messages and the field that holds it."""
    for item in scene.filled:
        yield place(item, type(item).__name__.lower()), "shape", item.shape
    owners: list[Support | Load | Probe | Part] = [*scene.supports, *scene.loads, *scene.probes]
    owners.extend(part for body in scene.bodies for part in body.parts)
    for owner in owners:
        if owner.region is not None:
            yield place(owner, type(owner).__name__.lower()), "region", owner.region
