"""Tests of `warp_mps.core.multigrid`."""
