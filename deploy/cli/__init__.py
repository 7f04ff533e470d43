"""The command `disknav`: one file for each group; each subcommand imports what it needs as it is called."""
