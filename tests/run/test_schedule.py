"""The clock of a run: time steps that frames and samples fall on, and their limit."""

from __future__ import annotations

import pytest

from tests.scenes import RUBBER, block, scene_of
from warp_mps.elastic.explicit.time_step import stable_time_step
from warp_mps.elastic.materials.constants import pressure_wave_speed
from warp_mps.errors import InputError
from warp_mps.run.schedule import Clock
from warp_mps.scene import Contact, Material
from warp_mps.shapes import Box

CROSSING = 0.01 / pressure_wave_speed(RUBBER, 2, "strain")


def clock_of(**fields: object) -> Clock:
    """The clock of a block."""
    return Clock(scene_of(block(2), **fields))


@pytest.mark.parametrize("frame_rate", [7.0, 100.0, 12345.0, 1e6])
@pytest.mark.parametrize("ratio", [None, 1, 3, 10])
def test_frames_and_samples_fall_on_steps(frame_rate: float, ratio: int | None) -> None:
    rate = None if ratio is None else ratio * frame_rate
    clock = clock_of(frame_rate=frame_rate, sample_rate=rate, duration=1.0)
    assert clock.dt <= 0.25 * CROSSING * (1 + 1e-12)
    assert clock.frame_every * clock.dt == pytest.approx(1 / frame_rate, rel=1e-12)
    assert clock.sample_every * clock.dt == pytest.approx(1 / (rate or frame_rate), rel=1e-12)
    assert clock.frame_every % clock.sample_every == 0


def test_the_step_is_the_largest_that_fits() -> None:
    clock = clock_of(frame_rate=100.0)
    assert 0.01 / (clock.frame_every - 1) > 0.25 * CROSSING


def test_courant_number_sets_the_step() -> None:
    assert clock_of(courant=0.1).dt == pytest.approx(0.4 * clock_of(courant=0.25).dt, rel=0.01)


def test_a_given_step_is_kept() -> None:
    clock = clock_of(time_step=3e-6, frame_rate=1000.0, sample_rate=4000.0)
    assert clock.dt == 3e-6
    assert clock.sample_every == round(0.25e-3 / 3e-6)
    assert clock.frame_every == 4 * clock.sample_every


def test_the_run_lasts_as_long_as_it_should() -> None:
    clock = clock_of(duration=0.5, frame_rate=100.0)
    assert clock.steps == 50 * clock.frame_every
    odd = clock_of(duration=0.1234567)
    assert (odd.steps - 1) * odd.dt < 0.1234567 <= odd.steps * odd.dt
    assert clock_of(duration=1e-9).steps == 1


def test_the_finest_and_stiffest_body_counts() -> None:
    fine = block(2, name="fine", spacing=0.002, shape=Box((0.02, 0.02), (0.1, 0.0)))
    stiff = block(2, name="stiff", material=Material(1000.0, 9e7, 0.3), shape=Box((0.02, 0.02), (0.2, 0.0)))
    scenes = [scene_of(*bodies) for bodies in ([block(2)], [block(2), fine], [block(2), stiff])]
    limits = [Clock(scene).dt_limit for scene in scenes]
    assert limits[0] == stable_time_step(block(2), scenes[0])
    assert limits[1] == pytest.approx(limits[0] / 5)
    assert limits[2] == pytest.approx(limits[0] / 3)


def test_a_stiff_contact_shortens_the_step_and_a_soft_one_does_not() -> None:
    limits = [clock_of(contact=Contact(stiffness=value)).dt_limit for value in (0.1, 1.0, 4.0)]
    assert limits == pytest.approx([limits[1], limits[1], limits[1] / 2])


@pytest.mark.parametrize(
    ("fields", "attribute"),
    [
        ({"duration": 1e50}, "duration"),
        ({"time_step": 1e-50}, "time_step"),
        ({"frame_rate": 1e-50}, "frame_rate"),
    ],
)
def test_numbers_that_make_no_steps_are_refused(fields: dict, attribute: str) -> None:
    with pytest.raises(InputError, match=f"scene {attribute}: makes"):
        clock_of(**fields)
