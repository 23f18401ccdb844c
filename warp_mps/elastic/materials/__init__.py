"""Constitutive laws and the constants of materials."""
