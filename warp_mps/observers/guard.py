"""The guard: stops a run that has diverged, by NaN or by growing energy."""

from __future__ import annotations

import numpy as np

from warp_mps.errors import RunError
from warp_mps.observers.base import Observer, View

# The energy balance may grow by this part of the largest kinetic, elastic and contact energy, or of the work.
ALLOWED_GROWTH = 0.1
# Positions have a relative rounding of 1e-7 in single precision; over a run, the potential energy of a scene at rest
# drifts by some tens of that.
ROUNDING = 1e-5


class Guard(Observer):
    """Stops a run when a position or velocity is NaN or infinite, or when its energy balance grows.

    The energy balance (held, less work, plus dissipated) is constant in an exact solution. An unstable step makes it
    grow exponentially, and then it soon is as large as the kinetic and elastic energy themselves; the error of a good
    step stays a small part of them. A scene at rest has neither, and there only rounding is allowed for.

    Args:
        every: Steps between two looks.
        time_step: Time step of the run [s], for the message.
        energy: Whether to check the energy; in statics its balance is only as exact as the load steps are small, and
            the solver reports by itself where it fails.
        body_force: Largest body force per mass on fluids at the start, beside gravity [m/s^2].
    """

    def __init__(self, *, every: int, time_step: float, energy: bool = True, body_force: float = 0.0) -> None:
        self.every = every
        self._look_at_energy = energy
        self._time_step, self._body_force = time_step, body_force
        self._start: float | None = None
        self._largest = 0.0
        self._potential = 0.0

    def observe(self, view: View) -> None:
        """Look at positions, velocities and energies.

        Raises:
            RunError: A position or velocity is not finite, or the energy balance has grown.
        """
        self._check_finite(view)
        if self._look_at_energy:
            self._check_energy(view)

    def _check_finite(self, view: View) -> None:
        for name, values in (("position", view.positions), ("velocity", view.velocities)):
            bad = np.flatnonzero(~np.isfinite(values).all(axis=1))
            if len(bad):
                place = view.particles.describe(int(bad[0]))
                raise RunError(f"the {name} of {place} is not finite at {self._when(view)}; {self._cause(view)}")

    def _check_energy(self, view: View) -> None:
        energy = view.energy
        if self._start is None:
            self._start = energy.balance
            self._largest = _slack(view, self._body_force)
        self._largest = max(self._largest, energy.exchanged, abs(energy.work))
        self._potential = max(self._potential, abs(energy.potential))
        growth = energy.balance - self._start
        if growth > ALLOWED_GROWTH * self._largest + ROUNDING * self._potential or not np.isfinite(growth):
            unit = "J/m" if view.scene.dimension == 2 else "J"
            fastest = int(np.argmax(np.linalg.norm(view.velocities, axis=1)))
            speed = float(np.linalg.norm(view.velocities[fastest]))
            raise RunError(
                f"the energy balance has grown by {growth:.3g} {unit} (largest kinetic, elastic and contact "
                f"energy or work: {self._largest:.3g} {unit}) at {self._when(view)}; the fastest particle is "
                f"{view.particles.describe(fastest)} at {speed:.3g} m/s; {self._cause(view)}"
            )

    def _when(self, view: View) -> str:
        return f"{view.time:.6g} s (step {view.step})"

    def _cause(self, view: View) -> str:
        if view.particles.liquid:
            return "the flow has become unstable; a smaller Courant number or tolerance may help"
        return f"the time step of {self._time_step:.3g} s is probably too large"


def _slack(view: View, body_force: float) -> float:
    """Energy by which a fluid at rest may drift: its particles settle by parts of a spacing under their weight."""
    particles = view.particles
    if not particles.liquid:
        return 0.0
    fluid = slice(particles.count - particles.liquid, None)
    gravity = float(np.linalg.norm(view.scene.gravity)) if len(view.scene.gravity) else 0.0
    return (gravity + body_force) * float(np.sum(particles.masses[fluid] * particles.spacings[fluid])) / ALLOWED_GROWTH
