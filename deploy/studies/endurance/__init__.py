"""Fleets under strain: hours without a leak, and floods of garbage."""
