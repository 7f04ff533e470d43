"""What a process may ask of a network, on zenoh and within one process; how it connects."""
