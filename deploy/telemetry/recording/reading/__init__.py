"""Recordings read back: as messages and arrays, checked, published again, exported."""
