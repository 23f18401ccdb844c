"""Tests of `warp_mps.elastic.contact`."""
