"""Tests of the fluids."""
