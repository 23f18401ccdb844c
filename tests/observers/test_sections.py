"""Forces and moments that are carried through a cut, against beam theory and against each other."""

from __future__ import annotations

import numpy as np
import pytest

from tests.scenes import HAMILTONIAN, LENGTH, SPRINGS, THICKNESS, beam, block, random, scene_of
from warp_mps.errors import InputError
from warp_mps.observers.sampling import make_sampler
from warp_mps.run.simulation import Simulation
from warp_mps.scene import Elasticity, Load, Probe, Support
from warp_mps.shapes import Box

FORCE, PULL, CUT = 0.05, 20.0, 0.08


def sample(simulation: Simulation, **probe: object) -> np.ndarray:
    sampler = make_sampler(Probe(name="p", **probe), simulation.scene, simulation.particles)  # type: ignore[arg-type]
    return sampler.sample(simulation)


@pytest.fixture(scope="module", params=[HAMILTONIAN, SPRINGS], ids=["hamiltonian", "springs"])
def cantilever(request: pytest.FixtureRequest) -> Simulation:
    """Clamped over 2 cm at the left, pulled and bent by forces on its last column, damped until it rests."""
    high = 2.0 * THICKNESS
    clamp = Support(name="clamp", region=Box(size=(0.04, high), center=(0.0, 0.0)))
    tip = Box(size=(0.0025, high), center=(LENGTH - 0.0025, 0.0))
    loads = (
        Load(name="bend", region=tip, force=(0.0, -FORCE)),
        Load(name="pull", region=tip, force=(PULL, 0.0)),
    )
    scene = beam(4, supports=(clamp,), loads=loads, damping=200.0, elasticity=request.param)
    simulation = Simulation(scene)
    simulation.advance(round(0.12 / simulation.dt))
    return simulation


def test_forces_and_moment_of_a_cantilever(cantilever: Simulation) -> None:
    """The whole load goes through every cut, and the moment is the shear force times the distance."""
    free = Box(size=(LENGTH - CUT, 1.0), center=(0.5 * (LENGTH + CUT), 0.0))
    held = Box(size=(CUT, 1.0), center=(0.5 * CUT, 0.0))
    force = sample(cantilever, region=free, quantity="section_force")
    assert force == pytest.approx([-PULL, FORCE], rel=2e-3)
    moment = sample(cantilever, region=free, quantity="section_moment", about=(CUT, 0.0))
    # the axial force has an arm too, as far as the beam is bent
    tip, cut = (sample(cantilever, point=(x, 0.0), quantity="position") for x in (LENGTH - 0.0025, CUT))
    arm = tip - cut
    assert arm[0] == pytest.approx(LENGTH - 0.0025 - CUT, rel=2e-3)
    assert moment == pytest.approx([arm[0] * FORCE + arm[1] * PULL], rel=5e-3)
    # what the free part exerts on the held one is the opposite
    assert sample(cantilever, region=held, quantity="section_force") == pytest.approx(-force, rel=1e-9)
    # the forces of the clamp act at its face, not on the particles behind it
    with pytest.raises(InputError, match=r"region.*act at its face: draw it about the free part"):
        sample(cantilever, region=held, quantity="section_moment", about=(CUT, 0.0))


def test_bending_stress_of_a_cantilever(cantilever: Simulation) -> None:
    """Sigma = N / h + 12 M y / h^3, half a spacing below the faces, where the last particles lie."""
    free = Box(size=(LENGTH - CUT, 1.0), center=(0.5 * (LENGTH + CUT), 0.0))
    (moment,) = sample(cantilever, region=free, quantity="section_moment", about=(CUT, 0.0))
    edge = 0.5 * THICKNESS - 0.0025
    top, bottom = (sample(cantilever, point=(CUT, y), quantity="stress")[0] for y in (edge, -edge))
    accuracy = 0.02 if cantilever.scene.elasticity.model == "hamiltonian" else 0.12
    assert 0.5 * (top + bottom) == pytest.approx(PULL / THICKNESS, rel=accuracy)
    assert 0.5 * abs(top - bottom) == pytest.approx(12 * abs(moment) * edge / THICKNESS**3, rel=accuracy)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("elasticity", [HAMILTONIAN, SPRINGS], ids=["hamiltonian", "springs"])
def test_the_two_sides_of_a_cut_are_in_balance(dimension: int, elasticity: Elasticity) -> None:
    """Large random motion: what one side exerts on the other is undone by the other, force and moment."""
    simulation = Simulation(scene_of(block(dimension), dimension=dimension, elasticity=elasticity))
    arrays = simulation.state_arrays()
    arrays["v"] = 3.0 * random(*arrays["v"].shape)
    simulation.restore(arrays)
    simulation.advance(20)
    sides = [Box(size=[0.02] + [1.0] * (dimension - 1), center=[x] + [0.0] * (dimension - 1)) for x in (-0.01, 0.01)]
    forces = [sample(simulation, region=side, quantity="section_force") for side in sides]
    assert np.linalg.norm(forces[0]) > 1.0
    assert forces[0] == pytest.approx(-forces[1], rel=1e-9)
    about = (0.002, 0.001, 0.001)[:dimension]
    moments = [sample(simulation, region=side, quantity="section_moment", about=about) for side in sides]
    assert np.linalg.norm(moments[0]) > 1e-3
    assert moments[0] == pytest.approx(-moments[1], rel=1e-9)
