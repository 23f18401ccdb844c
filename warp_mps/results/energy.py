"""The energies of a scene at one moment, and the balance that an exact solution conserves."""

from __future__ import annotations

from dataclasses import dataclass

ENERGY_NAMES = {
    "kinetic": "kinetic energy",
    "elastic": "elastic energy",
    "contact": "contact energy",
    "potential": "potential energy",
    "work": "work",
    "dissipated": "dissipated",
}
"""Fields of :class:`Energy` and their labels, in the order of the columns of probes.csv."""


@dataclass(frozen=True, kw_only=True)
class Energy:
    """Energies of all particles [J], in 2-D per metre of depth [J/m].

    Attributes:
        kinetic: Of translation and of the particles' rotation.
        elastic: Stored in the bodies.
        contact: Stored in contacts between particles.
        potential: In gravity, measured from any fixed level.
        work: Done so far on the particles by loads, body forces, moving supports and walls.
        dissipated: Taken out so far by damping, friction and viscous materials of the bodies, counted in every step.
            Losses of fluids by viscosity and impacts are not counted.
    """

    kinetic: float
    elastic: float
    contact: float
    potential: float
    work: float
    dissipated: float

    @property
    def total(self) -> float:
        """Energy that the particles hold: kinetic + elastic + contact + potential."""
        return self.kinetic + self.elastic + self.contact + self.potential

    @property
    def exchanged(self) -> float:
        """Energy that motion and deformation hold: kinetic + elastic + contact."""
        return self.kinetic + self.elastic + self.contact

    @property
    def balance(self) -> float:
        """Energy held, less the work put in, plus what was dissipated: constant in an exact solution."""
        return self.total - self.work + self.dissipated
