"""Tests of `warp_mps.scene`."""
