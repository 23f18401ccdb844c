"""Particles: shapes filled on a lattice, with masses and initial velocities. Knows neither Warp nor USD."""
