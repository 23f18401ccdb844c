"""What every method shares: number types, weights, rotations, neighbours. Knows no method."""
