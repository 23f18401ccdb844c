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
        dissipated: Most that was dissipated.
        available: Most that was available to motion and deformation, by the start, work and potential energy.
        most: Largest of E and of the work, either way.
        scale: Largest of all energies, either way.
        least: Least balance.
        work: Work up to the last time when the balance was least.
        exchanged: Largest of E, and of the work beside that, since then.
    """

    start: float
    dissipated: float
    available: float
    most: float
    scale: float
    least: float
    work: float
    exchanged: float

    @classmethod
    def opened(cls, energy: Energy) -> EnergyAccount:
        """The account at the start of a run."""
        start = energy.total - energy.work
        return cls(
            start=start,
            dissipated=energy.dissipated,
            available=start + energy.work - energy.potential,
            most=max(energy.exchanged, abs(energy.work)),
            scale=_scale(energy),
            least=energy.balance,
            work=energy.work,
            exchanged=energy.exchanged,
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
        balance = energy.total - energy.work + dissipated
        falls = balance <= self.least
        work = energy.work if falls else self.work
        return EnergyAccount(
            start=self.start,
            dissipated=dissipated,
            available=max(self.available, self.start + energy.work - energy.potential),
            most=max(self.most, energy.exchanged, abs(energy.work)),
            scale=max(self.scale, _scale(energy)),
            least=min(self.least, balance),
            work=work,
            exchanged=max(0.0 if falls else self.exchanged, energy.exchanged, abs(energy.work - work)),
        )

    def gain(self, energy: Energy) -> float:
        """How far the balance of a moment, which the account holds already, is above the least [J]."""
        return energy.total - energy.work + self.dissipated - self.least

    def surplus(self, energy: Energy) -> float:
        """How much more motion and deformation hold at a moment, which the account holds, than was available [J]."""
        return energy.exchanged - self.available


def _scale(energy: Energy) -> float:
    return max(energy.exchanged, abs(energy.potential), abs(energy.work), abs(energy.dissipated))
