"""What the world is asked for while it runs, and what it answers."""
