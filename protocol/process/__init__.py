"""What every process has: its title, its log, and the installation that it runs from."""
