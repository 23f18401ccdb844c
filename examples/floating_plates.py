"""Three plates of different density float side by side at the draught of Archimedes.

Physics: elastic plates of 0.12 m by 20 mm, a quarter, a half and three quarters as dense as water, start at
their draught and float freely.
Reference: Archimedes: the draught is the relative density times the thickness, 5, 10 and 15 mm.
Run time: 40 s on one core, 4 s with --quick (0.2 s instead of 2 s).
Command: python examples/floating_plates.py [--quick]
Expect: draughts within 0.5 mm, a tenth of a spacing, and a drift of at most half a spacing.
"""

from __future__ import annotations

import sys
import tempfile

import numpy as np

import warp_mps as mps

# --- the case

LENGTH, THICKNESS, GAP, DEPTH = 0.12, 0.02, 0.06, 0.08  # [m]
L0 = 0.005  # [m]
DENSITIES = (250.0, 500.0, 750.0)  # [kg/m^3]
WIDTH = 3 * LENGTH + 4 * GAP


def tank(duration: float) -> mps.Scene:
    """The plates at their draught in a tank; the water, filled to a level, leaves them out."""
    plates = []
    for k, density in enumerate(DENSITIES):
        left, bottom = GAP + k * (LENGTH + GAP), DEPTH - density / 1000.0 * THICKNESS
        shape = mps.Box.from_corners((left, bottom), (left + LENGTH, bottom + THICKNESS))
        foam = mps.Material(density=density, youngs_modulus=2e6, poissons_ratio=0.3)
        plates.append(mps.Body(name=f"plate_{density:.0f}", shape=shape, material=foam, spacing=L0))
    walls = mps.tank((0.0, 0.0), (WIDTH, 0.12), L0, layers=4)
    probes = [mps.Probe(name=plate.name, body=plate.name, quantity="position") for plate in plates]
    return mps.Scene(
        name="floating_plates",
        bodies=tuple(plates),
        fluids=(mps.fill_to(DEPTH, walls),),
        walls=walls,
        probes=(*probes, mps.Probe(name="level", point=(GAP / 2, 0.0), quantity="elevation")),
        contact=mps.Contact(between="none"),
        gravity=(0.0, -9.81),
        duration=duration,
        frame_rate=20.0,
        sample_rate=100.0,
    )


# --- the numbers


def main(quick: bool = False) -> dict[float, float]:
    """Run it; the error of the mean draught [m], by density."""
    with tempfile.TemporaryDirectory() as folder:
        mps.run_scene(tank(0.2 if quick else 2.0), folder, quiet=True)
        history = mps.read_history(f"{folder}/probes.csv")
    late = history.times > 0.5 * history.times[-1]
    errors = {}
    for density in DENSITIES:
        name = f"plate_{density:.0f}"
        y = np.asarray(history.probe(name, 1))[late]
        # the level stays: the plates displace as much water as they weigh
        draught, expected = DEPTH - (y.mean() - THICKNESS / 2), density / 1000.0 * THICKNESS
        drift = history.probe(name, 0)[-1] - history.probe(name, 0)[0]
        errors[density] = float(draught - expected)
        print(
            f"{density:4.0f} kg/m^3: draught {draught * 1e3:5.2f} mm, Archimedes {expected * 1e3:5.2f} mm, "
            f"rises and falls by {np.ptp(y) * 1e3:.2f} mm, drifts by {drift * 1e3:+.2f} mm"
        )
    return errors


if __name__ == "__main__":
    main(quick="--quick" in sys.argv)
