"""Both elastic models on the same beam: convergence of its natural frequency.

Physics: a beam of 0.16 x 0.02 m (E 10 MPa, nu 0.3, 1000 kg/m^3, plane stress) on vertical rollers at its two end
sections. Gravity is switched on at rest, and the middle vibrates in the first bending mode.
Reference: 217.1 rad/s, 2-D elasticity by quadratic finite elements.
Run time: 15 s on one core, 2 s with --quick (without the finest).
Command: python examples/compare_models.py [--quick]
Expect: errors of -4.8, -1.7, -0.7 % with springs (first order and better), and +0.1, -0.2, -0.1 % with hamiltonian.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Sequence

import warp_mps as mps

# --- the case

LENGTH, THICKNESS = 0.16, 0.02  # [m]
REFERENCE = 217.1  # [rad/s]
RUBBER = mps.Material(density=1000.0, youngs_modulus=1e7, poissons_ratio=0.3)


def beam(model: str, layers: int, duration: float) -> mps.Scene:
    """The beam with a number of particles through its thickness."""
    body = mps.Body(
        name="beam",
        shape=mps.Box((LENGTH, THICKNESS), center=(LENGTH / 2, 0.0)),
        material=RUBBER,
        spacing=THICKNESS / layers,
        node_axes=(0,),  # a column of particles lies on each end section
    )
    rollers = tuple(
        mps.Support(name=name, region=mps.Box((1e-3, 0.03), center=(x, 0.0)), axes=(1,), hold_rotation=False)
        for name, x in (("left", 0.0), ("right", LENGTH))
    )
    frequency = mps.Measurement(
        name="frequency", measure="frequency", probe="middle", component=1, unit="rad/s", reference=REFERENCE
    )
    return mps.Scene(
        name=f"{model}_{layers}",
        bodies=(body,),
        supports=rollers,
        probes=(mps.Probe(name="middle", point=(LENGTH / 2, 0.0)),),
        measurements=(frequency,),
        plane="stress",
        gravity=(0.0, -9.81),
        duration=duration,
        frame_rate=1000.0,
        elasticity=mps.Elasticity(model=model),
    )


# --- the study


def main(layers: Sequence[int] = (4, 8, 16), duration: float = 0.12) -> dict[tuple[str, int], float]:
    """Run and print every model and resolution; the relative errors, by model and particles through the thickness."""
    errors = {}
    with tempfile.TemporaryDirectory() as folder:
        for model in ("springs", "hamiltonian"):
            for count in layers:
                scene = beam(model, count, duration)
                (row,) = mps.run_scene(scene, f"{folder}/{scene.name}", quiet=True).measurements
                errors[model, count] = row["error"]
                print(f"{model:12} {count:3} through the thickness: {row['value']:7.2f} rad/s ({row['error']:+.2%})")
    return errors


if __name__ == "__main__":
    if "--quick" in sys.argv:
        main(layers=(4, 8), duration=0.06)
    else:
        main()
