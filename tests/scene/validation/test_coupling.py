"""Scenes of water and elastic bodies: refusals and their messages, remarks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.coupling.scenes import ALONE, IMPLICIT, SOFT, lump, pool
from tests.fluid.scenes import L0, box, walls_about
from tests.refusals import assert_refused
from warp_mps.observers.sampling import make_sampler
from warp_mps.particles.filling import fill_scene
from warp_mps.run.simulation import Simulation
from warp_mps.scene import Body, Contact, Fluid, Probe, Scene
from warp_mps.scene.validation.fluids import remarks
from warp_mps.shapes import Box, Points

BLOCK = lump([3, 3], [4, 4], path="/World/block")
VISCOUS = replace(SOFT, retardation_time=1e-4, path="/World/soft")


def scene(*bodies: Body, **fields: Any) -> Scene:
    """A block, or other bodies, in a pool."""
    return pool(*(bodies or (BLOCK,)), path="/World", **fields)


def spaced(spacing: float) -> Body:
    return replace(BLOCK, spacing=spacing)


BROKEN: list[tuple[str, str, str, Callable[[], object]]] = [
    ("/World/block", "spacing", "must be that of fluid 'water', ", lambda: scene(spaced(L0 / 1.5))),
    ("/World/block", "spacing", "or a whole fraction of it", lambda: scene(spaced(2.0 * L0))),
    ("/World/block", "spacing", "is 0.0199 m", lambda: scene(spaced(0.0199))),
    (
        "/World",
        "contact.between",
        "must be 'none'",
        lambda: scene(integrator="implicit", contact=Contact(between="all")),
    ),
    (
        "/World",
        "contact.between",
        "must be 'none'",
        lambda: scene(BLOCK, lump([8, 3], [1, 2], name="other"), integrator="implicit"),
    ),
    (
        "/World/soft",
        "retardation_time",
        "must be 0 with implicit steps",
        lambda: scene(lump([3, 3], [3, 3], material=VISCOUS), **IMPLICIT),
    ),
    ("/World", "analysis", "requires a scene without fluids", lambda: scene(analysis="static", contact=ALONE)),
    (
        "/World/probe",
        "quantity",
        "must be one of",
        lambda: scene(probes=(Probe(name="probe", point=(0.1, 0.1), quantity="warmth", path="/World/probe"),)),
    ),
    (
        "/World/probe",
        "moves_with",
        "is for a point in a scene of fluids",
        lambda: scene(
            probes=(Probe(name="probe", point=(0.1, 0.1), moves_with="y_low", path="/World/probe"),),
        ),
    ),
]


@pytest.mark.parametrize(("where", "attribute", "reason", "make"), BROKEN)
def test_scenes_that_cannot_be_run(where: str, attribute: str, reason: str, make: Callable[[], object]) -> None:
    assert_refused(make, where, attribute, reason)


def test_bodies_that_share_space_with_walls() -> None:
    sunk = scene(lump([3, -1], [2, 4], path="/World/post"))
    assert_refused(lambda: fill_scene(sunk), "/World/post", "shape", "bodies may touch but not share space")


def test_threads_are_not_for_water() -> None:
    for fields in ({}, IMPLICIT):
        assert_refused_threads(scene(**fields))


def assert_refused_threads(made: Scene) -> None:
    """A coupled run takes one thread, whichever way its bodies go."""
    with pytest.raises(Exception, match="threads: is 2; fluids take one"):
        Simulation(made, threads=2)


def test_thin_bodies_are_remarked_upon() -> None:
    """One row has no stiffness in bending; few let the water look through; a finer lattice has more rows."""

    def said(thick: float, ratio: int) -> list[str]:
        body = Body(name="plate", shape=Box((4 * L0, thick), (0.1, 0.1)), material=SOFT, spacing=L0 / ratio)
        return [line for line in remarks(pool(body)) if line.startswith("body 'plate'")]

    (alone,) = said(L0, 1)
    assert "is one particle thick: it stretches, but has no stiffness in bending" in alone
    (few,) = said(L0, 2)
    assert "is 1 spacing of the water thick" in few
    assert "3 separate them" in few
    assert len(said(2 * L0, 1)) == 1
    assert said(3 * L0, 1) == []


def test_a_body_that_is_no_whole_number_of_markers_thick() -> None:
    def said(cells: float, ratio: int, **fields: Any) -> list[str]:
        body = Body(name="plate", shape=Box((4 * L0, cells * L0)), material=SOFT, spacing=L0 / ratio, **fields)
        return [line for line in remarks(pool(body)) if "a remainder pushes it" in line]

    (line,) = said(3.5, 2)
    assert "body 'plate': is 8 x 7 particles, should be a multiple of 2 along each axis" in line
    assert said(3.5, 2, node_axes=(1,)) == []
    assert said(4, 2) == said(4, 1) == []
    assert len(said(4, 2, node_axes=(0,))) == 1


def test_water_without_a_free_surface() -> None:
    """Between walls, under a lid: the errors of its volume would go into the body. One row of room is enough."""
    made = scene(cells=(10, 10))
    made = replace(made, fluids=(replace(made.fluids[0], path="/World/water"),))
    full = replace(made, walls=walls_about(np.full(2, 10 * L0), layers=4, lid=True))
    assert_refused(lambda: Simulation(full), "/World/water", "shape", "leaves no free surface")
    roomy = replace(made, walls=walls_about(np.array([10.0, 12.0]) * L0, layers=4, lid=True))
    before = Simulation(roomy).number_densities
    np.testing.assert_array_equal(before, 1.0)


def test_water_that_fills_a_shell() -> None:
    grid = np.stack(np.meshgrid(*(L0 * (np.arange(8) + 0.5),) * 2, indexing="ij"), -1).reshape(-1, 2)
    away = np.abs(grid - 4 * L0).max(axis=1) / L0
    shell = Body(name="shell", shape=Points(grid[away > 1]), material=SOFT, spacing=L0)
    water = Fluid(name="water", shape=Points(grid[away < 1]), spacing=L0, path="/World/water")
    made = Scene(bodies=(shell,), fluids=(water,), duration=0.1)
    assert_refused(lambda: Simulation(made), "/World/water", "shape", "leaves no free surface")


def test_probes_look_at_the_material_by_its_quantities() -> None:
    """At a point of a body; a pressure is the water's, and a displacement needs material there."""
    inside = (4.5 * L0, 4.5 * L0)
    good = [Probe(name=name, point=inside, quantity=name) for name in ("displacement", "pressure", "velocity")]
    good.append(Probe(name="row", region=box(np.full(2, 3 * L0), np.full(2, 5 * L0)), quantity="displacement"))
    good.append(Probe(name="force", body="lump", quantity="contact_force"))
    made = scene(probes=tuple(good), duration=0.02)
    simulation = Simulation(made)
    simulation.advance(1)
    found = {probe.name: make_sampler(probe, made, simulation.particles).sample(simulation) for probe in good}
    p = simulation.particles
    x, u = p.positions[: p.elastic], simulation.displacements[: p.elastic]
    near = u[np.linalg.norm(x - inside, axis=1) < 1.1 * L0]
    assert len(near) == 5
    assert (near.min(axis=0) < found["displacement"]).all()
    assert (near.max(axis=0) > found["displacement"]).all()
    np.testing.assert_allclose(found["row"], u[(x < 5 * L0).all(axis=1)].mean(axis=0), rtol=1e-12)
    assert found["pressure"].shape == (1,)
    np.testing.assert_allclose(found["force"], simulation.contact_forces[: p.elastic].sum(axis=0), rtol=1e-12)
    dry = replace(made, probes=(Probe(name="far", point=(0.01, 0.01), path="/World/far"),))
    assert_refused(lambda: make_sampler(dry.probes[0], dry, p), "/World/far", "point", "")
