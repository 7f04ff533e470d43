"""What one robot hears of the others, through the link's injected faults."""
