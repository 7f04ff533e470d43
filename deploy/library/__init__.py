"""The scenario library: files, and functions of a seed for what is random or counted."""
