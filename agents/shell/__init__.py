"""What a robot's node is made of, besides its core: everything that knows a bus or a wall clock."""
