"""Certificates for k: a proof by computation that the goal is the only minimum for every k from K on."""
