"""What a command leaves on the terminal, in files and as exit status."""
