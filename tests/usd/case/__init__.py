"""Tests of `warp_mps.usd.case`."""
