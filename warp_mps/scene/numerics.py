"""How a case is computed, and how it lies in its stage."""

from __future__ import annotations

from dataclasses import dataclass

from warp_mps.scene.motions import Vector

# by how much neighbour lists reach beyond the effective radius, in particle spacings
SKIN = 0.3


@dataclass(frozen=True, kw_only=True)
class Elasticity:
    """The elastic model and its choices, the same for every body of a scene.

    Attributes:
        model: ``hamiltonian``, accurate and for large strains, or ``springs``, the paper's.
        effective_radius: Effective radius r_e in units of the particle spacing [-].
        normalization: What the operators of ``springs`` are normalized by: ``lattice`` (n0 of a full lattice, as in
            eq. 14) or ``particle`` (the particle's own n_i, as in eq. 6).
        control: Strength with which ``hamiltonian`` resists zero-energy modes [-]. The default is the most accurate up
            to some 16 particles through a thickness; 0.65 to 0.7 shows the second order already from 8 on.
    """

    model: str = "hamiltonian"
    effective_radius: float = 1.5
    normalization: str = "lattice"
    control: float = 0.5


@dataclass(frozen=True, kw_only=True)
class Contact:
    """How bodies and walls repel each other where their faces meet; `warp_mps.elastic.contact.law` gives the law.

    Attributes:
        between: ``bodies`` (different bodies), ``all`` (also a body and itself), or ``none``. A body does not see
            itself across a gap that is narrower than two spacings.
        stiffness: Pressure of a small penetration in units of E penetration / l0 [-], E of the softer material.
        friction: Coefficient of Coulomb friction [-]; 0 is none.
    """

    between: str = "bodies"
    stiffness: float = 1.0
    friction: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Flow:
    """How fluids are computed, the same for all of a scene.

    Attributes:
        scheme: One of `FLUID_SCHEMES`: ``conservative`` (pair forces equal and opposite), ``corrected`` (gradients
            exact for linear pressures, with shifting), or the original MPS, ``koshizuka_oka``.
        effective_radius: Effective radius r_e in units of the particle spacing [-]; None is 3.1 in 2-D, 2.1 in 3-D.
        negative_pressure: ``clipped`` where water would have to pull, or ``allowed``.
        tolerance: True residual of the pressure solve, relative to its right-hand side [-].
        courant: Largest time step in units of l0 / u, u the speed of the fastest particle [-].
        domain: Lowest and highest corner of the region that is computed [m]; particles that leave it are counted and
            left out. None is a wide box about all particles.
        periodic: Axes along which the domain repeats itself (0 is x).
    """

    scheme: str = "conservative"
    effective_radius: float | None = None
    negative_pressure: str = "clipped"
    tolerance: float = 1e-4
    courant: float = 0.2
    domain: tuple[Vector, Vector] | None = None
    periodic: tuple[int, ...] = ()

    def radius(self, dimension: int) -> float:
        """Effective radius in units of the particle spacing [-], in 2 or 3 dimensions."""
        return self.effective_radius or (3.1 if dimension == 2 else 2.1)


@dataclass(frozen=True, kw_only=True)
class StageFrame:
    """How the scene lies in the stage that it was read from, and in which results are written.

    Attributes:
        axes: The stage's axes along which the scene's axes lie: ``xyz`` in 3-D, and ``xy``, ``xz`` or ``yz`` in 2-D.
        up_axis: Up axis of the stage, ``Y`` or ``Z``.
        meters_per_unit: Length of the stage's unit [m].
        kilograms_per_unit: Mass of the stage's unit [kg].
    """

    axes: str = "xy"
    up_axis: str = "Y"
    meters_per_unit: float = 1.0
    kilograms_per_unit: float = 1.0
