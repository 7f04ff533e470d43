"""Studies: tables measured over many runs, each reproducible by one command."""
