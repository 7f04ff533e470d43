"""One run of a scenario, watched: how near it came to touching, and what it violated."""
