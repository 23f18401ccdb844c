"""A two-level preconditioner of the tangent: blocks of particles, and aggregates that move as rigid bodies.

    M^-1 = D^-1 + P (P^T A P)^-1 P^T,   A = K + m a

D are the diagonal blocks of the particles, and the columns of P the rigid motions of small groups of particles, at
their present positions. D^-1 is a good inverse for errors that vary from particle to particle. Smooth errors, such as
bending, would need as many iterations as a body has particles along it. They hardly strain small groups, so that the
rigid motions of the groups represent them. The sum is additive Schwarz (Toselli & Widlund): symmetric and positive, and
two small kernels more than D alone. Rigid motions of aggregates, which coarsen thin bodies without locking, are from
Bulgakov & Kuhn, and coarse spaces of them from Nicolaides and from Vanek et al. Their smoothing of P is left
out: it saves less than it costs here.

P^T A P is found from products with A: aggregates without a common neighbour move in the same product (Curtis et al.).
Its dense inverse, a block for each body, is computed on the host, to the same bits on any number of cores. It remains
good while a body bends and dt changes, so that it is rebuilt only when that pays.

References:
    Toselli, A. and Widlund, O., Domain Decomposition Methods, Springer (2005), chapters 2 and 3.
    Bulgakov, V. E. and Kuhn, G., Int. J. Numer. Meth. Engng 38 (1995) 3529.
    Nicolaides, R. A., SIAM J. Numer. Anal. 24 (1987) 355.
    Vanek, P., Mandel, J. and Brezina, M., Computing 56 (1996) 179.
    Curtis, A. R., Powell, M. J. D. and Reid, J. K., J. Inst. Math. Appl. 13 (1974) 117.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from warp_mps.core.counters import require_within
from warp_mps.core.replay import Replay
from warp_mps.core.types import NumericTypes
from warp_mps.elastic.hamiltonian.model import HamiltonianModel
from warp_mps.elastic.implicit.aggregates import aggregate
from warp_mps.elastic.implicit.coarse_matrix import CoarseMatrix
from warp_mps.elastic.implicit.reuse_policy import ReusePolicy
from warp_mps.elastic.implicit.tangent_operator import Tangent
from warp_mps.elastic.implicit.two_level_kernels import two_level_kernels
from warp_mps.elastic.state import ElasticState
from warp_mps.particles.particles import Particles

# shift of the diagonal of a coarse matrix of unit diagonal: for unsupported bodies, and for the rounding of products
SHIFTS = {"float64": 1e-12, "float32": 1e-6}
# cost of a rebuild in iterations: what the host does in any case, one for each product, and for the inversion of m
# rows as many as m^3 / 20 over the pairs of particles
HOST, INVERSION = 20.0, 0.05
# on a GPU an iteration takes as long as on a core of a CPU one of so many pairs, or of one in so many of its own
LAUNCHES, CORES = 3e4, 50.0
# particles that a thread of a GPU sums up, and threads that share a row of the inverse: without them, few threads of a
# few hundred terms each would take longer than the product with the tangent
PARTICLES, SHARES = 32, 16


class TwoLevelPreconditioner:
    """Preconditioner of `warp_mps.core.linear.conjugate_gradient.ConjugateGradient` for a `Tangent`.

    Attributes:
        aggregates: The groups of particles.
        matrix: The matrix of the coarse level, whose unknowns are the rigid motions of the groups.
        parts: Parts into which the sums over the groups are cut.
        reuse: When the coarse level is rebuilt. The first solves run without it, until it pays.

    Args:
        tangent: The operator, whose blocks are the fine level.
        model: The model.
        particles: Its particles.
        state: Its state.
        held: Whether each axis of each particle is held, shape [n, d].
        inertia: The factor a of the masses [1/s^2], float64, shape [1].
        types: Number types.
        device: Warp device.
        graphs: Whether launches are replayed as graphs.
        parallel: Whether several threads share a long sum; None is on a GPU.
    """

    def __init__(
        self,
        tangent: Tangent,
        model: HamiltonianModel,
        particles: Particles,
        state: ElasticState,
        held: np.ndarray,
        inertia: wp.array,
        *,
        types: NumericTypes,
        device: Any,
        graphs: bool = True,
        parallel: bool | None = None,
    ) -> None:
        self._kernels, self._device = two_level_kernels(types), device
        self._run = Replay(device=device, graphs=graphs)
        self._tangent, self._model, self._state, self._inertia = tangent, model, state, inertia
        self._n, d = held.shape
        self._modes, self._shift = 3 * (d - 1), SHIFTS[types.precision]
        start, index = model.start.numpy(), model.index.numpy()
        moves = np.asarray(~held.all(axis=1))
        rings = 2 if model.dilatation.acts else 1
        self.aggregates = aggregate(
            particles.positions, particles.spacings, moves, start, index, modes=self._modes, rings=rings
        )
        self.matrix = CoarseMatrix(self.aggregates, self._modes)
        groups, matrix = self.aggregates, self.matrix
        self._colours = int(groups.colours.max(initial=-1)) + 1
        self._parallel = wp.get_device(device).is_cuda if parallel is None else parallel
        pairs = max(LAUNCHES, len(index) / CORES) if self._parallel else len(index)
        inversion = float(np.sum(matrix.sizes.astype(float) ** 3)) / pairs
        self.reuse = ReusePolicy(HOST + self._colours * self._modes + INVERSION * inversion)

        def integers(values: np.ndarray) -> wp.array:
            return wp.array(values, dtype=wp.int32, device=device)

        vec64 = wp.types.vector(length=d, dtype=wp.float64)
        self._motion = wp.types.vector(length=self._modes, dtype=wp.float64)
        self._reference = wp.array(particles.positions, dtype=vec64, device=device)
        self._free = wp.array(~held, dtype=types.vec, device=device)
        self._of, self._paint = integers(groups.of), integers(groups.colours)
        self._first, self._order = integers(groups.first), integers(groups.order)
        parts, of_aggregate = _parts(groups.first, PARTICLES if self._parallel else self._n)
        self._part, self._part_first = integers(parts), integers(of_aggregate)
        self.parts = len(parts) - 1
        self._wrenches = wp.zeros(self.parts, dtype=self._motion, device=device)
        self._threads = SHARES if self._parallel else 1
        self._rows = [integers(matrix.first), integers(matrix.block), integers(matrix.size)]
        self._arm = wp.zeros(self._n, dtype=vec64, device=device)
        self._x, self._q = (wp.zeros(held.size, dtype=wp.float64, device=device) for _ in range(2))
        unknowns = groups.count * self._modes
        self._wrench, self._response = (wp.zeros(unknowns, dtype=wp.float64, device=device) for _ in range(2))
        self._shares = wp.zeros(self._threads * unknowns, dtype=wp.float64, device=device)
        self._answers = wp.zeros(self._colours * self._modes * unknowns, dtype=wp.float64, device=device)
        self._inverse = wp.zeros(matrix.total, dtype=wp.float64, device=device)
        self._on, self._always = wp.zeros(1, dtype=wp.int32, device=device), integers(np.ones(1))
        # displacements and inertia for which the coarse level was computed
        self._made_of, self._made_at = wp.zeros_like(state.u), wp.zeros_like(inertia)

    def prepare(self, matrix: Any, inverse: wp.array) -> None:
        """Launch the blocks of the particles at the present state."""
        self._tangent.prepare(matrix, inverse)

    def apply(self, r: wp.array, z: wp.array) -> None:
        """Launch z = M^-1 r."""
        self._tangent.apply(r, z)
        if self.aggregates.count == 0:
            return
        kernels, vectors = self._kernels, self._tangent.vectors
        self._restrict(self._on, 0, r, self._wrench)
        inputs = [self._on, self._threads, int(self._parallel), *self._rows, self._inverse, self._wrench]
        self._launch(kernels.coarse_solve, len(self._shares), inputs, [self._shares])
        self._launch(kernels.sum_shares, len(self._wrench), [self._on, self._threads, self._shares], [self._response])
        inputs = [self._on, self._of, self._free, self._arm, self._motions(self._response)]
        self._launch(kernels.prolong, self._n, inputs, [vectors(z)])

    def rebuild(self) -> None:
        """Compute the coarse level at the present state, whose stresses the model must hold; waits for the device."""
        wp.copy(self._made_of, self._state.u)
        wp.copy(self._made_at, self._inertia)
        self._make()
        self.reuse.record_rebuild()

    def arrays(self) -> dict[str, np.ndarray]:
        """Host copies of what evolves, by name, for a checkpoint."""
        numbers = [*self.reuse.state(), self._on.numpy()[0], self._made_at.numpy()[0]]
        return {"coarse": np.array(numbers), "coarse_u": self._made_of.numpy().copy()}

    def assign(self, arrays: dict[str, np.ndarray]) -> None:
        """Continue from arrays that `arrays` gave; the model's stresses are those of the present state afterwards."""
        *policy, on, at = arrays["coarse"]
        self.reuse.assign(np.array(policy))
        self._made_of.assign(arrays["coarse_u"])
        self._made_at.fill_(at)
        require_within("coarse", np.array([on]), 1)
        self._on.fill_(int(on))
        if not on:
            return
        u, inertia, evaluate = self._state.u, self._inertia, self._model.evaluate_stresses
        now = [(array, wp.clone(array)) for array in (u, inertia)]
        wp.copy(u, self._made_of)
        wp.copy(inertia, self._made_at)
        evaluate(self._state)
        self._make()
        for array, kept in now:
            wp.copy(array, kept)
        evaluate(self._state)

    def _make(self) -> None:
        if self.aggregates.count == 0:
            return
        self._run("probe", self._probe)
        answers = self._answers.numpy().reshape(self._colours, self._modes, self.aggregates.count, self._modes)
        self._inverse.assign(self.matrix.inverse(answers, self._shift))
        self._on.fill_(1)

    def _probe(self) -> None:
        """Products with A: forces and moments on the aggregates while those of one colour move."""
        kernels, tangent = self._kernels, self._tangent
        self._launch(
            kernels.arms, self.aggregates.count, [self._first, self._order, self._reference, self._state.u], [self._arm]
        )
        for colour in range(self._colours):
            for mode in range(self._modes):
                inputs = [colour, mode, self._of, self._paint, self._free, self._arm]
                self._launch(kernels.rigid_motion, self._n, inputs, [tangent.vectors(self._x)])
                tangent.multiply(self._x, self._q)
                place = (colour * self._modes + mode) * self.aggregates.count
                self._restrict(self._always, place, self._q, self._answers)

    def _restrict(self, on: wp.array, place: int, r: wp.array, out: wp.array) -> None:
        inputs = [on, self._part, self._order, self._free, self._arm, self._tangent.vectors(r)]
        self._launch(self._kernels.restrict, len(self._wrenches), inputs, [self._wrenches])
        inputs = [on, place, self._part_first, self._wrenches]
        self._launch(self._kernels.sum_parts, self.aggregates.count, inputs, [self._motions(out)])

    def _motions(self, flat: wp.array) -> wp.array:
        """A view of coarse unknowns as one vector for each aggregate."""
        count = len(flat) // self._modes
        return wp.array(ptr=flat.ptr, dtype=self._motion, shape=count, device=self._device, copy=False)

    def _launch(self, kernel: Any, n: int, inputs: list[Any], outputs: list[Any]) -> None:
        wp.launch(kernel, n, inputs, outputs, device=self._device)


def _parts(first: np.ndarray, most: int) -> tuple[np.ndarray, np.ndarray]:
    """First places of parts of aggregates of at most so many particles, and the first part of each aggregate."""
    counts = -(-np.diff(first) // most)
    of_aggregate = np.concatenate(([0], np.cumsum(counts)))
    within = np.arange(of_aggregate[-1]) - np.repeat(of_aggregate[:-1], counts)
    return np.append(np.repeat(first[:-1], counts) + within * most, first[-1]), of_aggregate
