"""Derived quantities of elastic bodies: stresses, strains, energies."""
