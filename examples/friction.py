"""A block on a slope with Coulomb friction: it slides below the critical coefficient, and sticks above it.

Physics: a block of rubber, 0.08 x 0.04 m (E 1 MPa, nu 0.3, 1000 kg/m^3), on a rigid slope of 20 degrees (gravity is
rotated); coefficients of friction of 0, 0.1, 0.2 and 0.5.
Reference: Coulomb: s = g (sin a - mu cos a) t^2 / 2 where mu < tan a = 0.364, and else 0.
Run time: 3 s on one core, 2 s with --quick (half the time).
Command: python examples/friction.py [--quick]
Expect: distances within 1 % of the reference; at a coefficient of 0.5 the block gives by 0.04 mm, and sticks.
"""

from __future__ import annotations

import math
import sys
import tempfile

import warp_mps as mps

# --- the case

ANGLE, GRAVITY = math.radians(20.0), 9.81  # [rad, m/s^2]
# its damping ends the bounces of a block that is put down without having sagged
RUBBER = mps.Material(density=1000.0, youngs_modulus=1e6, poissons_ratio=0.3, retardation_time=1e-3)
L0 = 0.01  # [m]


def slope(friction: float, duration: float) -> mps.Scene:
    """A block on a slope with a coefficient of friction."""
    block = mps.Body(name="block", shape=mps.Box((0.08, 0.04), center=(0.0, 0.02)), material=RUBBER, spacing=L0)
    floor = mps.Wall(name="slope", shape=mps.Box((0.8, 0.02), center=(0.3, -0.01)), spacing=L0)
    return mps.Scene(
        name="slope",
        bodies=(block,),
        walls=(floor,),
        probes=(mps.Probe(name="way", body="block"),),
        gravity=(GRAVITY * math.sin(ANGLE), -GRAVITY * math.cos(ANGLE)),
        contact=mps.Contact(friction=friction),
        duration=duration,
        frame_rate=50.0,
    )


def expected(friction: float, duration: float) -> float:
    """The distance along the slope [m]."""
    return 0.5 * GRAVITY * max(math.sin(ANGLE) - friction * math.cos(ANGLE), 0.0) * duration**2


# --- the study


def main(quick: bool = False) -> dict[float, tuple[float, float]]:
    """Run and print every coefficient; the distance and its reference by the coefficient [m]."""
    duration, ways = 0.2 if quick else 0.4, {}
    with tempfile.TemporaryDirectory() as folder:
        for friction in (0.0, 0.1, 0.2, 0.5):
            mps.run_scene(slope(friction, duration), f"{folder}/{friction}", quiet=True)
            way = float(mps.read_history(f"{folder}/{friction}/probes.csv").probe("way", 0)[-1])
            ways[friction] = way, expected(friction, duration)
            print(f"friction {friction:3}: {1e3 * way:7.2f} mm, Coulomb {1e3 * ways[friction][1]:7.2f} mm")
    return ways


if __name__ == "__main__":
    main(quick="--quick" in sys.argv)
