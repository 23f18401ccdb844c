"""Probes of points, regions, bodies and supports."""

from __future__ import annotations

import numpy as np
import pytest

from tests.observers.views import FakeView, blocks, view_of
from warp_mps.errors import InputError
from warp_mps.observers.sampling import make_sampler
from warp_mps.scene import Probe, StageFrame
from warp_mps.shapes import Box


def moving(dimension: int) -> FakeView:
    """Every field different, so that no quantity can be mistaken for another."""
    view = view_of(blocks(dimension))
    rng = np.random.default_rng(3)
    for name in ("displacements", "velocities", "rotations", "angular_velocities", "contact_forces", "reactions"):
        setattr(view, name, rng.normal(size=getattr(view, name).shape))
    return view


def sample(view: FakeView, **probe: object) -> np.ndarray:
    sampler = make_sampler(Probe(name="p", **probe), view.scene, view.particles)  # type: ignore[arg-type]
    values = sampler.sample(view)
    assert values.shape == (len(sampler.labels),)
    return values


@pytest.mark.parametrize(
    ("dimension", "probe", "labels"),
    [
        (2, {"point": (0.0, 0.0)}, ("p.x [m]", "p.y [m]")),
        (3, {"point": (0.0, 0.0, 0.0), "quantity": "velocity"}, ("p.x [m/s]", "p.y [m/s]", "p.z [m/s]")),
        (2, {"point": (0.0, 0.0), "quantity": "rotation"}, ("p [rad]",)),
        (2, {"support": "wall", "quantity": "reaction"}, ("p.x [N/m]", "p.y [N/m]")),
        (3, {"support": "wall", "quantity": "reaction"}, ("p.x [N]", "p.y [N]", "p.z [N]")),
        (2, {"body": "left", "quantity": "angular_momentum"}, ("p [kg m/s]",)),
        (2, {"body": "left", "quantity": "momentum"}, ("p.x [kg/s]", "p.y [kg/s]")),
    ],
)
def test_labels_name_the_components_and_units(dimension: int, probe: dict, labels: tuple[str, ...]) -> None:
    view = view_of(blocks(dimension))
    assert make_sampler(Probe(name="p", **probe), view.scene, view.particles).labels == labels


def test_a_point_of_a_linear_field() -> None:
    view = view_of(blocks())
    view.displacements = view.particles.positions @ np.array([[0.1, 0.2], [0.3, 0.4]])
    point = np.array([0.12, -0.03])
    expected = point @ np.array([[0.1, 0.2], [0.3, 0.4]])
    assert sample(view, point=(0.12, -0.03)) == pytest.approx(expected, rel=1e-12)
    assert sample(view, point=(0.12, -0.03), quantity="position") == pytest.approx(point + expected, rel=1e-12)


def test_a_region_is_the_mean_of_its_particles() -> None:
    view = moving(2)
    inside = view.particles.positions[:, 1] > 0.1
    region = Box(size=[2.0, 0.1], center=[0.0, 0.15])
    assert sample(view, region=region, quantity="velocity") == pytest.approx(view.velocities[inside].mean(axis=0))
    assert sample(view, region=region, quantity="position") == pytest.approx(view.positions[inside].mean(axis=0))


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_body_moves_as_its_mass_centre(dimension: int) -> None:
    view = moving(dimension)
    right = view.particles.bodies == 1
    assert sample(view, body="right", quantity="position") == pytest.approx(view.positions[right].mean(axis=0))
    assert sample(view, body="right", quantity="velocity") == pytest.approx(view.velocities[right].mean(axis=0))
    momentum = 1000.0 * 0.1**dimension * view.velocities[right].sum(axis=0)
    assert sample(view, body="right", quantity="momentum") == pytest.approx(momentum)
    assert sample(view, body="right", quantity="contact_force") == pytest.approx(view.contact_forces[right].sum(axis=0))
    extent = view.positions[right].max(axis=0) - view.positions[right].min(axis=0) + view.particles.spacings[right][0]
    assert sample(view, body="right", quantity="extent") == pytest.approx(extent)


@pytest.mark.parametrize("dimension", [2, 3])
def test_angular_momentum_of_a_rotating_body_with_spin(dimension: int) -> None:
    view = view_of(blocks(dimension))
    x = view.particles.positions
    view.velocities[:, :2] = 3.0 * np.column_stack([-x[:, 1], x[:, 0]])
    view.angular_velocities[:, -1] = 3.0
    right = view.particles.bodies == 1
    mass = 1000.0 * 0.1**dimension
    # 3 sum m (x^2 + y^2) by hand: x = 0.35 .. 0.65, y = -0.15 .. 0.15, and spin m l0^2/6 a particle
    layers = 4 ** (dimension - 2)
    squares = layers * 4 * sum(v**2 for v in (0.35, 0.45, 0.55, 0.65, 0.15, 0.05, 0.05, 0.15))
    expected = 3.0 * mass * (squares + right.sum() * 0.1**2 / 6.0)
    value = sample(view, body="right", quantity="angular_momentum")
    assert value[-1] == pytest.approx(expected, rel=1e-12)
    assert value[:-1] == pytest.approx(np.zeros(len(value) - 1), abs=1e-12)


