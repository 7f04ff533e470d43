"""Comparison of laws on the same scenarios."""
