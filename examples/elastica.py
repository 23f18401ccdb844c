"""Large deflections of a slender cantilever under a tip load: a static analysis.

Physics: a strip of 1 x 0.05 m (E 100 MPa, nu 0, plane stress), clamped at x = 0, with a vertical dead load P at its
tip. A static analysis finds the equilibrium in ten increments, up to P L^2 / EI = 5.
Reference: the elastica, an inextensible beam without shear: tip at 0.9436, -0.3017 (P L^2 / EI = 1), 0.8394, -0.4935
(2) and 0.6124, -0.7138 (5) (Mattiasson, *Numerical results from large deflection beam and frame problems analysed by
means of elliptic integrals*, 1981).
Run time: 6 s on one core, 3 s with --quick (5 instead of 8 particles through the thickness).
Command: python examples/elastica.py [--quick]
Expect: the tip within 0.003 m of the reference, with --quick as well.
"""

from __future__ import annotations

import sys
import tempfile

import numpy as np

import warp_mps as mps

# --- the case

LENGTH, THICKNESS, YOUNGS_MODULUS = 1.0, 0.05, 1e8  # [m, m, Pa]
STIFFNESS = YOUNGS_MODULUS * THICKNESS**3 / 12.0  # EI per depth [N m]
LARGEST, INCREMENTS = 5.0, 10  # P L^2 / EI
# P L^2 / EI: the tip [m]
REFERENCE = {1.0: (1.0 - 0.05643, -0.30172), 2.0: (1.0 - 0.16064, -0.49346), 5.0: (1.0 - 0.38763, -0.71379)}


def strip(layers: int) -> mps.Scene:
    """The strip with a number of particles through its thickness; two more columns lie in the clamp."""
    l0 = THICKNESS / layers
    material = mps.Material(density=1000.0, youngs_modulus=YOUNGS_MODULUS, poissons_ratio=0.0)
    shape = mps.Box((LENGTH + 2 * l0, THICKNESS), center=(LENGTH / 2 - l0, 0.0))
    body = mps.Body(name="strip", shape=shape, material=material, spacing=l0, node_axes=(0,))
    clamp = mps.Support(name="clamp", region=mps.Box((2 * l0, 2 * THICKNESS), center=(-l0, 0.0)))
    tip = mps.Box((0.5 * l0, 2 * THICKNESS), center=(LENGTH, 0.0))
    load = mps.Load(name="load", region=tip, force=(0.0, -LARGEST * STIFFNESS / LENGTH**2))
    return mps.Scene(
        name="elastica",
        bodies=(body,),
        supports=(clamp,),
        loads=(load,),
        probes=(mps.Probe(name="tip", quantity="position", region=tip),),
        plane="stress",
        gravity=(0.0, 0.0),
        analysis="static",
        load_steps=INCREMENTS,
        duration=1.0,
    )


# --- the comparison


def main(quick: bool = False) -> float:
    """Run it and print the tip beside the reference; the largest distance between them [m]."""
    with tempfile.TemporaryDirectory() as folder:
        mps.run_scene(strip(5 if quick else 8), folder, quiet=True)
        history = mps.read_history(f"{folder}/probes.csv")
    tips = np.column_stack([history.probe("tip", 0), history.probe("tip", 1)])
    worst = 0.0
    for load, reference in REFERENCE.items():
        tip = tips[np.abs(history.times - load / LARGEST).argmin()]
        apart = float(np.linalg.norm(tip - reference))
        worst = max(worst, apart)
        print(f"P L^2/EI = {load:g}: tip at {tip[0]:.4f}, {tip[1]:.4f} m; {apart * 1e3:.1f} mm from the elastica")
    return worst


if __name__ == "__main__":
    main(quick="--quick" in sys.argv)
