"""The processes of a fleet: a table of them, a supervisor that walks it, the router, how they start."""
