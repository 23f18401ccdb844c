"""The period of a standing wave in a tank by the depth of the water: a parametric study.

Physics: water in a tank 0.5 m long, 0.05 to 0.2 m deep, starts with a flat surface and the velocities of the first
standing wave, half a wave length of which fits into the tank.
Reference: linear waves, omega^2 = g k tanh(k H) with k = pi / 0.5 m.
Run time: 40 s on one core for four depths, 5 s with --quick (two depths, at twice the spacing).
Command: python examples/waves.py [--quick]
Expect: periods of 1.45, 1.07, 0.93 and 0.87 s at 0.05, 0.1, 0.15 and 0.2 m, within 1 %; 2 % with --quick.
"""

from __future__ import annotations

import math
import sys
import tempfile

import warp_mps as mps

# --- the case

LENGTH, GRAVITY = 0.5, 9.81  # [m, m/s^2]
WAVENUMBER = math.pi / LENGTH  # [1/m]


def period(depth: float) -> float:
    """The period of a small wave [s]."""
    return 2.0 * math.pi / math.sqrt(GRAVITY * WAVENUMBER * math.tanh(WAVENUMBER * depth))


def tank(depth: float, l0: float) -> mps.Scene:
    """Water in a tank, with a wave amplitude of a twentieth of its depth."""
    omega = 2.0 * math.pi / period(depth)
    wave = mps.VelocityField(
        kind="standing_wave",
        amplitude=(0.0, 0.05 * depth * omega),
        axis=(1.0, 0.0),
        origin=(0.0, 0.0),
        length=2.0 * LENGTH,
        depth=depth,
    )
    water = mps.Box.from_corners((0.0, 0.0), (LENGTH, depth))
    return mps.Scene(
        name="waves",
        fluids=(mps.Fluid(name="water", shape=water, spacing=l0, velocity_field=wave),),
        walls=mps.tank((0.0, 0.0), (LENGTH, 1.6 * depth), l0, layers=4),
        probes=(mps.Probe(name="water", body="water", quantity="position"),),
        measurements=(
            mps.Measurement(name="period", measure="period", probe="water", unit="s", reference=period(depth)),
        ),
        gravity=(0.0, -GRAVITY),
        duration=2.0 * period(depth),
        frame_rate=100.0,
    )


# --- the study


def main(quick: bool = False) -> dict[float, float]:
    """Run every depth and print the periods; the relative errors by depth [m]."""
    errors = {}
    with tempfile.TemporaryDirectory() as folder:
        for depth in (0.1, 0.2) if quick else (0.05, 0.1, 0.15, 0.2):
            scene = tank(depth, 0.025 / 2 if quick else 0.025 / 4)
            (row,) = mps.run_scene(scene, f"{folder}/{depth}", quiet=True).measurements
            errors[depth] = row["error"]
            print(f"{depth:4} m deep: {row['value']:.3f} s, linear waves {period(depth):.3f} s ({row['error']:+.1%})")
    return errors


if __name__ == "__main__":
    main(quick="--quick" in sys.argv)
