"""What keeps jams from forming, and ends them: right of way, giving way, dispersal."""
