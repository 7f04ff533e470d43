"""Moving parts: the part that a robot fetches, its goal, and its requests to the coordinator."""
