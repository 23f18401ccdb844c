"""Constraints that a scene must satisfy before it can be run."""
