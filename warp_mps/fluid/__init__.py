"""Incompressible fluids with a free surface, by the semi-implicit MPS method."""
