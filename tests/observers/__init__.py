"""Tests of `warp_mps.observers`."""
