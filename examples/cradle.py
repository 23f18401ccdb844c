"""Two rubber balls collide head on: the moving one stops, and the other one moves on.

Physics: balls of 40 mm diameter (E 1 MPa, nu 0.45, 1000 kg/m^3) in three dimensions. One meets the other, which is at
rest, at 2 m/s, head on and without friction.
Reference: equal masses exchange their velocities; momentum and energy are conserved. The vibration of the balls
after the impact takes what is missing from a restitution of one.
Run time: 3 s on one core, 1 s with --quick (5 instead of 8 particles over the radius).
Command: python examples/cradle.py [--quick]
Expect: a restitution of 0.96, a momentum error of 1e-12 and an energy drift of 1e-4.
"""

from __future__ import annotations

import sys
import tempfile

import numpy as np

import warp_mps as mps

# --- the case

RADIUS, SPEED = 0.02, 2.0  # [m, m/s]
E, NU, RHO = 1e6, 0.45, 1000.0


def pair(layers: int) -> mps.Scene:
    """Two balls with a number of particles over the radius, a spacing apart."""
    l0 = RADIUS / layers
    rubber = mps.Material(density=RHO, youngs_modulus=E, poissons_ratio=NU)

    def ball(name: str, x: float, speed: float) -> mps.Body:
        shape = mps.Sphere(RADIUS, center=(x, 0.0, 0.0))
        return mps.Body(name=name, shape=shape, material=rubber, spacing=l0, velocity=(speed, 0.0, 0.0))

    return mps.Scene(
        name="cradle",
        dimension=3,
        bodies=(ball("flying", -RADIUS - l0, SPEED), ball("standing", RADIUS, 0.0)),
        probes=tuple(
            mps.Probe(name=f"{body}_{what}", body=body, quantity=what)
            for body in ("flying", "standing")
            for what in ("velocity", "contact_force")
        ),
        gravity=(0.0, 0.0, 0.0),
        duration=0.03,
        frame_rate=500.0,
        sample_rate=5000.0,
    )


# --- the collision


def main(quick: bool = False) -> dict[str, float]:
    """Run it; the restitution, and the relative changes of momentum and energy."""
    with tempfile.TemporaryDirectory() as folder:
        summary = mps.run_scene(pair(5 if quick else 8), folder, quiet=True)
        history = mps.read_history(f"{folder}/probes.csv")
    flying, standing = (history.probe(f"{name}_velocity", 0) for name in ("flying", "standing"))
    force = np.abs(history.probe("standing_contact_force", 0))
    touching = history.times[force > 1e-3 * force.max()]
    result = {
        "restitution": float(standing[-1] - flying[-1]) / SPEED,
        "momentum": float(np.abs(flying + standing - SPEED).max()) / SPEED,
        "energy": abs(summary.energy["drift"] or 0.0),
    }
    print(f"velocities after: {flying[-1]:+.4f} and {standing[-1]:+.4f} m/s; restitution {result['restitution']:.4f}")
    print(f"contact of {1e3 * (touching[-1] - touching[0]):.2f} ms with {force.max():.1f} N at most")
    print(f"relative error of the momentum {result['momentum']:.0e}, of the energy {result['energy']:.0e}")
    return result


if __name__ == "__main__":
    main(quick="--quick" in sys.argv)
