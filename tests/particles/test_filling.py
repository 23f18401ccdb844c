"""Particles of a scene: numbers, masses, order, velocities, groups, refusals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.scenes import RUBBER, STEEL, block, scene_of
from warp_mps.errors import InputError
from warp_mps.particles import overlaps
from warp_mps.particles.filling import count_particles, fill_scene
from warp_mps.particles.particles import Particles
from warp_mps.particles.selection import select, select_held
from warp_mps.scene import Body, Load, Part, Scene, Support, VelocityField, Wall
from warp_mps.shapes import Box, Cylinder, Points, contains

LIGHT = replace(RUBBER, density=10.0)


def two_blocks(dimension: int, shift: float, **right: object) -> Scene:
    """A block of 4 x 3 x 2 particles, and another one shifted along x."""
    other = {
        "name": "right",
        "material": STEEL,
        "shape": Box([0.04, 0.03, 0.02][:dimension], [shift] + [0.0] * (dimension - 1)),
    }
    return scene_of(block(dimension, name="left"), block(dimension, **{**other, **right}), dimension=dimension)


@pytest.mark.parametrize("dimension", [2, 3])
def test_numbers_and_masses_of_boxes(dimension: int) -> None:
    scene = two_blocks(dimension, 0.1)
    particles = fill_scene(scene)
    count = {2: 12, 3: 24}[dimension]
    assert count_particles(scene) == {"left": count, "right": count}
    assert particles.names == ("left", "right")
    assert particles.ranges.tolist() == [[0, count], [count, 2 * count]]
    assert particles.bodies.tolist() == [0] * count + [1] * count
    assert particles.ids.tolist() == list(range(2 * count))
    assert (particles.count, particles.dimension) == (2 * count, dimension)
    volume = 0.04 * 0.03 * (0.02 if dimension == 3 else 1.0)
    masses = [particles.masses[particles.bodies == body].sum() for body in (0, 1)]
    assert masses == pytest.approx([1000 * volume, 3000 * volume], rel=1e-12)


def test_count_is_at_least_what_a_round_shape_takes() -> None:
    scene = scene_of(Body(name="ring", shape=Cylinder(0.05, inner_radius=0.03), material=RUBBER, spacing=0.005))
    assert count_particles(scene)["ring"] >= fill_scene(scene).count
    area = np.pi * (0.05**2 - 0.03**2)
    assert fill_scene(scene).masses.sum() == pytest.approx(1000 * area, rel=0.05)


def test_node_axes_put_particles_on_the_faces() -> None:
    particles = fill_scene(scene_of(block(2, node_axes=(0,))))
    assert particles.count == 5 * 3
    assert np.abs(particles.positions).max(axis=0) == pytest.approx([0.02, 0.01])


@pytest.mark.parametrize("dimension", [2, 3])
def test_particles_take_the_material_of_the_last_part_that_they_lie_in(dimension: int) -> None:
    """2 of 4 columns, then 1 row of 3 over all of them; the other body is not touched."""
    half = Part(name="half", region=Box((0.02, 0.1, 0.1), (0.01, 0.0)), material=STEEL)
    row = Part(name="row", region=Box((0.2, 0.01, 0.1), (0.0, 0.01)), material=LIGHT)
    scene = two_blocks(dimension, 0.1)
    scene = replace(scene, bodies=(replace(scene.bodies[0], parts=(half, row)), scene.bodies[1]))
    assert scene.materials == (RUBBER, STEEL, LIGHT, STEEL)
    particles = fill_scene(scene)
    deep = {2: 1, 3: 2}[dimension]
    assert np.bincount(particles.materials).tolist() == [4 * deep, 4 * deep, 4 * deep, 12 * deep]
    volume = 0.01**dimension
    assert particles.masses.sum() == pytest.approx(4 * deep * volume * (1000 + 3000 + 10 + 3 * 3000), rel=1e-12)
    top = particles.positions[:, 1] > 0.005
    assert (particles.materials[top & (particles.bodies == 0)] == 2).all()


@pytest.mark.parametrize(("first", "second"), [((0.5, 0.0), (0.01, 0.0)), ((0.1, 0.0), (0.0, 0.0))])
def test_a_part_must_hold_a_particle(first: tuple[float, float], second: tuple[float, float]) -> None:
    """One that lies outside, one that lies in another body, and one that a later part covers."""
    parts = [
        Part(name="lost", region=Box((0.02, 0.02), first), material=STEEL, path="/World/lost"),
        Part(name="kept", region=Box((0.02, 0.02), second), material=STEEL),
    ]
    scene = two_blocks(2, 0.1)
    for chosen in (parts, [parts[0], replace(parts[1], region=parts[0].region)]):
        broken = replace(scene, bodies=(replace(scene.bodies[0], parts=tuple(chosen)), scene.bodies[1]))
        with pytest.raises(InputError, match=r"/World/lost region: the part holds no particle of body 'left'"):
            fill_scene(broken)


@pytest.mark.parametrize("dimension", [2, 3])
def test_particles_are_sorted_by_cell(dimension: int) -> None:
    """Cells of 2 effective radii come one after the other, each as one run."""
    cells = (20, 12, 8)[:dimension]
    particles = fill_scene(scene_of(block(dimension, cells), dimension=dimension))
    width = 2 * 1.5 * 0.01
    cell = np.floor((particles.positions - particles.positions.min(axis=0)) / width + 1e-9)
    changes = 1 + np.sum(np.any(np.diff(cell, axis=0) != 0, axis=1))
    assert changes == len(np.unique(cell, axis=0))
    # near in memory: most steps from one to the next are to a neighbour
    steps = np.linalg.norm(np.diff(particles.positions, axis=0), axis=1)
    assert np.median(steps) == pytest.approx(0.01)
    assert np.unique(particles.positions.round(9), axis=0).shape == particles.positions.shape


def test_order_moves_every_quantity_along() -> None:
    positions = np.random.default_rng(1).permutation(np.stack(np.meshgrid(*[np.arange(9.0)] * 2), -1).reshape(-1, 2))
    body = Body(name="a", shape=Points(0.01 * positions, positions), material=RUBBER, spacing=0.01)
    particles = fill_scene(scene_of(body))
    assert not np.array_equal(particles.positions, 0.01 * positions)
    np.testing.assert_allclose(particles.velocities, 100.0 * particles.positions, atol=1e-12)


def test_bonded_bodies_share_a_group_directly_or_through_others() -> None:
    bonds = {"a": (), "e": ("a",), "b": ("c",), "c": (), "d": ("c",)}
    places = {"a": 0.0, "e": 0.04, "b": 1.0, "c": 1.04, "d": 1.08}
    bodies = [
        block(2, name=name, shape=Box((0.04, 0.03), (places[name], 0.0)), bonded_to=bond)
        for name, bond in bonds.items()
    ]
    particles = fill_scene(scene_of(*bodies))
    a, e, b, c, d = (set(particles.groups[particles.bodies == k]) for k in range(5))
    assert a == e
    assert b == c == d
    assert a != b


@pytest.mark.parametrize("name", ["left", "right"])
def test_a_bond_with_a_body_out_of_reach_is_refused(name: str) -> None:
    with pytest.raises(InputError, match=f"body 'right' bonded_to: names '{name}', which it does not touch"):
        fill_scene(two_blocks(2, 0.1, bonded_to=(name,)))


def test_bonded_bodies_of_different_spacing_are_refused() -> None:
    with pytest.raises(InputError, match="body 'right' spacing: differs from that of 'left'"):
        fill_scene(two_blocks(2, 0.1, bonded_to=("left",), spacing=0.005))


@pytest.mark.parametrize("dimension", [2, 3])
def test_bodies_may_touch(dimension: int) -> None:
    particles = fill_scene(two_blocks(dimension, 0.04))
    left, right = (particles.positions[particles.bodies == k] for k in (0, 1))
    gaps = np.linalg.norm(left[:, None] - right[None], axis=-1)
    assert gaps.min() == pytest.approx(0.01)


@pytest.mark.parametrize(("fields", "shift"), [({}, 0.0), ({}, 0.03), ({}, 0.034), ({"spacing": 0.005}, 0.037)])
@pytest.mark.parametrize("dimension", [2, 3])
def test_bodies_that_overlap_are_refused(dimension: int, fields: dict, shift: float) -> None:
    with pytest.raises(InputError, match=r"body '(left|right)' shape: overlaps body '(left|right)' at \("):
        fill_scene(two_blocks(dimension, shift, **fields))


def test_a_body_inside_the_hole_of_another_is_none_of_its_own() -> None:
    ring = Body(name="ring", shape=Cylinder(0.05, inner_radius=0.03), material=RUBBER, spacing=0.005)
    disk = Body(name="disk", shape=Cylinder(0.025), material=RUBBER, spacing=0.005)
    assert fill_scene(scene_of(ring, disk)).count > 100


def test_ready_made_particles_on_top_of_each_other_are_refused() -> None:
    cells = 0.01 * np.stack(np.meshgrid(np.arange(3.0), np.arange(3.0)), axis=-1).reshape(-1, 2)
    bodies = [
        Body(name=name, shape=Points(cells + shift), material=RUBBER, spacing=0.01)
        for name, shift in (("a", 0.0), ("b", (0.002, 0.002)))
    ]
    with pytest.raises(InputError, match="body 'a' shape: overlaps body 'b'"):
        fill_scene(scene_of(*bodies))


@pytest.mark.parametrize("dimension", [2, 3])
def test_velocity_spin_and_field_add_up(dimension: int) -> None:
    """The spin gives omega x r about the centre of mass, which is not the origin."""
    centre = np.array((0.3, 0.1, -0.2)[:dimension])
    spin = (0.0, 0.0, 5.0)
    rest = [0.0] * (dimension - 1)
    field = VelocityField(kind="sine", amplitude=[*rest, 2.0], axis=[1.0, *rest], origin=centre, length=0.04)
    body = block(
        dimension,
        shape=Box([0.04, 0.03, 0.02][:dimension], centre),
        velocity=(1.0, 2.0, 3.0)[:dimension],
        angular_velocity=5.0 if dimension == 2 else spin,
        velocity_field=field,
    )
    particles = fill_scene(scene_of(body, dimension=dimension))
    arms = np.zeros((particles.count, 3))
    arms[:, :dimension] = particles.positions - centre
    expected = np.cross(spin, arms)[:, :dimension] + (1.0, 2.0, 3.0)[:dimension]
    expected[:, -1] += 2.0 * np.sin(np.pi * arms[:, 0] / 0.04)
    np.testing.assert_allclose(particles.velocities, expected, atol=1e-14)
    np.testing.assert_array_equal(
        particles.angular_velocities, np.tile(spin[2:] if dimension == 2 else spin, (particles.count, 1))
    )


def selected(particles: Particles, found: np.ndarray) -> set[tuple[float, ...]]:
    """Positions of particles, rounded."""
    return {tuple(position) for position in particles.positions[found].round(6).tolist()}


def test_a_region_takes_the_particles_on_its_faces() -> None:
    """Particles lie at +-5 and +-15 mm along x, and at -10, 0 and 10 mm along y."""
    particles = fill_scene(scene_of(block(2)))
    found = select(particles, Box((0.01, 0.01), (0.0, 0.005)))
    assert selected(particles, found) == {(-0.005, 0.0), (0.005, 0.0), (-0.005, 0.01), (0.005, 0.01)}
    assert len(select(particles, Box((0.0099, 0.01), (0.0, 0.005)))) == 0


def test_a_region_can_be_kept_to_named_bodies() -> None:
    particles = fill_scene(two_blocks(2, 0.1))
    everything = Box((1.0, 1.0))
    assert len(select(particles, everything)) == 24
    assert set(particles.bodies[select(particles, everything, ("right",))]) == {1}


@pytest.mark.parametrize(
    "item",
    [
        Support(name="grip", region=Box((0.1, 0.1), (5.0, 0.0))),
        Support(name="grip", region=Box((0.1, 0.1)), bodies=("right",)),
        Load(name="grip", region=Box((0.1, 0.1), (5.0, 0.0)), force=(1.0, 0.0)),
    ],
)
def test_a_region_that_holds_nothing_is_refused(item: Support | Load) -> None:
    particles = fill_scene(two_blocks(2, 1.0))
    kind = "support" if isinstance(item, Support) else "load"
    with pytest.raises(InputError, match=f"{kind} 'grip' region: the {kind} holds no particle"):
        select_held(particles, item)


def tank(**fields: object) -> Scene:
    """Two blocks between a floor and a side that share the corner, all on one lattice of 1 cm."""
    floor = Wall(name="floor", shape=Box((0.12, 0.02), (0.02, -0.025)), spacing=0.01, path="/World/floor")
    side = Wall(name="side", shape=Box((0.02, 0.06), (-0.03, -0.005)), spacing=0.01, path="/World/side")
    return Scene(**{**vars(two_blocks(2, 0.04)), "walls": (floor, side), **fields})  # type: ignore[arg-type]


def test_walls_come_after_the_bodies() -> None:
    without, particles = fill_scene(two_blocks(2, 0.04)), fill_scene(tank())
    assert particles.names == ("left", "right", "floor", "side")
    assert (particles.elastic, particles.elastic_bodies, without.elastic) == (24, 2, 24)
    for name in ("positions", "velocities", "masses", "spacings", "bodies", "groups", "ids"):
        np.testing.assert_array_equal(getattr(particles, name)[:24], getattr(without, name))
        np.testing.assert_array_equal(getattr(particles.elastic_part(), name), getattr(without, name))
    assert particles.elastic_part().names == without.names
    assert without.elastic_part() is without
    # of 12 particles of the side, the 4 in the corner are the floor's
    assert particles.ranges.tolist() == [[0, 12], [12, 24], [24, 48], [48, 56]]
    np.testing.assert_array_equal(particles.walls, [-1] * 24 + [0] * 24 + [1] * 8)
    assert set(particles.groups[24:].tolist()) == {2}
    assert particles.ids.tolist() == list(range(56))
    np.testing.assert_allclose(particles.masses[24:], 1000.0 * 0.01**2)
    assert np.unique(particles.positions.round(9), axis=0).shape == particles.positions.shape
    assert count_particles(tank()) == {"left": 12, "right": 12, "floor": 24, "side": 12}


def test_walls_that_overlap_off_the_lattice_keep_what_is_not_close() -> None:
    floor = tank().walls[0]
    shifted = Wall(name="side", shape=Box((0.02, 0.06), (-0.0265, -0.0065)), spacing=0.01)
    alone = fill_scene(tank(bodies=tank().bodies[1:], walls=(shifted,))).positions[12:]
    corner = fill_scene(tank(walls=(floor,))).positions[24:]
    near = np.linalg.norm(alone[:, None] - corner[None], axis=2).min(axis=1) < 0.005
    assert near.sum() == 4
    kept = fill_scene(tank(bodies=tank().bodies[1:], walls=(floor, shifted))).positions[36:]
    assert sorted(map(tuple, kept)) == sorted(map(tuple, alone[~near]))
    with pytest.raises(InputError, match="wall 'again' shape: lies inside /World/floor: nothing of it is left"):
        fill_scene(tank(walls=(floor, Wall(name="again", shape=floor.shape, spacing=0.01))))


def test_a_body_inside_a_wall_is_refused() -> None:
    high = Wall(name="floor", shape=Box((0.12, 0.02), (0.02, -0.018)), spacing=0.01, path="/World/floor")
    with pytest.raises(InputError, match="/World/block shape: overlaps /World/floor at"):
        fill_scene(tank(walls=(high,), bodies=(block(2, path="/World/block"),)))
    # or a wall inside a body
    pin = Wall(name="pin", shape=Box((0.01, 0.01)), spacing=0.01, path="/World/pin")
    with pytest.raises(InputError, match="overlaps"):
        fill_scene(tank(walls=(pin,)))


def test_supports_loads_and_regions_act_on_no_wall() -> None:
    particles = fill_scene(tank())
    np.testing.assert_array_equal(select(particles, Box((9.0, 9.0))), np.arange(24))
    floor = Support(name="grip", region=Box((0.12, 0.02), (0.02, -0.026)))
    with pytest.raises(InputError, match="the support holds no particle"):
        select_held(particles, floor)


def test_what_cannot_be_counted_is_named() -> None:
    """A box of a plane has no end along z."""
    scene = scene_of(block(2), dimension=3)
    with pytest.raises(InputError, match="body 'block' shape: is unbounded"):
        count_particles(scene)


def test_bodies_that_are_apart_are_not_compared_one_by_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """Hundreds of bodies are a case like another: only those that come near each other are looked at."""
    compared = []
    monkeypatch.setattr(overlaps, "contains", lambda *args: compared.append(args) or contains(*args))
    apart = [(0.3 * i, 0.3 * j) for i in range(20) for j in range(20)]
    bodies = [block(2, name=f"b{k}", shape=Box((0.2, 0.2), at), spacing=0.1) for k, at in enumerate(apart)]
    fill_scene(scene_of(*bodies))
    assert compared == []
    near = block(2, name="near", shape=Box((0.2, 0.2), (-0.19, 0.0)), spacing=0.1)
    fill_scene(scene_of(*bodies, near))
    assert len(compared) == 4
