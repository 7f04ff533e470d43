"""Recordings of runs: MCAP files, written during a run, and read, checked or replayed later."""
