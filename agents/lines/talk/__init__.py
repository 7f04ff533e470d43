"""What is said of lines: to near peers in States, to far ones in letters."""
