"""The node of a robot: binds its core to a bus and a wall clock."""
