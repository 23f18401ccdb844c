"""Whether two runs are the same, bit for bit."""

from __future__ import annotations

import numpy as np

from warp_mps.run.simulation import Simulation
from warp_mps.scene import Scene

State = dict[str, np.ndarray]
# quantities of a restored moment, before the run goes on
SHOWN = ("reactions", "internal_forces", "stresses", "energy")


def states(simulation: Simulation, *chunks: int) -> list[State]:
    """The state after each of some numbers of steps."""
    found = []
    for steps in chunks:
        simulation.advance(steps)
        found.append(simulation.state_arrays())
    return found


def assert_same_bits(left: list[State], right: list[State]) -> None:
    """Check that as many states are the same in everything that evolves."""
    for a, b in zip(left, right, strict=True):
        assert a.keys() == b.keys()
        for name, values in a.items():
            np.testing.assert_array_equal(values, b[name], err_msg=name)
            assert values.tobytes() == b[name].tobytes(), name


def assert_restored_goes_on(scene: Scene, first: int, rest: int) -> None:
    """Check that a run restored after some steps has the same quantities as then, and ends as an unbroken one."""
    whole, begun, restored = (Simulation(scene) for _ in range(3))
    whole.advance(first + rest)
    begun.advance(first)
    restored.restore(begun.state_arrays())
    for name in SHOWN:
        np.testing.assert_equal(getattr(restored, name), getattr(begun, name))
    restored.advance(rest)
    assert_same_bits([restored.state_arrays()], [whole.state_arrays()])
