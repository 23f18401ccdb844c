"""The added mass of water: the frequency of a plate at the bottom of a tank falls with the depth of the water.

Physics: an aluminium plate of 1 m by 50 mm, clamped at both ends; its weight and that of the water are applied at once.
Reference: the frequency of a clamped beam (Rao, Mechanical Vibrations, section 8.5), with the shear that 2-D elasticity
has, and the added mass of potential flow in a tank of the depth H: with the mode sum a_n cos(n pi x/L) of unit mean
square, rho (a_0^2 H + 1/2 sum a_n^2 tanh(n pi H/L) L/(n pi)) (Lamb, Hydrodynamics, section 228).
Run time: 14 s on one core, 4 s with --quick (0.25 m alone).
Command: python examples/wet_plate.py [--quick]
Expect: 268.0, 165.1, 134.7 and 104.7 Hz under 0, 0.25, 0.5 and 1 m of water, within 1 % of theory.
"""

from __future__ import annotations

import sys
import tempfile

import numpy as np

import warp_mps as mps

# --- the case

SPAN, THICKNESS = 1.0, 0.05  # [m]
ALUMINIUM = mps.Material(density=2700.0, youngs_modulus=67.5e9, poissons_ratio=0.34)
DRY = 269.0  # [Hz]
LAYERS = 3


def tank(depth: float) -> mps.Scene:
    """The plate under a depth of water [m], which may be 0."""
    l0 = THICKNESS / LAYERS
    over, thick, high = 2 * l0, 4 * l0, depth + 0.1
    plate = mps.Body(
        name="plate",
        shape=mps.Box((SPAN + 2 * over, THICKNESS), center=(SPAN / 2, -THICKNESS / 2)),
        material=ALUMINIUM,
        spacing=l0,
    )
    column = mps.Box((SPAN, depth), center=(SPAN / 2, depth / 2)) if depth else None
    sides = (("left", -thick / 2), ("right", SPAN + thick / 2)) if depth else ()
    return mps.Scene(
        name=f"wet_plate_{depth:g}",
        bodies=(plate,),
        fluids=(mps.Fluid(name="water", shape=column, spacing=l0),) if column else (),
        walls=tuple(
            mps.Wall(name=name, shape=mps.Box((thick, high), center=(x, high / 2)), spacing=l0) for name, x in sides
        ),
        supports=tuple(
            mps.Support(name=f"{name}_clamp", region=mps.Box((over, THICKNESS), center=(x, -THICKNESS / 2)))
            for name, x in (("left", -over / 2), ("right", SPAN + over / 2))
        ),
        probes=(mps.Probe(name="middle", point=(SPAN / 2, -THICKNESS / 2)),),
        measurements=(mps.Measurement(name="f", measure="frequency", probe="middle", component=1, unit="Hz"),),
        contact=mps.Contact(between="none"),
        gravity=(0.0, -9.81),
        duration=0.06 if depth else 0.02,
        frame_rate=100.0,
        sample_rate=5000.0,  # the interval between samples is the longest step
    )


# --- the theory


def theory(depth: float) -> float:
    """Frequency under a depth of water [Hz]."""
    x = (np.arange(2000) + 0.5) / 2000
    k = 4.730041
    mode = np.cosh(k * x) - np.cos(k * x) - 0.982502 * (np.sinh(k * x) - np.sin(k * x))
    mode /= np.sqrt(np.mean(mode**2))
    n = np.arange(1, 30)
    parts = 2.0 * np.mean(mode * np.cos(np.pi * np.outer(n, x)), axis=1)
    added = np.mean(mode) ** 2 * depth + 0.5 * np.sum(parts**2 * np.tanh(n * np.pi * depth / SPAN) * SPAN / (n * np.pi))
    return float(DRY / np.sqrt(1.0 + 1000.0 * added / (ALUMINIUM.density * THICKNESS)))


# --- the numbers


def main(quick: bool = False) -> dict[float, float]:
    """Run and print every depth; the relative error of the frequency by depth [m]."""
    errors = {}
    with tempfile.TemporaryDirectory() as folder:
        for depth in (0.0, 0.25) if quick else (0.0, 0.25, 0.5, 1.0):
            (row,) = mps.run_scene(tank(depth), f"{folder}/{depth:g}", quiet=True).measurements
            errors[depth] = row["value"] / theory(depth) - 1.0
            print(
                f"{depth:4} m of water: {row['value']:6.1f} Hz, theory {theory(depth):6.1f} Hz ({errors[depth]:+.1%})"
            )
    return errors


if __name__ == "__main__":
    main(quick="--quick" in sys.argv)
