"""Scenarios: the complete description of a run; its checks, and its form in TOML."""
