"""This software and what it runs on: what is compiled, and which code made a figure."""
