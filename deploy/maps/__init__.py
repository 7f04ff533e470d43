"""Floor plans: occupancy grids as robots' maps store them, and the convex obstacles that stand for them."""
