"""A search for scenarios that break what is promised: random draws, mutants of near misses, shrinking."""
