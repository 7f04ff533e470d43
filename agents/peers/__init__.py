"""A robot's knowledge of its peers: fleet, roster, far disks, and States received through injected faults."""
