"""One run from what was asked for to its result, with real processes or in this one."""
