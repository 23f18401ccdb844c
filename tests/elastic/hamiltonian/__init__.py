"""Tests of `warp_mps.elastic.hamiltonian`."""
