"""The second opinion: certificates replayed with balls of arbitrary precision (python-flint, Arb)."""
