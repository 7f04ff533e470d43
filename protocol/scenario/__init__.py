"""Scenarios: what determines a run, how it is checked, read from TOML and written."""
