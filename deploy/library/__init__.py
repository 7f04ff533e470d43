"""The scenario library: the paper's figures, swaps and random instances, each a function of a seed."""
