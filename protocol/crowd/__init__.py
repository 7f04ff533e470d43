"""What robots and the world of a large fleet compute alike: which States are heard, and what is left out."""
