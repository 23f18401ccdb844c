"""Equilibrium and implicit steps of elastic bodies: Newton's method on the Hamiltonian model, matrix-free."""
