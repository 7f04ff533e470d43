"""Moving parts: which part a robot fetches, where it goes, and what it requests of the coordinator."""
