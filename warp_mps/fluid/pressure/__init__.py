"""The pressure Poisson equation (PPE) of an incompressible fluid with a free surface."""
