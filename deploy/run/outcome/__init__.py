"""What came of a run: the reports of its world, the result, and what is said where the world is gone."""
