"""Building blocks of all methods: number types, weights, rotations, neighbour lists, linear solvers, graphs."""
