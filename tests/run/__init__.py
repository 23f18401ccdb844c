"""Tests of `warp_mps.run`."""
