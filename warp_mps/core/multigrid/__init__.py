"""The multigrid preconditioner of pressure Poisson equations."""
