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


def box(left: float, right: float, bottom: float, top: float) -> mps.Box:
    """A box between its faces."""
    return mps.Box((right - left, top - bottom), center=((left + right) / 2, (bottom + top) / 2))


def tank(duration: float) -> mps.Scene:
    """The plates on the water, which fills the tank about them."""
    deepest = DEPTH - THICKNESS
    fluids = [mps.Fluid(name="water", shape=box(0, WIDTH, 0, deepest), spacing=L0)]
    fluids += [
        mps.Fluid(name=f"gap_{k}", shape=box(left, left + GAP, deepest, DEPTH), spacing=L0)
        for k, left in enumerate(k * (LENGTH + GAP) for k in range(4))
    ]
    plates = []
    for k, density in enumerate(DENSITIES):
        left, bottom = GAP + k * (LENGTH + GAP), DEPTH - density / 1000.0 * THICKNESS
        below = box(left, left + LENGTH, deepest, bottom)
        fluids.append(mps.Fluid(name=f"below_{k}", shape=below, spacing=L0))
        shape = box(left, left + LENGTH, bottom, bottom + THICKNESS)
        foam = mps.Material(density=density, youngs_modulus=2e6, poissons_ratio=0.3)
        plates.append(mps.Body(name=f"plate_{density:.0f}", shape=shape, material=foam, spacing=L0))
    thick, high = 4 * L0, 0.12
    sides = {"left": box(-thick, 0, 0, high), "right": box(WIDTH, WIDTH + thick, 0, high)}
    floor = {"floor": box(-thick, WIDTH + thick, -thick, 0)}
    probes = [mps.Probe(name=plate.name, body=plate.name, quantity="position") for plate in plates]
    return mps.Scene(
        name="floating_plates",
        bodies=tuple(plates),
        fluids=tuple(fluids),
        walls=tuple(mps.Wall(name=name, shape=shape, spacing=L0) for name, shape in (floor | sides).items()),
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
