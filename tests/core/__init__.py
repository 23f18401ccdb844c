"""Tests of what every method shares."""
