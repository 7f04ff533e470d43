"""Recordings of runs: MCAP files, written while a run goes on and read, checked or replayed later."""
