"""What the energies of a run may do: none can come from nowhere.

With the kinetic, elastic and contact energy E, the potential energy P, the work W that was put in and the energy D that
was dissipated, an exact solution keeps the balance E + P - W + D. Two bounds follow from it, for all times s <= t:

    gain      balance(t) - min_s balance(s)                    is 0, or below it where losses are not counted
    surplus   E(t) - max_s [E(0) + P(0) + W(s) - P(s)]         is at most 0: more was never available

Implicit steps count as dissipated whatever closes their balance, so that energy from nowhere shows there as a D that
falls. D is therefore taken as the largest so far.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields

from warp_mps.observers.records import numbers_of
from warp_mps.results.energy import Energy


@dataclass(frozen=True, kw_only=True)
class EnergyAccount:
    """Extremes of the energies of a run so far [J], in 2-D [J/m].

    Attributes:
        start: E + P - W at the start.
        least: Least balance.
        dissipated: Most that was dissipated.
        available: Most that was available to motion and deformation, by the start, work and potential energy.
        largest: Largest of E and of the work, either way.
        potential: Largest potential energy, either way.
    """

    start: float
    least: float
    dissipated: float
    available: float
    largest: float
    potential: float

    @classmethod
    def opened(cls, energy: Energy) -> EnergyAccount:
        """The account at the start of a run."""
        start = energy.total - energy.work
        return cls(
            start=start,
            least=energy.balance,
            dissipated=energy.dissipated,
            available=start + energy.work - energy.potential,
            largest=max(energy.exchanged, abs(energy.work)),
            potential=abs(energy.potential),
        )

    @classmethod
    def restored(cls, record: object) -> EnergyAccount:
        """The account that `record` gave.

        Raises:
            ValueError: It is not such a record.
        """
        names = [field.name for field in fields(cls)]
        return cls(**dict(zip(names, numbers_of(record, names), strict=True)))

    def record(self) -> dict[str, float]:
        """The account as JSON can hold it."""
        return asdict(self)

    def after(self, energy: Energy) -> EnergyAccount:
        """The account after a further moment."""
        dissipated = max(self.dissipated, energy.dissipated)
        return EnergyAccount(
            start=self.start,
            least=min(self.least, energy.total - energy.work + dissipated),
            dissipated=dissipated,
            available=max(self.available, self.start + energy.work - energy.potential),
            largest=max(self.largest, energy.exchanged, abs(energy.work)),
            potential=max(self.potential, abs(energy.potential)),
        )

    def gain(self, energy: Energy) -> float:
        """How far the balance of a moment, which the account holds already, is above the least [J]."""
        return energy.total - energy.work + self.dissipated - self.least

    def surplus(self, energy: Energy) -> float:
        """How much more motion and deformation hold at a moment, which the account holds, than was available [J]."""
        return energy.exchanged - self.available
