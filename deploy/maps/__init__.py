"""Floor plans: occupancy grids of robots' maps, converted to convex obstacles."""
