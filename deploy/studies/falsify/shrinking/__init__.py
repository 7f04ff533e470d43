"""From a scenario that shows something to the smallest that still does."""
