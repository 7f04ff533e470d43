"""What a robot is told of itself: where it is, how far it went, which way it faces."""
