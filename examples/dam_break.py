"""A dam break: the position of the front, and the force on the far wall.

Physics: a column of water, 0.146 m wide and twice as high, is released at one end of a tank of 0.584 m.
Reference: the position of the front after 0.066, 0.133 and 0.2 s in the experiment of Koshizuka and Oka (1996): 0.183,
0.276 and 0.382 m. Computations without friction, and without a barrier that is lifted, run ahead of it.
Run time: 4 s on one core, 1 s with --quick (12 instead of 24 particles across the column).
Command: python examples/dam_break.py [--quick]
Expect: fronts 6, 11 and 17 % ahead (2, 9, 17 % with --quick), an impact after 0.26 s, and no gain of energy.
"""

from __future__ import annotations

import sys
import tempfile

import numpy as np

import warp_mps as mps

# --- the case

WIDTH, HEIGHT, TANK = 0.146, 0.292, 0.584  # [m]
# time [s]: front [m]
EXPERIMENT = {0.066: 0.183, 0.133: 0.276, 0.200: 0.382}


def dam(across: int) -> mps.Scene:
    """The column with a number of particles across it."""
    l0 = WIDTH / across
    return mps.Scene(
        name="dam_break",
        fluids=(mps.Fluid(name="water", shape=mps.Box.from_corners((0.0, 0.0), (WIDTH, HEIGHT)), spacing=l0),),
        walls=mps.tank((0.0, 0.0), (TANK, 0.45), l0, layers=4),
        probes=(
            mps.Probe(name="front", body="water", quantity="highest"),
            mps.Probe(name="push", body="right", quantity="contact_force"),
        ),
        gravity=(0.0, -9.81),
        duration=0.4,
        frame_rate=100.0,
        sample_rate=1000.0,
    )


# --- the numbers


def main(quick: bool = False) -> dict[str, float]:
    """Run it; the relative lead of the front at each time, the time of the impact [s], and the gain of energy [-]."""
    with tempfile.TemporaryDirectory() as folder:
        mps.run_scene(dam(12 if quick else 24), folder, quiet=True)
        history = mps.read_history(f"{folder}/probes.csv")
    times, front, push = history.times, history.probe("front", 0), history.probe("push", 0)
    leads = {f"{time:g} s": float(np.interp(time, times, front)) / known - 1.0 for time, known in EXPERIMENT.items()}
    for time, known in EXPERIMENT.items():
        print(f"front after {time:.3f} s: {np.interp(time, times, front):.3f} m, experiment {known:.3f} m")
    struck = float(times[np.argmax(push > 0.02 * push.max())])
    # energies are relative to the start, in units of the potential energy above the floor
    totals = np.array([energy.kinetic + energy.potential for energy in history.energies()])
    totals /= 1000.0 * 9.81 * WIDTH * HEIGHT**2 / 2.0
    print(f"impact on the wall after {struck:.3f} s; largest force {push.max():.0f} N/m")
    print(f"the water loses {-totals[-1]:.1%} of its energy, and never gains more than {totals.max():.2%}")
    return {**leads, "struck": struck, "gain": float(totals.max())}


if __name__ == "__main__":
    main(quick="--quick" in sys.argv)
