"""What robots and the world of a large fleet work out alike: who hears whom, and what need not be said."""
