"""Tests of `warp_mps.elastic.explicit`."""
