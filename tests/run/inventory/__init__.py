"""Tests of the inventory of a case."""