def test_a_support_sums_the_reactions_of_its_particles() -> None:
    view = moving(2)
    held = view.particles.positions[:, 0] < -0.1
    assert held.sum() == 4
    assert sample(view, support="wall", quantity="reaction") == pytest.approx(view.reactions[held].sum(axis=0))


def test_a_region_without_particles_is_refused() -> None:
    with pytest.raises(InputError, match=r"^probe 'p' region: holds no particle"):
        sample(view_of(blocks()), region=Box(size=[0.1, 0.1], center=[5.0, 5.0]))


def test_a_point_in_no_body_is_refused() -> None:
    with pytest.raises(InputError, match=r"^probe 'p' point: .* outside every body"):
        sample(view_of(blocks()), point=(5.0, 5.0))


def stressed(dimension: int, **scene: object) -> FakeView:
    view = view_of(blocks(dimension, **scene))  # type: ignore[arg-type]
    rng = np.random.default_rng(5)
    for name in ("stresses", "strains"):
        half = rng.normal(size=getattr(view, name).shape)
        setattr(view, name, half + half.transpose(0, 2, 1))
    for name in ("von_mises", "strain_energy_densities", "displacements", "elastic_forces", "elastic_torques"):
        setattr(view, name, rng.normal(size=getattr(view, name).shape))
    return view


@pytest.mark.parametrize(
    ("dimension", "axes", "labels", "places"),
    [
        (3, "xyz", ("xx", "yy", "zz", "xy", "xz", "yz"), ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))),
        (2, "xy", ("xx", "yy", "zz", "xy"), ((0, 0), (1, 1), (2, 2), (0, 1))),
        # the scene's y is the stage's z, and the normal of the plane is the stage's y
        (2, "xz", ("xx", "zz", "yy", "xz"), ((0, 0), (1, 1), (2, 2), (0, 1))),
    ],
)
def test_tensors_are_named_by_the_axes_of_the_stage(dimension: int, axes: str, labels: tuple, places: tuple) -> None:
    view = stressed(dimension, stage=StageFrame(axes=axes))
    inside = view.particles.positions[:, 1] > 0.1
    region = Box(size=[2.0, 0.1, 2.0][:dimension], center=[0.0, 0.15, 0.0][:dimension])
    for quantity, unit, field in (("stress", "Pa", view.stresses), ("strain", "-", view.strains)):
        probe = Probe(name="p", region=region, quantity=quantity)
        sampler = make_sampler(probe, view.scene, view.particles)
        assert sampler.labels == tuple(f"p.{label} [{unit}]" for label in labels)
        expected = [field[inside][:, row, column].mean() for row, column in places]
        assert sampler.sample(view) == pytest.approx(expected)


def test_scalars_have_one_column() -> None:
    view = stressed(2)
    inside = view.particles.positions[:, 1] > 0.1
    region = Box(size=[2.0, 0.1], center=[0.0, 0.15])
    assert sample(view, region=region, quantity="von_mises") == pytest.approx(view.von_mises[inside].mean())
    found = sample(view, region=region, quantity="strain_energy")
    assert found == pytest.approx(view.strain_energy_densities[inside].mean())
    view.von_mises = 3.0 + 2.0 * view.particles.positions[:, 0]
    assert sample(view, point=(0.12, -0.03), quantity="von_mises") == pytest.approx(3.24)


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_section_is_the_resultant_of_the_elastic_forces_and_their_moment(dimension: int) -> None:
    view = stressed(dimension)
    view.displacements = 0.1 * view.particles.positions[:, ::-1]
    x = view.particles.positions
    inside = (x[:, 0] > 0.5) & (x[:, 1] > 0.0)
    region = Box(size=[1.0, 0.5, 1.0][:dimension], center=[1.0, 0.25, 0.0][:dimension])
    assert inside.sum() == 4 * 4 ** (dimension - 2)
    forces = view.elastic_forces[inside]
    assert sample(view, region=region, quantity="section_force") == pytest.approx(forces.sum(axis=0))
    about = np.array([0.5, 0.1, 0.0][:dimension])
    arms = (x + view.displacements)[inside] - about - 0.1 * about[::-1]
    flat = np.zeros((len(arms), 3)), np.zeros((len(arms), 3))
    flat[0][:, :dimension], flat[1][:, :dimension] = arms, forces
    moment = np.cross(*flat).sum(axis=0)[2 if dimension == 2 else slice(None)]
    expected = moment + view.elastic_torques[inside].sum(axis=0)
    assert sample(view, region=region, quantity="section_moment", about=about) == pytest.approx(expected)


def test_a_moment_about_a_point_in_no_body_is_refused() -> None:
    with pytest.raises(InputError, match=r"^probe 'p' about: .* outside every body"):
        sample(view_of(blocks()), region=Box(size=[1, 1]), quantity="section_moment", about=(5.0, 5.0))
