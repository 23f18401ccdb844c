"""Tests of `warp_mps.elastic.damping`."""
