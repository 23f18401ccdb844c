"""The guard: stops a run that has diverged, by NaN or by energy that comes from nowhere."""

from __future__ import annotations

import math

import numpy as np

from warp_mps.errors import RunError
from warp_mps.observers.base import Observer, View
from warp_mps.observers.causes import plain_cause, probable_cause
from warp_mps.observers.energy_account import EnergyAccount
from warp_mps.results.energy import ENERGY_NAMES, Energy

# What the accounts are of: all particles, and bodies in water alone.
ALL, BODIES = "all", "bodies"
# The energy balance may grow by this part of the largest kinetic, elastic and contact energy, or of the work, that was
# exchanged while it grew.
ALLOWED_GROWTH = 0.1
# Positions have a relative rounding of 1e-7 in single precision; over a run, the potential energy of a scene at rest
# drifts by some tens of that, and the sums of work and of what was dissipated by as much.
ROUNDING = 1e-5
# Water at rest settles and swells, and its particles go round. Measured from 2 to 80 rows, in tanks that stand, sway
# and heave, after dam breaks, and in all shipped cases: the balance rises by up to 0.36/N and 0.045 times weight times
# spacing at N rows, the kinetic energy by 0.0025 beyond what was available, or by 0.01 where walls do a hundred times
# that work. Schemes that stir water give 0.05 to 0.16, and 0.01 to 0.03. Shares of weight times spacing^2/depth,
# spacing, and depth:
SETTLING = (0.2, 0.05, 5e-4)
STIRRING = (0.0, 5e-3, 1e-4)
# A body that moves through water leaves a gap behind it, and the water above is lifted by it. Blocks of 100 to 5000
# kg/m^3, 4 by 3 and 2 by 4 spacings, that rise, sink and are dropped in 8 rows of water make the balance rise by up to
# 1.5 times the weight of the water before their largest face, times a spacing; at most by the weight of all water.
GAP = 2.0


