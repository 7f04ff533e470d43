"""Measuring a base: what it really does, and so what a scenario has to state of it."""
