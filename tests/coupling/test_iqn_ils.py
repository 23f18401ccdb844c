"""The acceleration of fixed-point iterations, on linear maps whose spectrum is known."""

from __future__ import annotations

import numpy as np
import pytest

from warp_mps.coupling.iqn_ils import InterfaceQuasiNewton

N = 12


class Linear:
    """H(x) = M x + c with given eigenvalues of a matrix M that is not symmetric."""

    def __init__(self, eigenvalues: list[float], *, seed: int = 0) -> None:
        rng = np.random.default_rng(seed)
        basis = rng.normal(size=(N, N)) + 3.0 * np.eye(N)
        padded = np.pad(eigenvalues, (0, N - len(eigenvalues)))
        self.matrix = basis @ np.diag(padded) @ np.linalg.inv(basis)
        self.shift = rng.normal(size=N)

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """H(x)."""
        return self.matrix @ x + self.shift

    @property
    def root(self) -> np.ndarray:
        """Where H(x) = x."""
        return np.linalg.solve(np.eye(N) - self.matrix, self.shift)


def iterate(newton: InterfaceQuasiNewton, h: Linear, x: np.ndarray, passes: int) -> list[float]:
    """Errors of x before each of some passes, relative to the root."""
    errors = []
    for _ in range(passes):
        errors.append(float(np.linalg.norm(x - h.root) / np.linalg.norm(h.root)))
        newton.add(x, h(x))
        x = newton.next_iterate()
    newton.end_step()
    return errors


def test_the_first_step_of_all_is_that_of_the_fixed_point() -> None:
    newton, h, x = InterfaceQuasiNewton(2), Linear([-3.0, 0.5]), np.ones(N)
    newton.add(x, h(x))
    np.testing.assert_array_equal(newton.next_iterate(), h(x))


@pytest.mark.parametrize("eigenvalues", [[-8.0], [-8.0, -1.5, 0.4], [-40.0, -3.0, 2.5, 0.9, -0.2]])
def test_a_diverging_iteration_converges_in_as_many_passes_as_there_are_directions(eigenvalues: list[float]) -> None:
    """By itself it grows with its largest eigenvalue; two passes more than those show the root of a linear map."""
    h, x = Linear(eigenvalues), np.zeros(N)
    for _ in range(40):
        x = h(x)
    assert np.linalg.norm(x - h.root) > 1e3 * np.linalg.norm(h.root)
    errors = iterate(InterfaceQuasiNewton(2), h, np.zeros(N), len(eigenvalues) + 4)
    assert errors[len(eigenvalues)] > 1e-6
    assert errors[len(eigenvalues) + 2] < 1e-8
    assert errors[-1] < 1e-8


def test_what_a_step_has_shown_makes_the_next_ones_short() -> None:
    """The map's matrix stays and its constant changes, as from one step to the next."""
    h, newton = Linear([-8.0, -1.5, 0.4]), InterfaceQuasiNewton(3)
    assert iterate(newton, h, np.zeros(N), 5)[2] > 1e-3
    for seed in range(1, 5):
        h.shift = np.random.default_rng(seed).normal(size=N)
        assert iterate(newton, h, np.zeros(N), 3)[2] < 1e-8
    newton.forget()
    assert newton.memory.shape == (0, 2, 0)
    assert iterate(newton, h, np.zeros(N), 5)[2] > 1e-3


def test_only_the_last_steps_are_remembered() -> None:
    h, newton = Linear([-2.0, 0.5]), InterfaceQuasiNewton(2)
    for passes in (3, 4, 5):
        iterate(newton, h, np.ones(N), passes)
    assert newton.sizes.tolist() == [4, 3]
    iterate(newton, h, np.ones(N), 1)
    assert newton.sizes.tolist() == [4, 3], "a step that agrees at once shows nothing and drops nothing"


def test_memory_can_be_taken_over() -> None:
    """To the same bits, whatever the other one knew."""
    h, one, other = Linear([-8.0, -1.5, 0.4]), InterfaceQuasiNewton(2), InterfaceQuasiNewton(2)
    for passes in (3, 5):
        iterate(one, h, np.ones(N), passes)
    iterate(other, Linear([5.0], seed=3), np.ones(N), 4)
    other.assign(one.memory, one.sizes)
    h.shift = np.arange(N, dtype=float)
    assert iterate(other, h, np.zeros(N), 4) == iterate(one, h, np.zeros(N), 4)
    np.testing.assert_array_equal(other.memory, one.memory)
    other.assign(InterfaceQuasiNewton(2).memory, InterfaceQuasiNewton(2).sizes)
    assert other.sizes.tolist() == []


def test_columns_that_say_nothing_do_no_harm() -> None:
    """The same x twice, x that differ by rounding, and more columns than there are unknowns."""
    h, newton, x = Linear([-3.0]), InterfaceQuasiNewton(4), np.ones(N)
    newton.add(x, h(x))
    newton.add(x, h(x))
    np.testing.assert_array_equal(newton.next_iterate(), h(x))
    newton.add(x * (1.0 + 1e-15), h(x))
    newton.add(2.0 * x, h(2.0 * x))
    newton.add(2.0 * x, h(2.0 * x))
    for seed in range(2 * N):
        y = np.random.default_rng(seed).normal(size=N)
        newton.add(y, h(y))
    np.testing.assert_allclose(newton.next_iterate(), h.root, rtol=1e-6)
