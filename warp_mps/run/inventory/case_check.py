"""The check of a case: what it is, what may be wrong with it and what a run would cost, told before anything runs."""

from __future__ import annotations

import dataclasses
import json
from dataclasses import dataclass

from warp_mps.observers.sampling import make_sampler
from warp_mps.particles.filling import fill_scene
from warp_mps.particles.selection import select_held
from warp_mps.results.formatting import finite
from warp_mps.run.cost import Cost, available_memory, estimate, refuse_too_large
from warp_mps.run.inventory.flotation import flotations
from warp_mps.run.inventory.items import ItemCheck, check_items
from warp_mps.run.inventory.text import outline
from warp_mps.run.remarks import remarks_on_case
from warp_mps.run.simulation import require_scene
from warp_mps.scene import Load, Scene, Support
from warp_mps.scene.choices import AnalysisName


@dataclass(frozen=True, kw_only=True)
class CaseCheck:
    """What a case is, and what a run of it would cost.

    Attributes:
        case: Name of the case.
        dimension: 2 or 3.
        analysis: ``dynamic`` or ``static``.
        method: Models and schemes that compute it.
        items: Its bodies, walls and fluids.
        cost: Estimated cost of a run.
        available_memory: Memory that can be taken [bytes].
        remarks: What may be wrong with it, a line each.
    """

    case: str
    dimension: int
    analysis: AnalysisName
    method: str
    items: tuple[ItemCheck, ...]
    cost: Cost
    available_memory: float
    remarks: tuple[str, ...]

    def __str__(self) -> str:
        """The check as ``warp-mps check`` prints it."""
        return outline(self)

    def item(self, name: str) -> ItemCheck:
        """A body, wall or fluid by its name.

        Raises:
            KeyError: There is none of that name.
        """
        found = next((item for item in self.items if item.name == name), None)
        if found is None:
            raise KeyError(f"{name!r} is not one of {', '.join(item.name for item in self.items)}")
        return found

    def to_json(self) -> str:
        """The check as JSON: an object with the attributes above; infinite numbers are null."""
        return json.dumps(finite(dataclasses.asdict(self)), indent=2, allow_nan=False)


def check(scene: Scene) -> CaseCheck:
    """Tell what a scene is and what a run of it would cost; runs nothing.

    Raises:
        InputError: A run would refuse the scene: its bodies, supports, loads, probes or domain do not fit its
            particles, or there is not enough memory.
    """
    require_scene(scene)
    refuse_too_large(scene)
    particles = fill_scene(scene)
    held: list[Support | Load] = [*scene.supports, *scene.loads]
    for item in held:
        select_held(particles, item)
    for probe in scene.probes:
        make_sampler(probe, scene, particles)
    floating = flotations(scene, particles)
    return CaseCheck(
        case=scene.name,
        dimension=scene.dimension,
        analysis=scene.analysis,
        method=_method(scene),
        items=check_items(scene, particles, floating),
        cost=estimate(scene, particles),
        available_memory=available_memory(),
        remarks=tuple(remarks_on_case(scene, particles, floating)),
    )


def _method(scene: Scene) -> str:
    """Dimension, analysis, scheme and model of a scene."""
    kind = "3-D" if scene.dimension == 3 else f"2-D, plane {scene.plane}" if scene.bodies else "2-D"
    parts = [kind, "static" if scene.analysis == "static" else "dynamic"]
    parts += [f"fluid scheme {scene.flow.scheme}"] if scene.fluids else []
    parts += [f"model {scene.elasticity.model}"] if scene.bodies else []
    return ", ".join(parts)
