"""The processes of a fleet: table, supervisor, fork server and router."""
