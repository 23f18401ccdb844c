"""Constants of a run of fluids as its kernels take them."""

import functools
from typing import Any

import warp as wp

from warp_mps.core.types import NumericTypes


@functools.cache
def fluid_constants_struct(types: NumericTypes) -> Any:
    """The Warp struct `FluidConstants` of a dimension and precision; `warp_mps.fluid.model` fills it once a run."""
    real, vec = types.real, types.vec

    @wp.struct
    class FluidConstants:
        """Constants of a run; see `warp_mps.fluid.model.FluidModel` and `warp_mps.fluid.operator_constants`.

        Attributes:
            walls: Number of wall particles w, the first ones of all n [-].
            markers: Number of markers of elastic bodies, the first ones of the wall particles [-].
            scheme: Discretization, one of `warp_mps.fluid.schemes`.
            clip: 1 if negative pressures are set to 0, else 0.
            midpoint: 1 if the pressure is evaluated at the midpoint of a step, 0 if at predicted positions at its end.
            period: Period along each axis [m], 0 where there is none.
            low: Lowest corner of the domain [m].
            high: Its highest corner [m].
            radius: Effective radius r_e [m].
            spacing: Particle spacing l0 [m].
            number_density: Number density n0 of a full lattice [-].
            smooth_density: Smooth number density S0 of a full lattice [-].
            lattice_neighbours: Number of neighbours in a full lattice [-].
            divergence: Factor of the divergence [m].
            laplacian: Factor of the Laplacian [1/m^2].
            gradient: Factor of the scheme's gradient [-].
            still_radius: Radius of the force's pair weight in water at rest [m]; see `warp_mps.fluid.still_water`.
            still_gradient: Factor of the gradient with that radius [-].
            missing_first: Mean height of what is missing above the uppermost row of a lattice [l0].
            missing_second: What it is more above the second row [l0].
            head: rho |g| l0 [Pa].
            beyond_first: Factor b1 of the part beyond a free surface [-].
            beyond_second: Factor b2 of the part beyond a free surface [-].
            density: Density rho [kg/m^3].
            volume: Volume of a fluid particle l0^d [m^d].
            mass: Mass of a fluid particle rho l0^d [kg], in 2-D [kg/m].
            viscous_factor: Kinematic viscosity nu times the factor of the Laplacian [1/s].
            gravity: Acceleration of gravity g [m/s^2].
            relaxation_time: Time tau in which the density is restored [s].
            collision_distance: Distance below which fluid particles collide [m].
        """

        walls: wp.int32
        markers: wp.int32
        scheme: wp.int32
        clip: wp.int32
        midpoint: wp.int32
        period: vec
        low: vec
        high: vec
        radius: real
        spacing: real
        number_density: real
        smooth_density: real
        lattice_neighbours: real
        divergence: real
        laplacian: real
        gradient: real
        still_radius: real
        still_gradient: real
        missing_first: real
        missing_second: real
        head: real
        beyond_first: real
        beyond_second: real
        density: real
        volume: real
        mass: wp.float64
        viscous_factor: real
        gravity: vec
        relaxation_time: real
        collision_distance: real

    return FluidConstants
