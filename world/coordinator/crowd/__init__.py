"""What large fleets need: who hears whom, what is left out of a Tick, letters between far robots."""
