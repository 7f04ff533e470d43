"""Bases and localisations outside: what really moves a robot, and tells it where it is."""
