"""A fleet on several hosts: their table, and starting processes on them by OpenSSH."""
