"""Measurements of the truth: clearance, contacts, phi, deviation, trajectory, verdict."""
