"""External bases and localisations: interfaces to hardware that moves and locates a robot."""
