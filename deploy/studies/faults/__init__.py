"""Studies of late, lost and noisy states, and of everything that may go wrong at once."""
