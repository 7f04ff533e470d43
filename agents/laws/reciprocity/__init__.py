"""The law of reciprocal velocities: allowed half-planes, the velocity nearest to straight on, roundabouts."""
