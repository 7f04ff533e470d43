"""The world: kinematics, sensing, clock, clearance and measures; a sans-I/O core and a thin process shell."""
