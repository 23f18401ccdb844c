"""Incompressible fluids with a free surface, by the semi-implicit MPS method."""

# name of the Warp modules that hold the kernels of this method
METHOD = "fluid"
