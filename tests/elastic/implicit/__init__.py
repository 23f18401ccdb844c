"""Tests of the elastic bodies."""
