"""What joins the core to network, clock and disk: admission, pacing, publishers, the journal."""
