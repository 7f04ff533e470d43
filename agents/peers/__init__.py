"""What one robot knows of the others: fleet, roster, and what it hears through the link's injected faults."""
