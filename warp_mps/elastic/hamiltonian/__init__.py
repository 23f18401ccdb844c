"""The Hamiltonian MPS model of elasticity."""
