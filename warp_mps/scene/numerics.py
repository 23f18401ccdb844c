"""Numerical models and their parameters, and the frame of the stage."""

from __future__ import annotations

from dataclasses import dataclass, field

from warp_mps.scene.choices import (
    ContactName,
    ElasticModelName,
    FluidSchemeName,
    NegativePressureName,
    NormalizationName,
    StageAxesName,
    UpAxisName,
)
from warp_mps.scene.fields import attribute, described
from warp_mps.scene.motions import Vector
from warp_mps.scene.record import Record

# reach of neighbour lists beyond the effective radius, in particle spacings
SKIN = 0.3


@described
@dataclass(frozen=True, kw_only=True)
class Elasticity(Record):
    """The elastic model and its parameters, the same for every body of a scene."""

    model: ElasticModelName = field(default="hamiltonian", metadata=attribute("mps:elasticModel"))
    """Elastic model: `hamiltonian`, accurate and for large strains, or `springs`, that of the paper."""
    effective_radius: float = field(default=1.5, metadata=attribute("mps:effectiveRadius", minimum=1.1, maximum=5.0))
    """Effective radius r_e in particle spacings."""
    normalization: NormalizationName = field(default="lattice", metadata=attribute("mps:normalization"))
    """What the operators of `springs` are normalized by: `lattice` (n0 of a full lattice, as in eq. 14) or `particle`
    (the particle's own n_i, as in eq. 6)."""
    control: float = field(default=0.5, metadata=attribute("mps:control", minimum=0.0, maximum=10.0))
    """Hourglass control of `hamiltonian`: resistance to zero-energy modes. The default is the most accurate up to some
    16 particles through a thickness; 0.65 to 0.7 shows the second order already from 8 on."""


@described
@dataclass(frozen=True, kw_only=True)
class Contact(Record):
    """How bodies and walls repel each other where their faces meet; `warp_mps.elastic.contact.law` gives the law."""

    between: ContactName = field(default="bodies", metadata=attribute("mps:contact"))
    """Contact between different bodies (`bodies`), also of a body with itself (`all`), or none. A body does not touch
    itself across a gap that is narrower than two spacings."""
    stiffness: float = field(default=1.0, metadata=attribute("mps:contactStiffness", above=0.0))
    """Pressure of a small penetration in units of E penetration / spacing, E of the softer material."""
    friction: float = field(default=0.0, metadata=attribute("mps:friction", minimum=0.0))
    """Coefficient of Coulomb friction of contacts."""


@described
@dataclass(frozen=True, kw_only=True)
class Flow(Record):
    """How fluids are computed, the same for all of a scene."""

    scheme: FluidSchemeName = field(default="conservative", metadata=attribute("mps:fluidScheme"))
    """Fluids: pair forces that are equal and opposite (`conservative`), gradients exact for linear pressures with
    particle shifting (`corrected`), or the original MPS method (`koshizuka_oka`)."""
    effective_radius: float | None = field(
        default=None, metadata=attribute("mps:fluidEffectiveRadius", minimum=1.5, maximum=4.1)
    )
    """Fluids: effective radius r_e in particle spacings; if not given, 3.1 in 2-D and 2.1 in 3-D."""
    negative_pressure: NegativePressureName = field(default="clipped", metadata=attribute("mps:negativePressure"))
    """Fluids: whether negative pressures are clipped, or the liquid can bear tension."""
    tolerance: float = field(default=1e-4, metadata=attribute("mps:pressureTolerance", above=0.0, maximum=0.1))
    """Fluids: true residual of the pressure Poisson equation, relative to its right-hand side."""
    courant: float = field(default=0.2, metadata=attribute("mps:fluidCourant", above=0.0, maximum=1.0))
    """Fluids: CFL number, the largest time step in units of spacing / speed of the fastest particle."""
    domain: tuple[Vector, Vector] | None = field(default=None, metadata=attribute(unit="m"))
    """Lowest and highest corner of the region that is computed; particles that leave it are counted and left out. None
    is a wide box about all particles."""
    periodic: tuple[int, ...] = field(default=(), metadata=attribute("mps:periodicAxes", axes="stage"))
    """Fluids: axes along which the domain is periodic."""

    def radius(self, dimension: int) -> float:
        """Effective radius in units of the particle spacing [-], in 2 or 3 dimensions."""
        return self.effective_radius or (3.1 if dimension == 2 else 2.1)


@described
@dataclass(frozen=True, kw_only=True)
class StageFrame(Record):
    """How the scene lies in the stage that it was read from, and in which results are written."""

    axes: StageAxesName = "xy"
    """The stage's axes along which the scene's axes lie: ``xyz`` in 3-D, and ``xy``, ``xz`` or ``yz`` in 2-D."""
    up_axis: UpAxisName = "Y"
    """Up axis of the stage, ``Y`` or ``Z``."""
    meters_per_unit: float = field(default=1.0, metadata=attribute(unit="m", above=0.0))
    """Length of the stage's unit."""
    kilograms_per_unit: float = field(default=1.0, metadata=attribute(unit="kg", above=0.0))
    """Mass of the stage's unit."""
