"""Tests of `warp_mps.core.linear`."""
