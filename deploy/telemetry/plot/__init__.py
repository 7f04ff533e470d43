"""Pictures and animations of recorded runs."""
