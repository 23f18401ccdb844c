"""Tests of `warp_mps.elastic.output`."""
