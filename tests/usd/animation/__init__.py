"""Tests of `warp_mps.usd.animation`."""
