"""Tests of `warp_mps.elastic.boundary`."""
