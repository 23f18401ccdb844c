"""Contact on a given set of particles: its grid, its candidate list and the launches that use them."""

import itertools
import math
from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.neighbours import make_grid
from warp_mps.core.types import NumericTypes
from warp_mps.core.weights import REACH_TOLERANCE
from warp_mps.elastic.contact.friction import Friction
from warp_mps.elastic.contact.kernels import PARTICLES_PER_THREAD, contact_kernels
from warp_mps.elastic.contact.law import APART, SUPPORT, capacity, law_constants
from warp_mps.elastic.contact.search_kernels import CHUNK, FACES, search_kernels
from warp_mps.elastic.state import ElasticState
from warp_mps.particles.particles import Particles
from warp_mps.scene import Scene

# margin of the candidate list beyond the support of the law, in units of the smallest spacing
SKIN = 0.35
# largest number of bodies whose bounding boxes are tested before the hash grid
MOST_BOXES = 64


def needs_contact(scene: Scene, particles: Particles) -> bool:
    """Whether any two particles could ever come into contact."""
    several = len(np.unique(particles.groups)) > 1
    return scene.contact.between == "all" or (scene.contact.between == "bodies" and several)


class Contacts:
    """Contact between the particles of a scene.

    Attributes:
        friction: Its friction; None if frictionless.
    """

    def __init__(self, scene: Scene, particles: Particles, *, types: NumericTypes, device: Any) -> None:
        self._search, self._kernels, self._device = search_kernels(types), contact_kernels(types), device
        n, spacings = particles.count, particles.spacings
        self._per_thread = PARTICLES_PER_THREAD["cpu" if wp.get_device(device).is_cpu else "cuda"]
        self._threads = -(-n // self._per_thread)
        # of the smallest spacing: with a larger one, lists of a coarse body beside a fine one would overflow
        self._margin = SKIN * float(spacings.min())
        self._reach = SUPPORT * float(spacings.max()) + self._margin
        self._within = int(scene.contact.between == "all")

        def real(values: np.ndarray) -> wp.array:
            return wp.array(values, dtype=types.real, device=device)

        def whole(shape: int | tuple[int, int]) -> wp.array:
            return wp.zeros(shape, dtype=wp.int32, device=device)

        groups, weights, scales = _laws(particles)
        # walls are rigid, so that a contact has the body's stiffness, and do not touch each other
        youngs = np.array([*(material.youngs_modulus for material in scene.materials), np.inf])[particles.materials]
        softest = np.full(len(weights), np.inf)
        np.minimum.at(softest, groups, youngs)
        radius = max(scene.elasticity.effective_radius, APART)
        self._reference = wp.array(particles.positions, dtype=types.vec, device=device)
        apart = radius * spacings * REACH_TOLERANCE
        apart[particles.elastic :] = np.inf
        self._spacing, self._apart = real(spacings), real(apart)
        self._group = wp.array(groups, dtype=wp.int32, device=device)
        self._stiffness, self._softest = real(youngs), real(softest)
        self._weights, self._scales = real(weights), real(scene.contact.stiffness * scales)
        rows = np.concatenate(([0], np.cumsum(self._room(particles))))
        self._start = wp.array(rows, dtype=wp.int32, device=device)
        self._listed = whole(int(rows[-1]))
        self._faces, self._facing, self._end = whole(n), whole((n, FACES)), whole((n, FACES))
        self._slope = wp.zeros((n, FACES), dtype=types.real, device=device)
        self._energy = real(np.zeros(n))
        self._points = wp.zeros(n, dtype=types.vec3, device=device)
        self._u_listed = wp.zeros(n, dtype=types.vec, device=device)
        self._stale, self._overflow = whole(1), whole(1)
        extent = particles.positions.max(axis=0) - particles.positions.min(axis=0)
        self._grid = make_grid(extent, self._reach, types=types, device=device)
        self._grid.reserve(n)
        self._boxes = self._make_boxes(particles, groups, types)
        self.friction = self._make_friction(scene, particles, groups, types)

    def initialize(self, state: ElasticState) -> None:
        """Build the candidate list at the present positions, and reset the overflow."""
        self._overflow.zero_()
        self._stale.fill_(1)
        self.locate(state)
        if self.friction:
            self.friction.initialize(state)

    def locate(self, state: ElasticState) -> None:
        """Rebuild the candidate list if a particle has moved by half of the margin since the last build."""
        inputs = [self._reference, self._margin, state.u, self._u_listed]
        wp.launch(self._search.locate, len(state.u), inputs, [self._points, self._stale], device=self._device)
        wp.capture_if(self._stale, self._list, state=state)

    def launch_force(self, state: ElasticState) -> None:
        """Add the contact forces."""
        self._launch_contact_density(state)
        inputs = [self._per_thread, *self._places(), *self._candidates(), state.u, self._slope, self._energy]
        outputs = [state.force, state.contact]
        wp.launch(self._kernels.force, self._threads, inputs, outputs, device=self._device)
        if self.friction:
            self.friction.launch(
                state, self._places(), [self._stiffness, self._softest], self._candidates(), self._slope
            )

    def launch_energy(self, state: ElasticState, energy_out: wp.array) -> None:
        """Contact energy of every particle, with that of the springs of friction [J]."""
        self._launch_contact_density(state)
        wp.copy(energy_out, self._energy)
        if self.friction:
            self.friction.add_energy(energy_out)

    def overflowed(self) -> int | None:
        """A particle that has met more others than the list holds, if there was one."""
        particle = int(self._overflow.numpy()[0])
        return particle - 1 if particle else None

    def evolving(self) -> list[wp.array]:
        """Device arrays of what evolves; the candidate list is valid at any positions, since `locate` checks it."""
        return self.friction.evolving() if self.friction else []

    def arrays(self) -> dict[str, np.ndarray]:
        """Host copies of what evolves, by name; the candidate list is rebuilt."""
        return self.friction.arrays() if self.friction else {}

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave."""
        if self.friction:
            self.friction.assign(arrays)

    def _launch_contact_density(self, state: ElasticState) -> None:
        laws = [self._stiffness, self._softest, self._weights, self._scales]
        inputs = [self._per_thread, *self._places(), *laws, *self._candidates(), state.u]
        outputs = [self._slope, self._energy]
        wp.launch(self._kernels.contact_density, self._threads, inputs, outputs, device=self._device)

    def _make_boxes(self, particles: Particles, groups: np.ndarray, types: NumericTypes) -> list[wp.array]:
        """Chunks of the bodies, their bounding boxes, and the group of each body; empty where boxes do not pay."""
        bodies = [] if self._within or len(particles.ranges) > MOST_BOXES else particles.ranges.tolist()
        chunks = [[(k, min(k + CHUNK, last)) for k in range(first, last, CHUNK)] for first, last in bodies]
        flat = np.array([chunk for rows in chunks for chunk in rows], np.int32).reshape(-1, 2)
        firsts = np.cumsum([0, *map(len, chunks)])

        def array(values: Any, dtype: Any) -> wp.array:
            return wp.array(np.asarray(values, np.int32), dtype=dtype, device=self._device)

        lows, highs = (wp.zeros(len(flat), dtype=types.vec3, device=self._device) for _ in range(2))
        self._body_boxes = [wp.zeros(len(bodies), dtype=types.vec3, device=self._device) for _ in range(2)]
        of_body = [groups[first] for first, _ in bodies]
        return [array(flat, wp.vec2i), array(firsts, wp.int32), lows, highs, array(of_body, wp.int32)]

    def _make_friction(
        self, scene: Scene, particles: Particles, groups: np.ndarray, types: NumericTypes
    ) -> Friction | None:
        friction = _frictions(scene, particles, groups)
        if not friction.any():
            return None
        _, first = np.unique(groups, return_index=True)
        own = particles.spacings[first]
        spring_stiffness = scene.contact.stiffness * own[:, None] ** (particles.dimension - 1) / (own[:, None] + own)
        return Friction(particles.count, spring_stiffness, friction, types=types, device=self._device)

    def _places(self) -> list[wp.array]:
        return [self._reference, self._spacing, self._group]

    def _candidates(self) -> list[wp.array]:
        return [self._start, self._listed, self._faces, self._facing, self._end]

    def _list(self, state: ElasticState) -> None:
        self._grid.build(self._points, self._reach)
        chunks, first_chunks, lows, highs, box_group = self._boxes
        wp.launch(self._search.chunk_boxes, len(lows), [chunks, self._points], [lows, highs], device=self._device)
        inputs = [first_chunks, lows, highs]
        wp.launch(self._search.body_boxes, len(box_group), inputs, self._body_boxes, device=self._device)
        search = [self._grid.id, self._reach, self._margin, *self._body_boxes, box_group, self._spacing]
        inputs = [*search, self._reference, self._group, self._apart, self._within, self._start, self._points, state.u]
        lists = [self._listed, self._faces, self._facing, self._end]
        outputs = [*lists, self._u_listed, self._stale, self._overflow]
        wp.launch(self._search.candidates, len(state.u), inputs, outputs, device=self._device)

    def _room(self, particles: Particles) -> np.ndarray:
        """Room in the list for the candidates of each particle, shape [n]."""
        kinds, kind = np.unique(particles.spacings, return_inverse=True)

        def rooms(filling: float) -> np.ndarray:
            reach = {(own, other): SUPPORT * max(own, other) + self._margin for own in kinds for other in kinds}
            needs = [[capacity(particles.dimension, reach[a, b], b, filling) for b in kinds] for a in kinds]
            return np.max(needs, axis=1)[kind]

        found = rooms(0.0)
        # in a corner, walls fill nearly the whole surroundings of a particle
        found[: particles.elastic] = rooms(_corner_filling(particles, self._reach))[: particles.elastic]
        return found


def _corner_filling(particles: Particles, reach: float) -> float:
    """Most particles of walls in a cube as wide as a reach, in units of a lattice's, at least 1; 0 without corners.

    There are more than a lattice's where walls meet, each on its own.
    """
    own = slice(particles.elastic, particles.count - particles.liquid)
    places, d = particles.positions[own], particles.dimension
    if len(np.unique(particles.bodies[own])) < 2:
        return 0.0
    most = 0
    for shift in itertools.product((0.0, 0.5), repeat=d):
        cells = np.floor((places - places.min(axis=0)) / reach + shift).astype(np.int64)
        _, counts = np.unique(np.ravel_multi_index(cells.T, cells.max(axis=0) + 1), return_counts=True)
        most = max(most, int(counts.max()))
    return max(1.0, most / math.ceil(reach / float(particles.spacings[own].min())) ** d)


def _laws(particles: Particles) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Groups of bodies numbered from 0, shape [n], and the law's w and c / stiffness for each two of them.

    A body in a corner of two walls touches each of them: every wall is a group by itself.
    """
    groups = np.where(particles.walls < 0, particles.groups, len(particles.names) + particles.walls)
    _, first, groups = np.unique(groups, return_index=True, return_inverse=True)
    spacings = particles.spacings[first]
    laws = [[law_constants(particles.dimension, own, other) for other in spacings] for own in spacings]
    weights, scales = np.moveaxis(np.array(laws), -1, 0)
    return groups, weights, scales


def _frictions(scene: Scene, particles: Particles, groups: np.ndarray) -> np.ndarray:
    """Coefficient of friction between each two groups: that of a wall where it has its own [-]."""
    friction = np.full((groups.max() + 1,) * 2, scene.contact.friction)
    for number, wall in enumerate(scene.walls):
        if wall.friction is not None:
            group = groups[np.argmax(particles.walls == number)]
            friction[group], friction[:, group] = wall.friction, wall.friction
    return friction
