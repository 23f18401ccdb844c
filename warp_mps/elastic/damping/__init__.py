"""Kelvin-Voigt damping of elastic bodies."""
