"""Tests of the rigid walls."""
