"""The same run gives the same bits, however it is launched; single precision stays near double precision.

Single precision is compared while runs have the same course: where water breaks up and bodies bounce on, two of them
part in time whatever the difference at the start.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

from tests.bits import State, assert_same_bits, states
from tests.coupling.scenes import EXPLICIT, IMPLICIT
from tests.elastic.contact.test_walls import pushed
from tests.elastic.hamiltonian.test_motion import hamiltonian
from tests.elastic.implicit.test_static import cantilever
from tests.elastic.implicit.test_theta_rule import rod
from tests.fluid.scenes import SCHEMES
from tests.fluid.test_fluids import splash
from tests.run.test_guards import gate
from tests.run.test_simulation import everything
from warp_mps.run.simulation import Simulation
from warp_mps.scene import Scene
from warp_mps.scene.choices import PRECISIONS


@dataclass(frozen=True)
class Case:
    """A run.

    Attributes:
        make: Makes its scene.
        steps: Steps of its clock.
        single: Largest difference that single precision makes to displacements, velocities and energies, relative to
            the largest of each [-].
    """

    make: Callable[[], Scene]
    steps: int
    single: float


CASES = {
    **{f"springs {d}-D": Case(lambda d=d: everything(d), 150, 2e-5) for d in (2, 3)},
    **{f"hamiltonian {d}-D": Case(lambda d=d: hamiltonian(d), 150, 2e-5) for d in (2, 3)},
    "moving wall": Case(pushed, 150, 2e-5),
    "implicit": Case(lambda: rod(gravity=(0.0, -9.81), time_step=5e-4), 40, 5e-5),
    "static 2-D": Case(lambda: cantilever(2, load_steps=2), 2, 1e-5),
    "static 3-D": Case(lambda: cantilever(3, load_steps=2), 2, 1e-5),
    **{f"fluid 2-D, {name}": Case(lambda name=name: splash(2, scheme=name), 6, 5e-5) for name in SCHEMES},
    "fluid 3-D": Case(lambda: splash(3), 6, 5e-5),
    "coupled, explicit": Case(lambda: gate(**EXPLICIT), 6, 5e-5),
    # single precision solves a step to 1e-4 of its forces
    "coupled, implicit": Case(lambda: gate(**IMPLICIT), 4, 5e-4),
}


@functools.cache
def whole(name: str, precision: str) -> tuple[Simulation, list[State]]:
    """A run at its end, and its states after the first step, after half of the steps and at the end."""
    simulation = Simulation(CASES[name].make(), precision=precision)
    return simulation, states(simulation, *parts(name))


def parts(name: str) -> tuple[int, int, int]:
    """Numbers of steps into which a run is cut."""
    steps = CASES[name].steps
    return 1, steps // 2, steps - steps // 2 - 1


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("name", CASES)
def test_twice_and_eager_the_same_bits(name: str, precision: str) -> None:
    _, first = whole(name, precision)
    runs = [Simulation(CASES[name].make(), precision=precision, graphs=graphs) for graphs in (True, False)]
    again, eager = (states(run, *parts(name)) for run in runs)
    assert any(np.abs(values).max() > 0.0 for key, values in first[-1].items() if key.endswith(("u", "v")))
    assert_same_bits(again, first)
    assert_same_bits(eager, first)


@pytest.mark.parametrize("name", CASES)
def test_single_precision_stays_near_double(name: str) -> None:
    double, single = (whole(name, precision)[0] for precision in PRECISIONS)
    differences = {}
    for quantity in ("displacements", "velocities"):
        a, b = getattr(double, quantity), getattr(single, quantity)
        differences[quantity] = np.abs(a - b).max() / max(np.abs(a).max(), np.finfo(float).tiny)
    scale = max(double.energy.exchanged, abs(double.energy.work))
    for part in ("kinetic", "elastic", "contact", "work", "dissipated"):
        differences[part] = abs(getattr(single.energy, part) - getattr(double.energy, part)) / scale
    print(name, ", ".join(f"{key} {value:.1e}" for key, value in differences.items()))
    assert max(differences.values()) < CASES[name].single
