"""Tests of `warp_mps.shapes`."""
