"""Tests of `warp_mps.app.convert`."""
