"""Membership and commands: the roster, lives, the ledger's keeper, and the commands of one tick."""
