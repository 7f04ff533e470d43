"""Who takes part and who owes a command: the roster, lives, and the commands of one tick."""
