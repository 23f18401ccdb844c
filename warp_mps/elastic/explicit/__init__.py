"""Explicit time integration of elastic bodies."""
