"""Laws to compare with: ORCA and a barrier-function program, and the velocity that both start from."""
