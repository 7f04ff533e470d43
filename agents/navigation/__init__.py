"""One robot's slice of the navigation function: its gradient, flow, pace, and the way out of deadlocks."""
