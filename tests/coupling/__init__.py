"""Tests of water and elastic bodies together."""
