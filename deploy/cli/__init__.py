"""The command `disknav`, one file for each group. Each subcommand imports its libraries when it is called."""
