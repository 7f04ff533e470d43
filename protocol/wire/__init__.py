"""Bytes: how messages are written and read."""
