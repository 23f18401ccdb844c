"""Elastic bodies: models, contact, boundary conditions, explicit and implicit time integration, readings."""
