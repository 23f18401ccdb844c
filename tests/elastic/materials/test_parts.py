"""Bodies of several materials: against bonded bodies, bars in series, and cantilevers of layers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse.linalg as sla

from tests.elastic.hamiltonian.linear import linear_hamiltonian
from tests.elastic.springs.linear import linear_system
from tests.scenes import HAMILTONIAN, RUBBER, SPRINGS, STEEL, block, random, scene_of
from warp_mps.particles.filling import fill_scene
from warp_mps.run.schedule import Clock
from warp_mps.run.simulation import Simulation
from warp_mps.scene import Body, Elasticity, Material, Part, Scene, Support
from warp_mps.shapes import Box, Points

LENGTH, THICKNESS = 0.4, 0.02
SOFT, HARD = Material(1000.0, 1e7, 0.3), Material(2000.0, 4e7, 0.3)
MODELS = [HAMILTONIAN, SPRINGS]


def box(dimension: int, cells: int, middle: float) -> Box:
    """A box of some cells along x and 4 or 3 along the others."""
    return Box([0.01 * n for n in (cells, 4, 3)[:dimension]], [middle, 0.0, 0.0][:dimension])


def one_body(dimension: int, elasticity: Elasticity, *, end: Material = STEEL) -> Scene:
    """A block of rubber whose right half is of another material."""
    part = Part(name="end", region=Box((0.04, 0.1, 0.1), (0.02, 0.0)), material=end)
    body = block(dimension, shape=box(dimension, 8, 0.0), parts=(part,))
    return scene_of(body, dimension=dimension, plane="stress", elasticity=elasticity)


def two_bodies(dimension: int, elasticity: Elasticity) -> Scene:
    """The same as two bonded bodies."""
    left = block(dimension, name="left", shape=box(dimension, 4, -0.02), bonded_to=("right",))
    right = block(dimension, name="right", shape=box(dimension, 4, 0.02), material=STEEL)
    return scene_of(left, right, dimension=dimension, plane="stress", elasticity=elasticity)


def shaken(scene: Scene, steps: int) -> tuple[Simulation, np.ndarray]:
    """A run from velocities that depend on the place alone, and the displacements by place."""
    simulation = Simulation(replace(scene, time_step=1e-5))
    x = simulation.particles.positions
    simulation.solid.state.v.assign(0.5 * np.cos(200.0 * x[:, ::-1] + 1.0))
    simulation.advance(steps)
    return simulation, simulation.displacements[np.lexsort(x.round(6).T)]


@pytest.mark.parametrize("elasticity", MODELS)
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_part_is_as_a_bonded_body(dimension: int, elasticity: Elasticity) -> None:
    (one, a), (two, b) = (shaken(make(dimension, elasticity), 200) for make in (one_body, two_bodies))
    assert np.abs(a).max() > 1e-4
    np.testing.assert_allclose(a, b, rtol=0.0, atol=1e-12)
    assert one.energy.total == pytest.approx(two.energy.total, rel=1e-12)


@pytest.mark.parametrize("elasticity", MODELS)
def test_a_part_of_the_same_material_changes_no_bit(elasticity: Elasticity) -> None:
    scene = one_body(2, elasticity, end=RUBBER)
    plain = replace(scene, bodies=(replace(scene.bodies[0], parts=()),))
    np.testing.assert_array_equal(shaken(scene, 100)[1], shaken(plain, 100)[1])


@pytest.mark.parametrize("elasticity", MODELS)
@pytest.mark.parametrize("dimension", [2, 3])
def test_momentum_and_energy_are_kept(dimension: int, elasticity: Elasticity) -> None:
    scene = one_body(dimension, elasticity, end=replace(STEEL, density=200.0))
    # short steps, for noise is in the fastest modes, whose energy swings with the square of the step
    simulation = Simulation(replace(scene, courant=0.025))
    simulation.solid.state.v.assign(0.2 * random(simulation.particles.count, dimension))
    masses = simulation.particles.masses[:, None]
    start, momentum = simulation.energy.total, (masses * simulation.velocities).sum(axis=0)
    simulation.advance(500)
    assert simulation.energy.total == pytest.approx(start, rel=1e-3)
    np.testing.assert_allclose((masses * simulation.velocities).sum(axis=0), momentum, atol=1e-12 * masses.sum())


@pytest.mark.parametrize(("elasticity", "tolerance"), [(HAMILTONIAN, 0.03), (SPRINGS, 0.03)])
@pytest.mark.parametrize("nu", [0.0, 0.3])
def test_two_materials_in_series(nu: float, elasticity: Elasticity, tolerance: float) -> None:
    """A bar that is stretched: 1/E = f1/E1 + f2/E2, more closely the finer it is."""
    errors = []
    for layers in (4, 8):
        spacing = THICKNESS / layers
        # the materials meet midway between two columns of particles
        border = 0.25 * LENGTH + 0.5 * spacing
        part = Part(name="right", region=Box((LENGTH, 1.0), (border + 0.5 * LENGTH, 0.0)), material=STEEL)
        soft, hard = replace(SOFT, poissons_ratio=nu), replace(HARD, poissons_ratio=nu)
        shape = Box((0.5 * LENGTH, THICKNESS), (0.25 * LENGTH, 0.0))
        body = Body(
            name="bar",
            shape=shape,
            material=soft,
            spacing=spacing,
            node_axes=(0,),
            parts=(replace(part, material=hard),),
        )
        scene = scene_of(body, plane="stress", elasticity=elasticity)
        expected = 0.5 * LENGTH / (border / 1e7 + (0.5 * LENGTH - border) / 4e7)
        errors.append(stretched(scene) / expected - 1.0)
    print(f"nu {nu}: {100 * np.array(errors)} %")
    assert np.abs(errors).max() < tolerance
    assert abs(errors[1]) < 0.7 * abs(errors[0])


def stretched(scene: Scene) -> float:
    """Young's modulus of a bar in plane stress whose ends are drawn apart [Pa], from its linear system."""
    particles = fill_scene(scene)
    assemble = linear_hamiltonian if scene.elasticity.model == "hamiltonian" else linear_system
    stiffness = assemble(scene, particles).stiffness
    x = particles.positions
    u = np.zeros((particles.count, stiffness.shape[0] // particles.count))
    held = np.zeros(u.shape, bool)
    left, right = x[:, 0] == x[:, 0].min(), x[:, 0] == x[:, 0].max()
    held[left | right, 0] = True
    held[np.argmin(x @ (1.0, 1e-3)), 1] = True
    u[right, 0] = np.ptp(x[:, 0])
    free, u = ~held.ravel(), u.ravel()
    u[free] = sla.spsolve(stiffness[free][:, free].tocsc(), -(stiffness[free] @ u))
    pull = (stiffness @ u).reshape(particles.count, -1)[right, 0].sum()
    return float(pull / THICKNESS)


# first frequencies of cantilevers of 0.4 x 0.02 m in plane stress, soft below and hard above, and hard, soft and hard
# [rad/s]: quadratic finite elements (scikit-fem 12.0.2), of which 8 and 16 through the thickness differ by 1e-4
TWO_LAYERS, SANDWICH = 13.978, 19.638


def cantilever(material: Material, part: Part, layers: int) -> Scene:
    """A cantilever that goes on for two columns of particles behind the face of its clamp at x = 0."""
    spacing = THICKNESS / layers
    shape = Box.from_corners((-2.0 * spacing, -0.5 * THICKNESS), (LENGTH, 0.5 * THICKNESS))
    body = Body(name="beam", shape=shape, material=material, spacing=spacing, parts=(part,))
    clamp = Support(name="clamp", region=Box((0.1, 1.0), (-0.05, 0.0)))
    return scene_of(body, plane="stress", supports=(clamp,), elasticity=HAMILTONIAN)


@pytest.mark.parametrize(
    ("kind", "layers", "tolerance"),
    [("two layers", 4, 0.007), ("two layers", 8, 0.0015), ("sandwich", 4, 0.017), ("sandwich", 8, 0.006)],
)
def test_cantilevers_of_layers(kind: str, layers: int, tolerance: float) -> None:
    h = THICKNESS
    if kind == "two layers":
        part = Part(name="top", region=Box((2.0, h), (0.0, 0.5 * h)), material=HARD)
        scene, expected = cantilever(SOFT, part, layers), TWO_LAYERS
    else:
        part = Part(name="core", region=Box((2.0, 0.5 * h)), material=SOFT)
        scene, expected = cantilever(HARD, part, layers), SANDWICH
    particles = fill_scene(scene)
    held = np.repeat(particles.positions[:, :1] < 0.0, 2, axis=1)
    (found,), _ = linear_hamiltonian(scene, particles, held, face=0.0).modes(1)
    print(f"{kind}, {layers} particles: {100 * (found / expected - 1.0):+.2f} %")
    assert found == pytest.approx(expected, rel=tolerance)
    half = 0.5 * (LENGTH + 2.0 * THICKNESS / layers) * h
    assert particles.masses.sum() == pytest.approx(half * (SOFT.density + HARD.density))


def patterns(dimension: int) -> dict[str, np.ndarray]:
    """Particles of a small lattice that are of the light material."""
    cells = (7, 5)[dimension - 2]
    grid = np.stack(np.meshgrid(*[np.arange(cells)] * dimension, indexing="ij"), -1).reshape(-1, dimension)
    return {
        "lattice": grid,
        "checkerboard": grid.sum(axis=1) % 2 == 0,
        "layer": grid[:, 0] == cells // 2,
        "one": (grid == cells // 2).all(axis=1),
        "scattered": random(len(grid)) < -0.6,
    }


@pytest.mark.parametrize("elasticity", [*MODELS, Elasticity(model="springs", normalization="particle")])
@pytest.mark.parametrize("dimension", [2, 3])
def test_light_particles_among_heavy_ones_limit_the_step(dimension: int, elasticity: Elasticity) -> None:
    assemble = linear_hamiltonian if elasticity.model == "hamiltonian" else linear_system
    found = patterns(dimension)
    lattice = 0.01 * found.pop("lattice")
    for name, light in found.items():
        for nu in (0.0, 0.45):
            scene = light_among_heavy(lattice, light, nu, elasticity)
            clock = Clock(scene)
            stable = 2.0 / assemble(scene, fill_scene(scene)).highest_frequency()
            assert clock.dt < clock.dt_limit < stable, f"{name}, nu {nu}"


def light_among_heavy(lattice: np.ndarray, light: np.ndarray, nu: float, elasticity: Elasticity) -> Scene:
    """A stiff, heavy body with particles that are a thousand times lighter and ten times softer."""
    heavy, thin = Material(1000.0, 1e7, nu), Material(1.0, 1e6, nu)
    cloud, some = (np.column_stack((x, np.zeros((len(x), 3 - x.shape[1])))) for x in (lattice, lattice[light]))
    size = 0.2 * 0.01
    parts = tuple(
        Part(name=f"p{k}", region=Box((size, size, size), tuple(at)), material=thin) for k, at in enumerate(some)
    )
    body = Body(name="body", shape=Points(cloud), material=heavy, spacing=0.01, parts=parts)
    return scene_of(body, dimension=lattice.shape[1], elasticity=elasticity)
