"""One run from its options to its result, with real processes or within this one."""
