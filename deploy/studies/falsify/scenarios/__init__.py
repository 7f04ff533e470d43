"""Scenarios drawn from all that a scenario can express, and small changes to them."""
