"""Boundary conditions of elastic bodies: supports and loads."""
