"""The guard: stops a run that has diverged, by NaN or by energy that comes from nowhere."""

from __future__ import annotations

import math

import numpy as np

from warp_mps.errors import RunError
from warp_mps.observers.base import Observer, View
from warp_mps.observers.causes import probable_cause
from warp_mps.observers.energy_account import EnergyAccount
from warp_mps.results.energy import ENERGY_NAMES

# The energy balance may grow by this part of the largest kinetic, elastic and contact energy, or of the work, that was
# exchanged while it grew.
ALLOWED_GROWTH = 0.1
# Positions have a relative rounding of 1e-7 in single precision; over a run, the potential energy of a scene at rest
# drifts by some tens of that, and the sums of work and of what was dissipated by as much.
ROUNDING = 1e-5
# Water at rest settles and swells, and its particles go round. Measured from 3 to 80 rows, in tanks that stand, sway
# and heave, and in all shipped cases: the balance rises by up to 0.2/N and 0.045 times weight times spacing at N rows,
# the kinetic energy by 0.0025 beyond what was available, or by 0.01 where walls do a hundred times that work. Schemes
# that stir water give 0.05 to 0.16, and 0.01 to 0.03. Shares of weight times spacing^2/depth, spacing, and depth:
SETTLING = (0.1, 0.05, 5e-4)
STIRRING = (0.0, 5e-3, 1e-4)


class Guard(Observer):
    """Stops a run when positions, velocities or energies are not finite, or when energy comes from nowhere.

    An unstable step makes energy grow exponentially, and then it soon is as large as the kinetic and elastic energy
    themselves; the error of a good step stays a small part of them. A scene at rest has neither, and there only
    rounding is allowed for, and water that settles. See `warp_mps.observers.energy_account`.

    Args:
        every: Steps between two looks.
        time_step: Time step of the run [s], for the message.
        limit: Stability limit of the time step [s], likewise.
        energy: Whether to check the energy; in statics its balance is only as exact as the load steps are small, and
            the solver reports by itself where it fails.
        body_force: Largest body force per mass on fluids at the start, beside gravity [m/s^2].
    """

    def __init__(
        self,
        *,
        every: int,
        time_step: float,
        limit: float = math.inf,
        energy: bool = True,
        body_force: float = 0.0,
    ) -> None:
        self.every = every
        self._look_at_energy = energy
        self._time_step, self._limit, self._body_force = time_step, limit, body_force
        self._account: EnergyAccount | None = None

    def observe(self, view: View) -> None:
        """Look at positions, velocities and energies.

        Raises:
            RunError: A position, a velocity or an energy is not finite, or energy has come from nowhere.
        """
        self._check_finite(view)
        if self._look_at_energy:
            self._check_energy(view)

    def record(self) -> dict[str, float]:
        """What it has seen so far, as JSON can hold it, for a checkpoint."""
        return self._account.record() if self._account else {}

    def restore(self, record: object) -> None:
        """Go on from what `record` gave, so that a run in parts is judged like one that was never interrupted.

        Raises:
            ValueError: It is not such a record.
        """
        self._account = EnergyAccount.restored(record) if self._look_at_energy else None

    def _check_finite(self, view: View) -> None:
        for name, values in (("position", view.positions), ("velocity", view.velocities)):
            bad = np.flatnonzero(~np.isfinite(values).all(axis=1))
            if len(bad):
                place = view.particles.describe(int(bad[0]))
                raise RunError(f"the {name} of {place} is not finite at {_moment(view)}; {self._cause(view)}")
        for name, label in ENERGY_NAMES.items():
            value = getattr(view.energy, name)
            if not np.isfinite(value):
                what = f"{label} energy" if name == "dissipated" else label
                raise RunError(f"the {what} is not finite at {_moment(view)}; {self._cause(view)}")

    def _check_energy(self, view: View) -> None:
        energy = view.energy
        account = self._account.after(energy) if self._account else EnergyAccount.opened(energy)
        rounding = ROUNDING * account.scale
        settling, stirring = _slack(view, self._body_force)
        gain, surplus = account.gain(energy), account.surplus(energy)
        if gain > ALLOWED_GROWTH * account.exchanged + rounding + settling:
            unit = _unit(view)
            self._stop(
                view,
                f"the energy balance has grown by {gain:.3g} {unit} since it was least (largest kinetic, elastic and "
                f"contact energy or work since then: {account.exchanged:.3g} {unit})",
            )
        if surplus > ALLOWED_GROWTH * account.most + rounding + stirring:
            unit = _unit(view)
            self._stop(
                view,
                f"the kinetic, elastic and contact energy of {energy.exchanged:.3g} {unit} is {surplus:.3g} {unit} "
                "more than the start, work and potential energy have given",
            )
        # the last moment of a run may lie off the grid, where a run that goes on from there would not look
        if view.step % self.every == 0:
            self._account = account

    def _stop(self, view: View, finding: str) -> None:
        fastest = int(np.argmax(np.linalg.norm(view.velocities, axis=1)))
        speed = float(np.linalg.norm(view.velocities[fastest]))
        raise RunError(
            f"{finding} at {_moment(view)}; the fastest particle is {view.particles.describe(fastest)} at "
            f"{speed:.3g} m/s; {self._cause(view)}"
        )

    def _cause(self, view: View) -> str:
        return probable_cause(view, time_step=self._time_step, limit=self._limit)


def _moment(view: View) -> str:
    return f"{view.time:.6g} s (step {view.step})"


def _unit(view: View) -> str:
    return "J/m" if view.scene.dimension == 2 else "J"


def _slack(view: View, body_force: float) -> tuple[float, float]:
    """What the balance, and the kinetic energy, of a fluid at rest may grow by, as its particles settle [J]."""
    particles = view.particles
    if not particles.liquid:
        return 0.0, 0.0
    fluid = slice(particles.count - particles.liquid, None)
    masses, places = particles.masses[fluid], particles.positions[fluid]
    gravity = np.asarray(view.scene.gravity, float)
    pull = float(np.linalg.norm(gravity))
    # without gravity, body forces may act along any axis
    heights = places @ (gravity / pull) if pull else places
    depth = max(float(np.ptp(heights, axis=0).max()), float(particles.spacings[fluid].max()))
    sizes = particles.spacings[fluid]
    weight = (pull + body_force) * masses
    terms = [float(np.sum(weight * lengths)) for lengths in (sizes**2 / depth, sizes, np.full_like(sizes, depth))]
    settling, stirring = (float(np.dot(shares, terms)) for shares in (SETTLING, STIRRING))
    return settling, stirring
