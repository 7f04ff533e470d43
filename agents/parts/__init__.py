"""Movers: which part a robot fetches, where it goes for that, and what it asks to do with it."""
