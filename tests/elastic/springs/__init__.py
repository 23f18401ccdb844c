"""Tests of `warp_mps.elastic.springs`."""
