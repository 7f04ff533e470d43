"""Binds the core to network, clock and disk: node, admission, pacing, publishers, checkpoint."""
