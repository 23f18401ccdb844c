"""Bodies that are turned inside out: found, named, and cured by the remedy that is named."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.scenes import block, scene_of
from warp_mps.errors import RunError
from warp_mps.observers.guard import Guard
from warp_mps.run.simulation import Simulation
from warp_mps.scene import Body, Elasticity, Material, Scene, Support, TableMotion
from warp_mps.shapes import Box

PAD = Material(1000.0, 1e6, 0.3)
# the plates hold the outer rows, which lie 0.05 m apart, and press them together by 0.036 m; at the corners of the pad
# the compression is greater, and up to twice as great where nothing is wrong
COMPRESSED, CONCENTRATION = 1.0 - 0.036 / 0.05, 2.0


def pressed(*, law: str = "st_venant_kirchhoff", to: float = 0.4, **scene: object) -> Scene:
    """A pad of 12 x 6 particles that is pressed between two plates to a part of its height within 0.1 s."""
    floor, press = (
        Support(name=name, region=Box((1.0, 0.01), (0.0, y))) for name, y in (("floor", -0.03), ("press", 0.03))
    )
    motion = TableMotion(times=(0.0, 0.1), displacements=((0.0, 0.0), (0.0, -(1.0 - to) * 0.06)))
    pad = block(2, (12, 6), name="pad", material=replace(PAD, law=law))
    fields = {"elasticity": Elasticity(), "plane": "strain", **scene}
    return scene_of(pad, supports=(floor, replace(press, motion=motion)), **fields)


def watched(scene: Scene) -> Simulation:
    """The end of a run that is looked at ten times."""
    simulation = Simulation(scene)
    simulation.run([Guard(every=max(1, simulation.total_steps // 10), time_step=simulation.dt)])
    return simulation


def test_a_crushed_pad_ends_the_run() -> None:
    with pytest.raises(RunError, match=r"at t = 0\.[01]\d* s: particle \d+ of body 'pad' .*J <= 0.*neo_hookean"):
        watched(pressed())


def test_the_remedy_of_a_crushed_pad_works() -> None:
    simulation = watched(pressed(law="neo_hookean"))
    volumes = np.linalg.det(np.eye(2) + simulation.solid.model.gradient.numpy())
    assert COMPRESSED / CONCENTRATION < volumes.min() < COMPRESSED


def test_an_inversion_that_a_later_step_hides_is_found() -> None:
    """One column of particles is drawn past the next and put back before anyone looks."""
    simulation = Simulation(pressed(to=1.0))
    state, x = simulation.solid.state, simulation.particles.positions
    moved = np.zeros_like(x)
    moved[:, 0] = -2.5 * x[:, 0]
    state.u.assign(moved)
    simulation.solid.parts.evaluate_model()
    state.u.zero_()
    simulation.solid.parts.evaluate_model()
    assert "J <= 0" in (simulation.solid.trouble() or "")


@pytest.mark.parametrize("model", ["hamiltonian", "springs"])
def test_a_folded_lattice_is_found_where_no_volume_is_inverted(model: str) -> None:
    """Two neighbours inside change places: every gradient still looks sound."""
    law = "neo_hookean" if model == "hamiltonian" else "st_venant_kirchhoff"
    simulation = Simulation(pressed(law=law, elasticity=Elasticity(model=model)))
    assert simulation.solid.trouble() is None
    state, x = simulation.solid.state, simulation.particles.positions
    one = int(np.argmin(np.hypot(*(x - (0.005, 0.005)).T)))
    other = int(np.argmin(np.hypot(*(x - (0.015, 0.005)).T)))
    u = np.zeros_like(x)
    u[one, 0], u[other, 0] = 0.012, -0.012
    state.u.assign(u)
    simulation.solid.parts.evaluate_model()
    trouble = simulation.solid.trouble() or ""
    assert "folded over a neighbour" in trouble
    assert ("mps:control from 0.5 to 1" if model == "hamiltonian" else "'hamiltonian'") in trouble
    state.u.zero_()
    simulation.solid.parts.evaluate_model()
    assert simulation.solid.trouble() is None


STATIC = {"analysis": "static", "duration": 1.0, "time_step": 0.05}


@pytest.mark.parametrize("choice", [{"integrator": "implicit", "time_step": 1e-3}, STATIC], ids=["implicit", "static"])
def test_inversions_of_implicit_bodies(choice: dict[str, object]) -> None:
    with pytest.raises(RunError, match=r"body 'pad' .*J <= 0.*neo_hookean"):
        watched(pressed(**choice))
    simulation = watched(pressed(law="neo_hookean", **choice))
    volumes = np.linalg.det(np.eye(2) + simulation.solid.model.gradient.numpy())
    assert COMPRESSED / CONCENTRATION < volumes.min() < COMPRESSED


def cantilever(rows: int, *, youngs: float, control: float, duration: float) -> Scene:
    """A clamped soft bar of 4 x 1 m that its weight bends down to nearly its length."""
    shape = Box((4.0, 1.0), (2.0, 0.0))
    material = Material(1050.0, youngs, 0.3, law="neo_hookean")
    bar = Body(name="bar", shape=shape, material=material, spacing=1.0 / rows, node_axes=(0,))
    clamp = Support(name="clamp", region=Box((0.5 / rows, 2.0)))
    return scene_of(
        bar,
        plane="strain",
        supports=(clamp,),
        gravity=(0.0, -9.8),
        duration=duration,
        elasticity=Elasticity(control=control),
    )


@pytest.mark.long
def test_the_remedy_of_a_folded_bar_works() -> None:
    """Of E 6e5, the compressed corner at the clamp folds with the default control, and not with the one named."""
    with pytest.raises(RunError, match=r"body 'bar' .*mps:control from 0\.5 to 1"):
        watched(cantilever(24, youngs=6e5, control=0.5, duration=1.6))
    watched(cantilever(24, youngs=6e5, control=1.0, duration=1.6))


@pytest.mark.long
def test_a_fine_soft_cantilever_keeps_its_order() -> None:
    """With 32 rows and the default settings it swings as finite elements do (16 rows of bilinear ones, 128 columns).

    Their tip is at -1.009, -2.196, -3.091, -3.697, -3.721, -3.614, -3.647, -3.420 and -2.659 m from 0.4 to 2 s.
    """
    simulation = watched(cantilever(32, youngs=1e6, control=0.5, duration=2.0))
    x = simulation.particles.positions
    tip = np.argmin(np.hypot(*(x - (4.0, 0.0)).T))
    # the end column of particles stands on the end of the bar, half of its mass beyond: 4 (1/64)/4 of the deflection
    assert simulation.displacements[tip, 1] == pytest.approx(-2.66, abs=0.08)
