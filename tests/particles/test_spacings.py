"""Bodies of different spacing in one scene: what they are filled with, their collision, probes, frames, time step."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom

from tests.scenes import HAMILTONIAN, SPRINGS, angular_momentum
from warp_mps.results.history import read_history
from warp_mps.run.run import run_scene
from warp_mps.run.schedule import Clock
from warp_mps.run.simulation import Simulation
from warp_mps.scene import Body, Elasticity, Material, Probe, Scene, VelocityField
from warp_mps.shapes import Box

# of one spacing, two and three: name, spacing [m], material, velocity [m/s], how far to the side [m]
BODIES = (
    ("fine", 0.005, Material(1000.0, 1e6, 0.3), 1.5, 0.0),
    ("middle", 0.01, Material(2000.0, 4e6, 0.1), 0.0, 0.01),
    ("coarse", 0.015, Material(700.0, 5e5, 0.45), -1.0, -0.015),
)
SIDE, GAP, DEPTH = 0.06, 0.002, 0.03
CASES = [(2, HAMILTONIAN), (2, SPRINGS), (3, HAMILTONIAN), (3, SPRINGS)]


def three(dimension: int, elasticity: Elasticity, **scene: object) -> Scene:
    """A fine and a coarse block that fly at one of middling spacing between them."""
    size = (SIDE, SIDE, DEPTH)[:dimension]
    rest = (0.0,) * (dimension - 1)
    bodies = tuple(
        Body(
            name=name, shape=Box(size, (k * (SIDE + GAP), aside)), material=material, spacing=spacing,
            velocity=(speed, *rest),
        )
        for k, (name, spacing, material, speed, aside) in enumerate(BODIES, start=-1)
    )  # fmt: skip
    fields = {"bodies": bodies, "dimension": dimension, "duration": 0.02, "elasticity": elasticity, **scene}
    return Scene(**fields)  # type: ignore[arg-type]


@pytest.mark.parametrize("dimension", [2, 3])
def test_each_is_filled_with_its_own_spacing(dimension: int) -> None:
    particles = Simulation(three(dimension, HAMILTONIAN)).particles
    cells = [round(SIDE / s) ** 2 * (round(DEPTH / s) if dimension == 3 else 1) for _, s, *_ in BODIES]
    assert np.bincount(particles.bodies).tolist() == cells
    volume = SIDE**2 * (DEPTH if dimension == 3 else 1.0)
    masses = np.bincount(particles.bodies, particles.masses)
    assert masses == pytest.approx([material.density * volume for _, _, material, *_ in BODIES], rel=1e-12)


@pytest.mark.parametrize(("dimension", "elasticity"), CASES)
def test_a_collision_keeps_momentum_and_energy(dimension: int, elasticity: Elasticity) -> None:
    simulation = Simulation(three(dimension, elasticity))
    particles = simulation.particles
    masses = particles.masses[:, None]

    def momenta() -> np.ndarray:
        return np.array([(masses * simulation.velocities)[particles.bodies == k].sum(axis=0) for k in range(3)])

    before, turning, energy = momenta(), angular_momentum(simulation), simulation.energy.total
    size = np.abs(before).sum()
    compressed = 0.0
    while simulation.time < 0.02:
        simulation.advance(64)
        compressed = max(compressed, simulation.energy.contact / energy)
        assert simulation.energy.total == pytest.approx(energy, rel=1e-3)
    after = momenta()
    np.testing.assert_allclose(after.sum(axis=0), before.sum(axis=0), rtol=0.0, atol=1e-12 * size)
    np.testing.assert_allclose(angular_momentum(simulation), turning, rtol=0.0, atol=1e-12 * size)
    # both were stopped by the one between them, and thrown back; nothing passed through anything
    assert compressed > 1e-3
    assert after[0, 0] < 0.0 < after[2, 0]
    centres = [simulation.positions[particles.bodies == k, 0].mean() for k in range(3)]
    assert np.diff(centres).min() > 0.9 * SIDE
    assert simulation.energy.contact < 1e-6 * energy


@pytest.mark.parametrize("elasticity", [HAMILTONIAN, SPRINGS])
def test_the_smallest_step_counts(elasticity: Elasticity) -> None:
    scene = three(2, elasticity)
    alone = [Clock(replace(scene, bodies=(body,))).dt_limit for body in scene.bodies]
    assert Clock(scene).dt_limit == min(alone)
    assert len({round(limit, 12) for limit in alone}) == 3


@pytest.mark.parametrize("dimension", [2, 3])
def test_probes_and_frames(tmp_path: Path, dimension: int) -> None:
    """A velocity that is linear in space is read exactly from every body; frames have each body's own width."""
    zero = (0.0,) * (dimension - 2)
    scene = three(dimension, HAMILTONIAN)
    # of so long a wave that it is linear to 1e-9
    field = VelocityField(
        kind="sine", amplitude=(0.0, 1.0, *zero), axis=(1.0, 0.0, *zero), origin=(0.0, 0.0, *zero), length=1e4
    )
    bodies = tuple(replace(body, velocity=None, velocity_field=field) for body in scene.bodies)
    places = [(k * (SIDE + GAP) + 0.021, aside - 0.013, *zero) for k, (*_, aside) in enumerate(BODIES, start=-1)]
    probes = tuple(
        Probe(name=name, point=at, quantity="velocity") for (name, *_), at in zip(BODIES, places, strict=True)
    )
    summary = run_scene(
        replace(scene, bodies=bodies, probes=probes, duration=1e-4, frame_rate=2e4), tmp_path, quiet=True
    )
    assert summary.status == "done"
    history = read_history(tmp_path / "probes.csv")
    for (name, *_), at in zip(BODIES, places, strict=True):
        assert history.probe(name, 1)[0] == pytest.approx(np.pi * at[0] / 1e4, rel=1e-6)
    stage = Usd.Stage.Open(str(tmp_path / "run.usdc"))
    points = {prim.GetName(): UsdGeom.Points(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.Points)}
    assert points.keys() == {name for name, *_ in BODIES}
    for name, spacing, *_ in BODIES:
        assert np.allclose(points[name].GetWidthsAttr().Get(), spacing, rtol=1e-6)
