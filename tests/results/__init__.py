"""Tests of `warp_mps.results`."""
