"""Branch and bound over boxes of configurations, multipliers and 1/k: compiled, rounded outward."""
