"""A robot's node: the modules that bind its core to a bus and a wall clock."""
