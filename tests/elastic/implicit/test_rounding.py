"""What the rounding of the elastic forces allows: stiff bodies that have moved far as a whole."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.scenes import block
from warp_mps.elastic.implicit.rounding import FLOOR, Evaluation, describe_rounding
from warp_mps.elastic.implicit.solid import ImplicitSolid
from warp_mps.errors import RunError
from warp_mps.run.simulation import Simulation
from warp_mps.scene import LAWS, Material, Scene

STEEL = Material(7800.0, 2.1e11, 0.3)
STEP = 2e-3


def moved(
    material: Material, *, dimension: int = 2, shift: float, angle: float, precision: Any = "float64"
) -> ImplicitSolid:
    """A free block that has been moved and turned as a rigid body, before a step."""
    gravity = (0.0, -9.81, 0.0)[:dimension]
    body = block(dimension, material=material)
    scene = Scene(bodies=(body,), dimension=dimension, duration=1.0, integrator="implicit", time_step=STEP)
    simulation = Simulation(replace(scene, gravity=gravity), precision=precision)
    solid = simulation.solid
    assert isinstance(solid, ImplicitSolid)
    turn = np.eye(dimension)
    turn[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    x = simulation.particles.positions
    solid.state.u.assign(x @ turn.T + shift * np.arange(1, dimension + 1) / 3.0 - x)
    solid.start()
    return solid


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize(
    ("dimension", "precision", "modulus"), [(2, "float64", 2.1e11), (3, "float64", 2.1e11), (2, "float32", 1e7)]
)
def test_the_residual_stalls_at_its_rounding(
    dimension: int, precision: str, modulus: float, law: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Iterated on without a tolerance, it stays between 0.05 and 1 times the rounding of its state."""
    material = replace(STEEL, youngs_modulus=modulus, law=law)
    solid = moved(material, dimension=dimension, shift=0.02, angle=0.3, precision=precision)
    found: list[Evaluation] = []
    evaluate = solid.newton._evaluation

    def record(*given: Any) -> Evaluation:
        found.append(evaluate(*given))
        return found[-1]

    monkeypatch.setattr(solid.newton, "_evaluation", record)
    monkeypatch.setattr("warp_mps.elastic.implicit.newton.MOST_ITERATIONS", 8)
    monkeypatch.setattr(Evaluation, "floor", lambda self, first: 0.0)
    with pytest.raises(RunError):
        solid.advance(STEP, tolerance=1e-30)
    ratios = np.array([now.residual / now.rounding for now in found[4:]])
    assert 0.05 < np.median(ratios) < 1.0
    assert ratios.min() < FLOOR


@pytest.mark.parametrize("dimension", [2, 3])
def test_steel_that_has_moved_far_is_solved(dimension: int) -> None:
    """After metres and half a radian a step is solved to its rounding, far above 1e-8 of the forces."""
    solid = moved(STEEL, dimension=dimension, shift=1.0, angle=0.5)
    solid.advance(STEP)
    assert solid.newton.statistics.worst_residual < 1e-3
    last, _ = solid.newton._last
    assert 1e-8 * last.scale < last.residual <= FLOOR * last.rounding


def test_a_tolerance_above_the_rounding_is_reached_as_before() -> None:
    """Soft material is solved to the tolerance itself."""
    solid = moved(replace(STEEL, youngs_modulus=1e6), shift=0.02, angle=0.3)
    solid.advance(STEP)
    assert solid.newton.statistics.worst_residual <= 1e-8


def test_too_much_rounding_is_the_cause_and_the_remedy_works() -> None:
    """Steel after a kilometre: the message names the rounding, and a modulus with which the step is solved."""
    far: dict[str, Any] = {"shift": 1000.0, "angle": 0.5}
    solid = moved(STEEL, **far)
    with pytest.raises(RunError, match=r"rounded by .* N, for this stiffness and displacements of .* m") as caught:
        solid.advance(STEP)
    times = float(str(caught.value).split("a Young's modulus ")[1].split(" times lower")[0])
    assert times > 1.0
    moved(replace(STEEL, youngs_modulus=STEEL.youngs_modulus / times), **far).advance(STEP)


def test_single_precision_is_the_cause_and_double_solves_it() -> None:
    """A stiff block turned by a third of a radian in single precision."""
    stiff: dict[str, Any] = {"shift": 0.1, "angle": 0.3}
    material = replace(STEEL, youngs_modulus=1e9)
    with pytest.raises(RunError, match="take double precision"):
        moved(material, precision="float32", **stiff).advance(STEP)
    moved(material, **stiff).advance(STEP)


def test_rounding_is_blamed_only_where_it_is_near() -> None:
    """A residual far above its rounding has another cause, and so has one whose rounding may be reached."""
    far, fine = Evaluation(1.0, 10.0, 1e-6, 0.0, 0.0), Evaluation(1e-6, 10.0, 1e-6, 0.0, 0.0)
    assert describe_rounding(far, 0.0, 1.0, single=False) is None
    assert describe_rounding(fine, 0.0, 1.0, single=False) is None
    assert describe_rounding(fine._replace(scale=1e-4), 0.0, 1.0, single=False) is not None
