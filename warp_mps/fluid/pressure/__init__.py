"""The pressure Poisson equation (PPE) of an incompressible fluid with a free surface.

    lap p = rho (div u*)/dt - rho e/(tau dt)

u* is the predicted velocity and e = n/n0 - 1 the error of the number density. The parts: `density` (number density and
free surface), `divergence` (div u*), `rows` (the rows of the matrix and the right-hand side), `level` (bounds on the
solution), `equation` (the class that launches them).
"""
