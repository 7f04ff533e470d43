"""Access to a run: a roster, a certificate for each role, and the router's rules."""
