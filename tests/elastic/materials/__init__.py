"""Tests of `warp_mps.elastic.materials`."""
