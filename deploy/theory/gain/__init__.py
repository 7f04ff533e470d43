"""Which k: the assumptions on the goals, the bounds that they give, what is measured, the rule for auto."""
