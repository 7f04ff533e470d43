"""A fleet over several hosts: a table of them, and processes that are started there by OpenSSH."""
