"""This software and what it runs on: what is compiled, which code made a figure, a cluster's scheduler."""
