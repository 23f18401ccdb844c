"""Runs on a CUDA device: the numbers of the CPU, graphs with a contact search inside, the same bits twice."""

from __future__ import annotations

import numpy as np
import pytest

from tests.bits import assert_same_bits
from tests.coupling.scenes import WAYS, afloat
from tests.elastic.damping.test_damping import viscous
from tests.elastic.implicit.test_static import cantilever
from tests.elastic.implicit.test_theta_rule import rod
from tests.fluid.test_fluids import splash
from tests.scenes import HAMILTONIAN, SPRINGS, block, scene_of
from warp_mps.run.simulation import Simulation
from warp_mps.scene import Contact, Scene
from warp_mps.shapes import Box

pytestmark = pytest.mark.gpu


@pytest.fixture(autouse=True)
def _cuda() -> None:
    """Skip where there is no CUDA device."""
    import warp as wp

    from warp_mps.core.device import open_device

    open_device("cpu")
    if not wp.is_cuda_available():
        pytest.skip("there is no CUDA device")


def collision(dimension: int, model: str) -> Scene:
    """Two blocks that run into each other."""
    rest = (0.0,) * (dimension - 1)
    size, away = (0.04, 0.03, 0.02)[:dimension], (0.042, *rest)
    left = block(dimension, velocity=(2.0, *rest))
    right = block(dimension, name="right", shape=Box(size, away), velocity=(-2.0, *rest))
    elasticity = SPRINGS if model == "springs" else HAMILTONIAN
    return scene_of(left, right, dimension=dimension, elasticity=elasticity, contact=Contact(between="all"))


@pytest.mark.parametrize("model", ["hamiltonian", "springs"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_the_gpu_computes_what_the_cpu_computes(dimension: int, model: str) -> None:
    runs = [Simulation(collision(dimension, model), device=device) for device in ("cpu", "cuda:0")]
    for simulation in runs:
        simulation.advance(500)
    cpu, gpu = runs
    assert cpu.energy.contact + cpu.energy.elastic > 0.0
    np.testing.assert_allclose(gpu.positions, cpu.positions, rtol=0.0, atol=1e-10)
    assert gpu.energy.total == pytest.approx(cpu.energy.total, rel=1e-9)


@pytest.mark.parametrize("dimension", [2, 3])
def test_damping_and_stresses_are_those_of_the_cpu(dimension: int) -> None:
    scene = viscous(collision(dimension, "hamiltonian"), 1e-5)
    runs = [Simulation(scene, device=device) for device in ("cpu", "cuda:0")]
    for simulation in runs:
        simulation.advance(500)
    cpu, gpu = runs
    assert cpu.energy.dissipated > 0.0
    assert gpu.energy.dissipated == pytest.approx(cpu.energy.dissipated, rel=1e-9)
    for name in ("stresses", "strains", "von_mises", "strain_energy_densities"):
        values = getattr(cpu, name)
        np.testing.assert_allclose(getattr(gpu, name), values, rtol=0.0, atol=1e-8 * np.abs(values).max())


@pytest.mark.parametrize("precision", ["float64", "float32"])
@pytest.mark.parametrize("model", ["hamiltonian", "springs"])
def test_graphs_and_repetition_give_the_same_bits(model: str, precision: str) -> None:
    scene, results = collision(2, model), []
    for graphs in (True, True, False):
        simulation = Simulation(scene, device="cuda:0", precision=precision, graphs=graphs)
        simulation.advance(300)
        results.append(simulation.positions)
    np.testing.assert_array_equal(results[0], results[1])
    np.testing.assert_array_equal(results[0], results[2])


@pytest.mark.parametrize(("dimension", "precision"), [(2, "float64"), (3, "float32")])
def test_water_on_the_gpu(dimension: int, precision: str) -> None:
    """Near the CPU's before the flow turns violent, and the same bits twice, with graphs and without."""
    scene = splash(dimension)
    cpu = Simulation(scene, precision=precision)
    runs = [Simulation(scene, device="cuda:0", precision=precision, graphs=graphs) for graphs in (True, True, False)]
    for simulation in (cpu, *runs):
        simulation.advance(6)
    near = 1e-3 * np.abs(cpu.displacements).max()
    np.testing.assert_allclose(runs[0].positions, cpu.positions, rtol=0.0, atol=near)
    arrays = [simulation.state_arrays() for simulation in runs]
    for other in arrays[1:]:
        assert_same_bits([other], arrays[:1])


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_static_analysis_is_that_of_the_cpu(dimension: int) -> None:
    runs = [Simulation(cantilever(dimension, load_steps=2), device=device) for device in ("cpu", "cuda:0")]
    for simulation in runs:
        simulation.advance(2)
    cpu, gpu = (simulation.displacements for simulation in runs)
    np.testing.assert_allclose(gpu, cpu, rtol=0.0, atol=1e-7 * np.abs(cpu).max())
    assert runs[1].record()["implicit"]["unsolved"] == 0


def test_implicit_steps_are_those_of_the_cpu_and_repeat_to_the_same_bits() -> None:
    scene = rod(gravity=(0.0, -9.81), time_step=5e-4)
    options = [{"device": "cpu"}, {"device": "cuda:0"}, {"device": "cuda:0"}, {"device": "cuda:0", "graphs": False}]
    ends = []
    for option in options:
        simulation = Simulation(scene, **option)  # type: ignore[arg-type]
        simulation.advance(20)
        ends.append(simulation.displacements)
    np.testing.assert_allclose(ends[1], ends[0], rtol=0.0, atol=1e-6 * np.abs(ends[0]).max())
    np.testing.assert_array_equal(ends[2], ends[1])
    np.testing.assert_array_equal(ends[3], ends[1])


@pytest.mark.parametrize(("dimension", "precision"), [(2, "float64"), (3, "float32")])
@pytest.mark.parametrize("way", WAYS)
def test_water_and_bodies_on_the_gpu(way: dict, dimension: int, precision: str) -> None:
    """Near the CPU's, and the same bits twice, with graphs and without, and after a restart."""
    scene = afloat(500.0, dimension=dimension, **way)
    cpu = Simulation(scene, precision=precision)
    runs = [Simulation(scene, device="cuda:0", precision=precision, graphs=graphs) for graphs in (True, True, False)]
    for simulation in (cpu, *runs):
        simulation.advance(4)
    body = slice(cpu.particles.elastic)
    np.testing.assert_allclose(
        runs[0].displacements[body],
        cpu.displacements[body],
        rtol=0.0,
        atol=0.02 * np.abs(cpu.displacements[body]).max(),
    )
    arrays = [simulation.state_arrays() for simulation in runs]
    for other in arrays[1:]:
        assert_same_bits([other], arrays[:1])
    restored = Simulation(scene, device="cuda:0", precision=precision)
    restored.restore(arrays[0])
    for simulation in (restored, runs[1]):
        simulation.advance(2)
    assert_same_bits([restored.state_arrays()], [runs[1].state_arrays()])
    assert runs[0].record()["coupling"]["unconverged"] == 0
