"""A robot's node, and what it is made of besides its core: everything that knows a bus or a wall clock."""
