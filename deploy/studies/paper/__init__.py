"""Studies of the paper: its figures, sampling against the exact flow, the data behind the rule for k."""
