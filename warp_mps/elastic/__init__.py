"""Elastic bodies: models, contact, boundary conditions, explicit and implicit time integration, readings."""

# name of the Warp module that holds the kernels of this method
METHOD = "elastic"
