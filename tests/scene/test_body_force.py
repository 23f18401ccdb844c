"""Identity of the function of a body force, and where it is refused."""

from __future__ import annotations

import functools
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import warp as wp

from tests.scenes import block, scene_of
from warp_mps.errors import InputError
from warp_mps.results.settings import scene_settings
from warp_mps.results.summary import read_summary
from warp_mps.run.run import run_scene
from warp_mps.scene import BodyForce, Scene
from warp_mps.scene.body_force import function_identity
from warp_mps.usd.case.save import save_stage


def pull(strength: float) -> Callable[[np.ndarray, float], np.ndarray]:
    """A force towards the origin."""
    return lambda x, t: -strength * x


class Magnet:
    """A force as an object."""

    def __init__(self, strength: float) -> None:
        self.strength = strength

    def __call__(self, x: np.ndarray, t: float) -> np.ndarray:
        """Pull."""
        return -self.strength * x

    def push(self, x: np.ndarray, t: float) -> np.ndarray:
        """Push."""
        return self.strength * x


def scaled(strength: float, x: np.ndarray, t: float) -> np.ndarray:
    """A force of a strength."""
    return -strength * x


@pytest.mark.parametrize(
    "make",
    [pull, Magnet, lambda strength: Magnet(strength).push, lambda strength: functools.partial(scaled, strength)],
)
def test_the_identity_is_that_of_the_code_and_of_what_it_encloses(make: Callable[[Any], Any]) -> None:
    assert function_identity(make(2.0)) == function_identity(make(2.0))
    assert function_identity(make(2.0)) != function_identity(make(3.0))
    assert function_identity(make(np.ones(3))) == function_identity(make(np.ones(3)))
    assert function_identity(make(np.ones(3))) != function_identity(make(np.zeros(3)))


def test_the_identity_of_a_warp_function_and_of_one_that_encloses_itself() -> None:
    @wp.func
    def lift(x: wp.vec2d, t: wp.float64) -> wp.vec2d:
        return wp.vec2d(wp.float64(0.0), wp.float64(2.0))

    def again(x: np.ndarray, t: float) -> np.ndarray:
        return x if t < 1.0 else again(x, t - 1.0)

    force = BodyForce(name="lift", acceleration=lift)
    assert force.is_warp_function
    assert "lift#" in repr(force)
    assert function_identity(again) == function_identity(again)
    assert function_identity(np.sin) != function_identity(np.cos)
    assert not BodyForce(name="again", acceleration=again).is_warp_function


def forced(function: Any) -> Scene:
    """A block under a force."""
    force = BodyForce(name="pull", acceleration=function)
    return scene_of(block(2), body_forces=(force,), duration=1e-3, frame_rate=1000.0)


def test_a_stage_cannot_hold_it(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="body force 'pull' acceleration: is a function, which a stage cannot hold"):
        save_stage(forced(pull(1.0)), tmp_path / "case.usda")
    assert not list(tmp_path.iterdir())


def test_settings_name_the_function() -> None:
    settings = scene_settings(forced(pull(1.0)))
    assert settings["body_forces"]["pull"]["acceleration [m/s^2]"].startswith("pull.<locals>.<lambda>#")


def test_what_is_no_function_is_refused() -> None:
    with pytest.raises(InputError, match=r"body.?force 'pull' acceleration: is 9.81, must be a function"):
        forced(9.81)


def test_a_run_is_resumed_with_the_same_function_only(tmp_path: Path) -> None:
    run_scene(forced(pull(1.0)), tmp_path, quiet=True)
    with pytest.raises(InputError, match="belongs to another case"):
        run_scene(forced(pull(2.0)), tmp_path, quiet=True, resume=True)
    run_scene(forced(pull(1.0)), tmp_path, quiet=True, resume=True)
    assert read_summary(tmp_path / "run.json").status == "done"
