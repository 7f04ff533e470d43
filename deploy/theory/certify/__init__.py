"""Computer-assisted proofs that for every k from K on the goal is the only minimum of phi."""
