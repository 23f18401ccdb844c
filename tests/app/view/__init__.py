"""Tests of `warp_mps.app.view`."""