class Guard(Observer):
    """Stops a run when positions, velocities or energies are not finite, or when energy comes from nowhere.

    An unstable step makes energy grow exponentially, and then it soon is as large as the kinetic and elastic energy
    themselves; the error of a good step stays a small part of them. A scene at rest has neither, and there only
    rounding is allowed for, and water that settles. See `warp_mps.observers.energy_account`.

    Args:
        every: Steps between two looks.
        time_step: Time step of the run [s], for the message.
        limit: Stability limit of the time step [s], likewise.
        closed: Whether fluids start without a free surface, likewise.
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
        closed: bool = False,
        energy: bool = True,
        body_force: float = 0.0,
    ) -> None:
        self.every = every
        self._look_at_energy = energy
        self._steps: dict[str, float] = {"time_step": time_step, "limit": limit}
        self._closed, self._body_force = closed, body_force
        self._accounts: dict[str, EnergyAccount] = {}
        # largest gain that only the gap behind bodies allows, and what is said of it
        self._doubted, self._doubt = 0.0, ""

    @property
    def remarks(self) -> list[str]:
        """A line where the energy has grown by more than that of water at rest, though the guard has let it pass."""
        return [self._doubt] if self._doubt else []

    def observe(self, view: View) -> None:
        """Look at positions, velocities and energies.

        Raises:
            RunError: A position, a velocity or an energy is not finite, or energy has come from nowhere.
        """
        if (found := find_not_finite(view)) is not None:
            raise RunError(f"{found}; {self._cause(view)}")
        if self._look_at_energy:
            self._check_energy(view)

    def record(self) -> dict[str, dict[str, float]]:
        """What it has seen so far, as JSON can hold it, for a checkpoint."""
        return {name: account.record() for name, account in self._accounts.items()}

    def restore(self, record: object) -> None:
        """Go on from what `record` gave, so that a run in parts is judged like one that was never interrupted.

        Raises:
            ValueError: It is not such a record.
        """
        if not isinstance(record, dict) or (self._look_at_energy and ALL not in record):
            raise ValueError(f"what the guard has seen is {record!r}, must be numbers by name")
        self._accounts = {str(name): EnergyAccount.restored(account) for name, account in record.items()}

    def _check_energy(self, view: View) -> None:
        # the balance of bodies alone closes without what water needs
        if view.energy_of_bodies is not None:
            self._judge(view, BODIES, view.energy_of_bodies)
        settling, stirring, gap = _slack(view, self._body_force)
        self._judge(view, ALL, view.energy, settling=settling, stirring=stirring, gap=gap)

    def _judge(
        self,
        view: View,
        part: str,
        energy: Energy,
        *,
        settling: float = 0.0,
        stirring: float = 0.0,
        gap: float = 0.0,
    ) -> None:
        """Judge the energies of all particles, or of the bodies."""
        before = self._accounts.get(part)
        account = before.after(energy) if before else EnergyAccount.opened(energy)
        rounding, unit = ROUNDING * account.scale, "J/m" if view.scene.dimension == 2 else "J"
        of_part = "" if part == ALL else f" of the {part}"
        gain, surplus = account.gain(energy), account.surplus(energy)
        finding = (
            f"the energy balance{of_part} has grown by {gain:.3g} {unit} since it was least (largest kinetic, elastic "
            f"and contact energy or work since then: {account.exchanged:.3g} {unit})"
        )
        allowed = ALLOWED_GROWTH * account.exchanged + rounding + settling
        if gain > allowed + gap:
            self._stop(view, part, finding)
        if gain > max(allowed, self._doubted):
            cause = "moving bodies lift the water by the gaps that they leave behind, less with a smaller spacing"
            self._doubted, self._doubt = gain, f"{finding} at {_moment(view)}: {cause}"
        if surplus > ALLOWED_GROWTH * account.most + rounding + stirring + gap:
            self._stop(
                view,
                part,
                f"the kinetic, elastic and contact energy{of_part} of {energy.exchanged:.3g} {unit} is {surplus:.3g} "
                f"{unit} more than the start, work and potential energy have given",
            )
        # the last moment of a run may lie off the grid, where a run that goes on from there would not look
        if view.step % self.every == 0:
            self._accounts[part] = account

    def _stop(self, view: View, part: str, finding: str) -> None:
        speeds = np.linalg.norm(view.velocities[: None if part == ALL else view.particles.elastic], axis=1)
        fastest = int(np.argmax(speeds))
        cause = None if part == ALL else "the bodies have become unstable in the water; a smaller CFL number may help"
        raise RunError(
            f"{finding} at {_moment(view)}; the fastest particle is {view.particles.describe(fastest)} at "
            f"{float(speeds[fastest]):.3g} m/s; {self._cause(view, cause)}"
        )

    def _cause(self, view: View, otherwise: str | None = None) -> str:
        """The probable cause, or another one unless it is a plain one."""
        if otherwise is None:
            return probable_cause(view, **self._steps, closed=self._closed)
        return plain_cause(view, **self._steps) or otherwise


def find_not_finite(view: View) -> str | None:
    """The first position, velocity or energy that is NaN or infinite, and when; None if there is none."""
    for name, values in (("position", view.positions), ("velocity", view.velocities)):
        bad = np.flatnonzero(~np.isfinite(values).all(axis=1))
        if len(bad):
            return f"the {name} of {view.particles.describe(int(bad[0]))} is not finite at {_moment(view)}"
    for name, label in ENERGY_NAMES.items():
        if not np.isfinite(getattr(view.energy, name)):
            return f"the {label}{' energy' * (name == 'dissipated')} is not finite at {_moment(view)}"
    return None


def _moment(view: View) -> str:
    return f"{view.time:.6g} s (step {view.step})"


def _slack(view: View, body_force: float) -> tuple[float, float, float]:
    """What a fluid may gain [J]: its balance, and its kinetic energy, as it settles, and both by gaps behind bodies."""
    particles = view.particles
    if not particles.liquid:
        return 0.0, 0.0, 0.0
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
    density = float(masses[0]) / float(sizes[0]) ** view.scene.dimension
    pressure = density * (pull + body_force) * depth
    gap = min(GAP * pressure * float(sizes.max()) * _faces(view), terms[1])
    settling, stirring = (float(np.dot(shares, terms)) for shares in (SETTLING, STIRRING))
    return settling, stirring, gap


def _faces(view: View) -> float:
    """Area of the largest faces of the boxes about what moves through water, in 2-D their lengths [m^2].

    These are bodies, and walls that move between others; a tank that moves as a whole leaves no gap.
    """
    particles, bodies, walls = view.particles, view.scene.bodies, view.scene.walls
    moving = [wall.moves for wall in walls]
    ranges = particles.ranges[: len(bodies) + len(walls)]
    total = 0.0
    for (first, end), counts in zip(ranges, [*[True] * len(bodies), *moving], strict=True):
        if counts and (first < particles.elastic or not all(moving)):
            sizes = np.ptp(particles.positions[first:end], axis=0) + particles.spacings[first:end].max()
            total += float(np.prod(np.sort(sizes)[1:]))
    return total
