"""What joins the core to network, clock and disk: the node, admission, pacing, publishers, the checkpoint."""
