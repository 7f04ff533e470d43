"""A fleet under a flood of garbage: what it costs, and what comes of it."""
