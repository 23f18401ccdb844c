"""Tests of `warp_mps.particles`."""
